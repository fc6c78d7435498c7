"""An editor at work: angles, a cut while it plays, what must not move, sound, idle time left out, exact pictures."""

import bpy
from hands import (
    OUT,
    area,
    check,
    go,
    hand,
    key_of_another,
    picture,
    point,
    press_button,
    scene,
    seen,
    shots,
    state,
    strips,
)


def previews():
    screen = bpy.context.window_manager.windows[0].screen
    return [a for a in screen.areas if a.type == "SEQUENCE_EDITOR" and a.spaces.active.view_type == "PREVIEW"]


def frame():
    """All of the timeline in view."""
    window, timeline, regions = area()
    with bpy.context.temp_override(window=window, area=timeline, region=regions["WINDOW"]):
        bpy.ops.sequencer.view_all()


def longest():
    return max(shots(), key=lambda s: s[1] - s[0])


# ----------------------------------------------------------------------------------------------------------- angles


def angles():
    check("one preview", len(previews()), 1)
    start, stop, *_ = longest()
    go((start + stop) // 2)
    press_button("mcsl.angles")


def angles_shown():
    cameras = {s.channel for s in scene().sequence_editor.strips if s.get("mcsl") == "camera"}
    shown = sorted(a.spaces.active.display_channel for a in previews())
    return shown != sorted([0, *cameras])  # they come one after another


def angles_away():
    picture("angles")
    press_button("mcsl.angles")


def angles_gone():
    return len(previews()) > 1


# ---------------------------------------------------------------------------------------------- a cut while it plays


def play():
    start, stop, *_ = longest()
    seen["cuts"] = len(shots())
    go(start + (stop - start) // 8)
    hand("key", "space")


def cut():
    check("it plays", bpy.context.window_manager.windows[0].screen.is_animation_playing, True)
    start, stop, source, _ = next(s for s in shots() if s[0] < scene().frame_current <= s[1])
    seen["playing"] = [start, stop, source]
    hand("key", key_of_another(source)[0])


def stop():
    hand("key", "space")


def cut_there():
    check("it stopped", bpy.context.window_manager.windows[0].screen.is_animation_playing, False)
    check("cut while it played", len(shots()) > seen["cuts"], True)


# ---------------------------------------------------------------------------------------------- what must not move


def grab():
    """All is selected and moved, as by an editor who means a title of his own."""
    editor = scene().sequence_editor
    seen["tracks"] = [strips("centering"), strips("conformed")]
    for strip in editor.strips:
        strip.select = strip.get("mcsl") in ("centering", "conformed")
    point(area()[2]["WINDOW"], 0.5, 0.5)
    hand("key", "g")


def drop():
    hand("type", "30")
    hand("key", "Return")


def stayed():
    check("locked tracks stay where they are", [strips("centering"), strips("conformed")], seen["tracks"])


def ripple():
    """A shot is deleted, and what follows it closes up, as in an editor that ripples."""
    seen["shots"], seen["cameras"] = shots(), strips("camera")
    editor = scene().sequence_editor
    middle = seen["shots"][len(seen["shots"]) // 2]
    for strip in editor.strips:
        strip.select = strip.type == "MULTICAM" and int(strip.left_handle) - 1 == middle[0]
    go(middle[0])
    hand("key", "Delete")
    hand("key", "BackSpace")


def rippled():
    if not state().notices:
        return True  # the timeline is read once it is quiet
    seen["shots after a ripple"] = shots()
    check("a ripple moves no camera", strips("camera"), seen["cameras"])
    check("and no sound", [a for a, _ in strips("sound")], [0])
    seen["told of a ripple"] = state().notices
    hand("key", "ctrl+z")
    hand("key", "ctrl+z")
    return None


def unrippled():
    return shots() != seen["shots"]


# ------------------------------------------------------------------------------------------------ sound


def microphone():
    cameras = [s["mcsl_camera"] for s in scene().sequence_editor.strips if s.get("mcsl") == "camera"]
    other = sorted(set(cameras))[-1]
    press_button("mcsl.sound_from", source=f"CAMERA {other}")
    names = [bpy.path.basename(s.sound.filepath) for s in scene().sequence_editor.strips if s.get("mcsl") == "sound"]
    check("its file is heard", [other in name for name in names], [True])
    press_button("mcsl.sound_from", source="AUTOMATIC")


def sound():
    """The editor's own work on the sound: quieter, split, one part mute."""
    editor = scene().sequence_editor
    [strip] = [s for s in editor.strips if s.get("mcsl") == "sound"]
    strip.volume = 0.5
    right = strip.split(frame=scene().frame_end // 3, split_method="SOFT")
    right.mute = True
    bpy.ops.ed.undo_push(message="Sound")
    seen["sound"] = heard()


def heard():
    found = [s for s in scene().sequence_editor.strips if s.get("mcsl") == "sound"]
    return sorted([int(s.left_handle), int(s.right_handle), round(s.volume, 3), s.mute] for s in found)


# ------------------------------------------------------------------------------------------------------ exact pictures


def conform():
    check("cut since the pictures were made", state().outstanding_s > 0, True)
    press_button("mcsl.conform")


def conformed():
    if bpy.ops.mcsl.cancel.poll():
        return True
    stands("conform")
    go(60)  # an automatic shot
    return None


def conformed_seen():
    picture("conform")


def analyse():
    press_button("mcsl.analyse")


def analysed():
    if bpy.ops.mcsl.cancel.poll():
        return True
    stands("an analysis that changes nothing")
    return None


def stands(after):
    check(f"all pictures are exact after {after}", state().outstanding_s, 0.0)
    check(f"no problem after {after}", state().problem, "")
    check(f"nothing is selected after {after}", [s.name for s in scene().sequence_editor.strips if s.select], [])
    check(f"sound after {after}", heard(), seen["sound"])


# ------------------------------------------------------------------------------------------------------------ remove


def remove():
    """The preview range by its own key: P, and a box dragged over the middle of the timeline."""
    region = area()[2]["WINDOW"]
    point(region, 0.4, 0.5)
    hand("key", "p")
    hand("mousedown", 1)
    for part in (0.45, 0.5, 0.55):
        point(region, part, 0.6)
    hand("mouseup", 1)


def removed():
    check("a preview range", scene().use_preview_range, True)
    seen["range"] = [scene().frame_preview_start - 1, scene().frame_preview_end]
    press_button("mcsl.remove")
    check("a mark lies over it", strips("removed"), [seen["range"]])
    scene().use_preview_range = False
    go(sum(seen["range"]) // 2)
    frame()


def render():
    picture("remove")
    scene().mcsl_work.preset = "review"
    scene().mcsl_work.video = str(OUT.parent / "tmp" / "window.mp4")
    press_button("mcsl.render")
    seen["delivered"] = scene().frame_end - (seen["range"][1] - seen["range"][0])


def rendered():
    if bpy.app.is_job_running("RENDER") or not (OUT.parent / "tmp" / "window.mp4").is_file():
        return True
    if len(bpy.data.scenes) > 1:
        return True  # it goes a moment later
    return None


def back():
    scene().use_preview_range = True
    scene().frame_preview_start, scene().frame_preview_end = seen["range"][0] + 1, seen["range"][1]
    press_button("mcsl.bring_back")
    scene().use_preview_range = False
    check("no mark is left", strips("removed"), [])


STEPS = [
    *(frame, angles, angles_shown, lambda: None, angles_away, angles_gone),
    *(play, cut, stop, cut_there),
    *(grab, drop, stayed, ripple, rippled, unrippled),
    *(microphone, sound, conform, conformed, conformed_seen, analyse, analysed),
    *(remove, removed, lambda: None, render, rendered, back),
]
