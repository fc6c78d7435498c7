"""Cameras switched by key or click, in a real Blender: what is cut, coloured, undone, and there when opened again."""

from __future__ import annotations

import pytest
from blender_recording import SWITCH_ON, R, in_blender

from mcsl_core import edl as edls
from mcsl_core.blender.timeline import pull_overrides
from mcsl_core.edl import Override

KEPT = Override(R(45, 50), camera="cam1", note="kept")
SHOTS = """
    def shots():
        scene = next(s for s in bpy.data.scenes if s.get("mcsl_edl"))  # an undo makes another object of it
        found = [s for s in scene.sequence_editor.strips if s.type == "MULTICAM"]
        return sorted([*span(s), s.multicam_source, s.color_tag == "COLOR_03"] for s in found)
    def press(frame, **how):
        scene = next(s for s in bpy.data.scenes if s.get("mcsl_edl"))
        scene.frame_set(frame + 1)
        return bpy.ops.mcsl.switch_camera("EXEC_DEFAULT", True, **how) == {"FINISHED"}
"""
AS_BUILT = [[0, 20, 4, False], [20, 40, 2, False], [40, 45, 3, False], [45, 50, 4, True], [50, 60, 3, False]]


@pytest.mark.both_blenders
def test_key_n_is_the_edls_nth_camera_not_channel_n(built, blender):
    code = SWITCH_ON + SHOTS + "    out = [shots(), press(12, number=2), shots(), press(30, number=1), shots()]"
    before, first, then, second, after = in_blender(blender, built, code)
    assert (before, first, second) == (AS_BUILT, True, True)
    assert then == [[0, 12, 4, False], [12, 20, 2, True], *AS_BUILT[1:]]
    assert after == [*then[:2], [20, 30, 2, False], [30, 40, 4, True], *AS_BUILT[2:]]
    assert pull_overrides(built, blender=blender).overrides == (
        KEPT,
        Override(R(12, 20), camera="cam2"),
        Override(R(30, 40), camera="cam1"),
    )


@pytest.mark.both_blenders
def test_the_whole_shot_and_a_name_and_what_is_no_camera(built, blender):
    code = (
        SWITCH_ON
        + SHOTS
        + """
    out = [press(35, camera="cam3", whole=True), shots(), press(35, number=3), press(35, number=4), shots()]
    out += [press(47, camera="cam3"), shots(), press(46, number=2)]
    """
    )
    done, shown, again, none, same, back, after, split = in_blender(blender, built, code)
    assert (done, again, none, back, split) == (True, False, False, True, True)
    assert shown == same == [AS_BUILT[0], [20, 40, 3, True], *AS_BUILT[2:]]
    assert after == [*shown[:3], [45, 47, 4, True], [47, 50, 3, False], AS_BUILT[4]]  # automatic again: no colour


@pytest.mark.both_blenders
def test_every_press_can_be_undone_and_done_again(built, blender):
    code = (
        SWITCH_ON
        + SHOTS
        + """
    bpy.ops.ed.undo_push(message="before")
    seen = [shots()]
    for frame, number in ((12, 2), (30, 1), (33, 3)):
        press(frame, number=number)
        seen.append(shots())
    back = []
    for _ in range(3):
        bpy.ops.ed.undo()
        back.append(shots())
    again = []
    for _ in range(3):
        bpy.ops.ed.redo()
        again.append(shots())
    out = [seen, back, again]
    """
    )
    seen, back, again = in_blender(blender, built, code, save=False)
    assert len({str(s) for s in seen}) == 4
    assert back == seen[2::-1]
    assert again == seen[1:]


def test_the_shot_at_the_playhead_needs_no_selection_and_becomes_the_active_one(built, blender):
    code = (
        SWITCH_ON
        + SHOTS
        + """
    for s in strips: s.select = s == at(6, 0)
    scene.sequence_editor.active_strip = at(6, 0)
    press(12, number=2)
    active = scene.sequence_editor.active_strip
    out = [span(active), [span(s) for s in strips if s.select]]
    """
    )
    assert in_blender(blender, built, code, save=False) == [[12, 20], [[12, 20]]]


def test_where_there_is_no_shot_it_says_so_and_elsewhere_it_leaves_the_key_to_blender(built, blender):
    code = (
        SWITCH_ON
        + SHOTS
        + """
    strips.remove(at(5, 20))
    out = [press(25, number=1), shots()]
    scene = bpy.data.scenes.new("other")
    scene.sequence_editor_create()
    bpy.context.window.scene = scene
    for w in bpy.data.workspaces:
        if hasattr(w, "sequencer_scene"): w.sequencer_scene = scene
    out.append(bpy.ops.mcsl.switch_camera.poll())
    """
    )
    pressed, shots, answers = in_blender(blender, built, code, save=False)
    assert (pressed, answers) == (False, False)
    assert shots == [AS_BUILT[0], *AS_BUILT[2:]]


def test_the_editors_own_colour_stays(built, blender):
    code = (
        SWITCH_ON
        + SHOTS
        + """
    at(5, 0).color_tag = "COLOR_07"
    press(12, number=2)
    out = [at(5, 0).color_tag, at(5, 12).color_tag, at(5, 45).color_tag]
    """
    )
    # the right part of a split has its colour from the left one: the editor's own, which is his to change
    assert in_blender(blender, built, code, save=False) == ["COLOR_07", "COLOR_07", "COLOR_03"]


def test_pressed_saved_opened_again_and_pressed_on(built, blender):
    in_blender(blender, built, SWITCH_ON + SHOTS + "    out = press(12, number=2)")
    again = SWITCH_ON + SHOTS + "    press(15, number=3); out = shots()"
    assert in_blender(blender, built, again)[:3] == [[0, 12, 4, False], [12, 15, 2, True], [15, 20, 3, True]]
    expected = (KEPT, Override(R(12, 15), camera="cam2"), Override(R(15, 20), camera="cam3"))
    assert pull_overrides(built, blender=blender).overrides == expected
    assert edls.load(built.parent / "edl.json").overrides == expected


def test_strips_are_named_after_the_camera_they_show_unless_the_editor_named_them(built, blender):
    code = (
        SWITCH_ON
        + SHOTS
        + """
    def names(): return [s.name for s in sorted(strips, key=lambda s: span(s)) if s.type == "MULTICAM"]
    out = [names()]
    at(5, 40).name = "look here"
    press(12, number=2)
    press(40, number=2)
    out.append(names())
    """
    )
    before, after = in_blender(blender, built, code, save=False)
    assert before == ["1: cam1 [1]", "2: cam2 [2]", "3: cam3 [3]", "4: cam1 [1]", "5: cam3 [3]"]
    assert after == ["1: cam1 [1]", "1: cam2 [2]", "2: cam2 [2]", "look here", "4: cam1 [1]", "5: cam3 [3]"]
