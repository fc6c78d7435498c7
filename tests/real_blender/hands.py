"""What a person has at the desk, for scripts that work in Blender's window: eyes, keys and a pointer.

Keys and pointer go through X, as from a person's hands. What does not come out as it should is kept in `seen`.
"""

import json
import subprocess
import sys
from pathlib import Path

import bpy

OUT = Path(sys.argv[-2])
WAIT_S = 3.0  # software OpenGL on a busy machine
seen = {"version": bpy.app.version_string, "wrong": []}


def scene():
    return next(s for s in bpy.data.scenes if s.get("mcsl_edl"))


def state():
    """What the panel shows."""
    return bpy.context.window_manager.mcsl_state


def shots():
    """[start, stop, source, whether it has the colour of an override] of every Multicam strip."""
    strips = [s for s in scene().sequence_editor.strips if s.type == "MULTICAM"]
    return sorted(
        [int(s.left_handle) - 1, int(s.right_handle) - 1, s.multicam_source, s.color_tag == "COLOR_03"] for s in strips
    )


def key_of_another(source):
    """The key of a camera that is not the one on channel ``source``, and that camera's channel."""
    names = json.loads(scene()["mcsl_cameras"])
    on = {s["mcsl_camera"]: s.channel for s in scene().sequence_editor.strips if s.get("mcsl_camera")}
    key = next(n for n, name in enumerate(names, 1) if on[name] != source)
    return key, on[names[key - 1]]


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


def strips(role):
    """[start, stop] of every strip with that role, in order."""
    found = [s for s in scene().sequence_editor.strips if s.get("mcsl") == role]
    return sorted([int(s.left_handle) - 1, int(s.right_handle) - 1] for s in found)


def go(frame):
    scene().frame_set(frame + 1)
    point(area()[2]["WINDOW"])


def press_button(name, **settings):
    """As a click on a button of the panel: its operator, called from the timeline."""
    window, timeline, regions = area()
    group, name = name.split(".")
    with bpy.context.temp_override(window=window, area=timeline, region=regions["WINDOW"]):
        check(
            f"{name} {settings or ''}".strip(), list(getattr(getattr(bpy.ops, group), name)(**settings)), ["FINISHED"]
        )
