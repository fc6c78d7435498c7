"""Run by Blender with its window: sets the desk up, works on it with real keys, and takes the pictures.

    blender --gpu-backend opengl edit.blend -P window.py -- OUT

One step after another, each once the window had time to draw what the last one did. Keys and pointer go through X, as
from a person's hands. What does not come out as it should is named in OUT/window.json.
"""

import json
import os
import subprocess
import sys
import traceback
from pathlib import Path

import bpy

OUT = Path(sys.argv[-1])
WAIT_S = 3.0  # software OpenGL on a busy machine
seen = {"version": bpy.app.version_string, "wrong": []}


def scene():
    return next(s for s in bpy.data.scenes if s.get("mcsl_edl"))


def shots():
    """[start, stop, source, whether it has the colour of an override] of every Multicam strip."""
    strips = [s for s in scene().sequence_editor.strips if s.type == "MULTICAM"]
    return sorted(
        [int(s.left_handle) - 1, int(s.right_handle) - 1, s.multicam_source, s.color_tag == "COLOR_03"] for s in strips
    )


def check(what, found, expected):
    seen[what] = found
    if found != expected:
        seen["wrong"].append(f"{what}: {found}, expected {expected}")


def area(kind="SEQUENCER"):
    """The window, and of that view of the sequencer its area and its regions by type."""
    window = bpy.context.window_manager.windows[0]
    for found in window.screen.areas:
        if found.type == "SEQUENCE_EDITOR" and found.spaces.active.view_type == kind:
            return window, found, {region.type: region for region in found.regions}
    raise LookupError(kind)


def picture(name, region=None):
    """What X shows, or a region of it. Blender's own screenshot is black outside of drawing."""
    part = []
    if region is not None:
        top = bpy.context.window_manager.windows[0].height - region.y - region.height
        part = ["-crop", f"{region.width}x{region.height}+{region.x}+{top}", "+repage"]
    subprocess.run(["import", "-window", "root", *part, str(OUT / f"{name}.png")], check=True)


def hand(*words):
    subprocess.run(["xdotool", *map(str, words)], check=True)


def point(region, right=0.5, up=0.5):
    """The pointer to a place in a region, as parts of its width and height."""
    height = bpy.context.window_manager.windows[0].height
    hand("mousemove", region.x + round(region.width * right), height - region.y - round(region.height * up))


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


def go(frame):
    scene().frame_set(frame + 1)
    point(area()[2]["WINDOW"])


def longest():
    """The longest shot that no override holds in, and a key of a camera it does not show."""
    start, stop, source, _ = max((s for s in shots() if not s[3]), key=lambda s: s[1] - s[0])
    names = json.loads(scene()["mcsl_cameras"])
    on = {s["mcsl_camera"]: s.channel for s in scene().sequence_editor.strips if s.get("mcsl_camera")}
    key = next(n for n, name in enumerate(names, 1) if on[name] != source)
    return start, stop, source, key, on[names[key - 1]]


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
    window, timeline, regions = area()
    with bpy.context.temp_override(window=window, area=timeline, region=regions["WINDOW"]):
        check("pulled", list(bpy.ops.mcsl.pull_overrides()), ["FINISHED"])
    seen["nudged"] = [camera, range_]


STEPS = [
    *(arrange, tab, press, pressed, undone, again, lambda: picture("desk")),
    *(lambda: sidebar("panel-1"), lambda: scroll(8), lambda: sidebar("panel-2")),
    *(lambda: scroll(40), lambda: sidebar("panel-3"), lambda: join("panel", "panel-1", "panel-2", "panel-3")),
    *(nudge, lambda: picture("nudge"), pulled),
]


def run(index=0):
    try:
        if index == len(STEPS):
            (OUT / "window.json").write_text(json.dumps(seen, indent=1))
            os._exit(0)
        STEPS[index]()
    except BaseException:
        traceback.print_exc()
        (OUT / "window.json").write_text(json.dumps({"error": traceback.format_exc()}))
        sys.stdout.flush()
        os._exit(1)
    bpy.app.timers.register(lambda: run(index + 1), first_interval=WAIT_S)


bpy.app.timers.register(run, first_interval=WAIT_S)
