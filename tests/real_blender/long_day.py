"""Two hours, five cameras, 430 shots: built into a new file, looked at, and cut."""

import time
from itertools import pairwise

import bpy
from hands import OUT, area, check, go, hand, key_of_another, picture, press_button, scene, seen, shots, state

EDL = OUT.parent / "long" / "edl.json"


def new():
    bpy.ops.wm.read_homefile(app_template="Video_Editing", use_factory_startup=False)


def build():
    bpy.ops.wm.save_as_mainfile(filepath=str(EDL.with_suffix(".blend")))
    began = time.process_time()
    press_button("mcsl.build_timeline", filepath=str(EDL))
    seen["built in CPU s"] = round(time.process_time() - began, 2)


def look():
    found = shots()
    seen["shots"], seen["frames"] = len(found), found[-1][1]
    check("every shot follows the one before", all(a[1] == b[0] for a, b in pairwise(found)), True)
    check("nothing is selected", [s.name for s in scene().sequence_editor.strips if s.select], [])
    check("no problem", state().problem, "")
    picture("long-day")


def cut():
    """In the middle of the longest shot of the second hour."""
    window, timeline, regions = area()
    start, stop, source, _ = max((s for s in shots() if s[0] > seen["frames"] // 2), key=lambda s: s[1] - s[0])
    go((start + stop) // 2)
    with bpy.context.temp_override(window=window, area=timeline, region=regions["WINDOW"]):
        bpy.ops.sequencer.view_frame()
    hand("key", key_of_another(source)[0])


def cut_there():
    check("a cut", len(shots()) > seen["shots"], True)
    press_button("mcsl.pull_overrides")


STEPS = [new, lambda: None, build, lambda: None, lambda: None, look, cut, cut_there]
