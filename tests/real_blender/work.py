"""Keys cut and undo, a nudge is pulled; the desk, its panel and the nudge as pictures."""

import subprocess

import bpy
from hands import OUT, area, check, go, hand, key_of_another, picture, point, press_button, scene, seen, shots

# ------------------------------------------------------------------------------------------------------- the desk


def arrange():
    window = bpy.context.window_manager.windows[0]
    window.workspace = bpy.data.workspaces["Video Editing"]
    _, timeline, _ = area()
    timeline.spaces.active.show_region_ui = True


def tab():
    """Our tab in front: it can be chosen once the sidebar was drawn."""
    window, timeline, regions = area()
    regions["UI"].active_panel_category = "mcsl"
    with bpy.context.temp_override(window=window, area=timeline, region=regions["WINDOW"]):
        bpy.ops.sequencer.view_all()
    window, preview, regions = area("PREVIEW")
    with bpy.context.temp_override(window=window, area=preview, region=regions["PREVIEW"]):
        bpy.ops.sequencer.view_all_preview()


# ------------------------------------------------------------------------------------------------------- the keys


def longest():
    """The longest shot that no override holds in, and a key of a camera it does not show."""
    start, stop, source, _ = max((s for s in shots() if not s[3]), key=lambda s: s[1] - s[0])
    return start, stop, source, *key_of_another(source)


def press():
    start, stop, _source, key, _channel = seen["plan"] = longest()
    seen["before"] = shots()
    go((start + stop) // 2)
    hand("key", key)


def pressed():
    start, stop, source, _, channel = seen["plan"]
    middle = (start + stop) // 2
    expected = [s for s in seen["before"] if s[0] != start]
    expected += [[start, middle, source, False], [middle, stop, channel, True]]
    check("after the key", shots(), sorted(expected))
    hand("key", "ctrl+z")


def undone():
    check("after Ctrl-Z", shots(), seen["before"])
    hand("key", "ctrl+shift+z")


def again():
    start, stop = seen["plan"][:2]
    check(
        "after Ctrl-Shift-Z",
        [s[:2] for s in shots() if start <= s[0] < stop],
        [[start, (start + stop) // 2], [(start + stop) // 2, stop]],
    )
    start, stop = max((s for s in shots() if not s[3]), key=lambda s: s[1] - s[0])[:2]
    go((start + stop) // 2)  # the picture is of an automatic shot, with its exact pictures
    point(area()[2]["WINDOW"], 0.5, 0.02)


# ------------------------------------------------------------------------------------------------------ the panel


def scroll(clicks):
    """The sidebar, by the wheel."""
    point(area()[2]["UI"])
    for _ in range(clicks):
        hand("click", 5)


def sidebar(name):
    picture(name, area()[2]["UI"])


def join(name, *parts):
    """Pictures side by side, and the parts away."""
    paths = [OUT / f"{part}.png" for part in parts]
    subprocess.run(["convert", *map(str, paths), "+append", str(OUT / f"{name}.png")], check=True)
    for path in paths:
        path.unlink()


# ------------------------------------------------------------------------------------------------------- a nudge


def nudge():
    """As from the strip's transform fields: Blender lets nobody grab a strip in the preview that others cover."""
    start, stop, source, _ = max(shots(), key=lambda s: s[1] - s[0])
    frame = (start + stop) // 2
    go(frame)
    editor = scene().sequence_editor
    for strip in editor.strips:
        lies = int(strip.left_handle) - 1 <= frame < int(strip.right_handle) - 1
        strip.select = strip.channel == source and lies
        if strip.select:
            editor.active_strip = strip
    editor.channels["Conformed"].mute = True
    transform = editor.active_strip.transform
    transform.offset_x, transform.offset_y = transform.offset_x + 24, transform.offset_y - 10
    bpy.ops.ed.undo_push(message="Move strip")


def pulled():
    editor = scene().sequence_editor
    editor.channels["Conformed"].mute = False
    camera, range_ = editor.active_strip["mcsl_camera"], int(editor.active_strip.left_handle)
    press_button("mcsl.pull_overrides")
    seen["nudged"] = [camera, range_]


STEPS = [
    *(arrange, tab, press, pressed, undone, again, lambda: picture("desk")),
    *(lambda: sidebar("panel-1"), lambda: scroll(8), lambda: sidebar("panel-2")),
    *(lambda: scroll(40), lambda: sidebar("panel-3"), lambda: join("panel", "panel-1", "panel-2", "panel-3")),
    *(nudge, lambda: picture("nudge"), pulled),
]
