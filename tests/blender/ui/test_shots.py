"""From cut to cut, cuts that nobody sees, shots too short to be seen, tracks on which nothing is moved by mistake."""

from __future__ import annotations

import pytest
from blender_recording import SWITCH_ON, in_blender, write_camera

LEFT = """
    def shots():
        return sorted([*span(s), s.multicam_source] for s in strips if s.type == "MULTICAM")
    state = bpy.context.window_manager.mcsl_state
    from blender_addon.ui import refresh
    refresh.refresh_timeline(scene)
"""


@pytest.mark.both_blenders
def test_from_cut_to_cut(built, blender):
    code = """
    def go(frame, direction):
        scene.frame_set(frame + 1)
        done = bpy.ops.mcsl.go_to_cut(direction=direction) == {"FINISHED"}
        return scene.frame_current - 1 if done else None
    out = [go(0, "NEXT"), go(20, "NEXT"), go(50, "NEXT"), go(47, "BACK"), go(20, "BACK"), go(0, "BACK")]
    """
    assert in_blender(blender, built, SWITCH_ON + LEFT + code) == [20, 40, None, 45, 0, None]


@pytest.mark.both_blenders
def test_cuts_that_nobody_sees_go_and_an_editors_work_stays(built, blender):
    code = """
    for frame in (5, 12, 25, 33):
        shot = at(5, frame)
        shot.split(frame=frame + 1, split_method="SOFT")
    at(5, 34).blend_alpha = 0.5
    before, short = shots(), state.short_shots
    done = bpy.ops.mcsl.join() == {"FINISHED"}
    out = [before, done, shots(), at(5, 34).blend_alpha, bpy.ops.mcsl.join() == {"FINISHED"}, state.short_shots]
    """
    before, done, after, worked, again, short = in_blender(blender, built, SWITCH_ON + LEFT + code)
    assert [row[:2] for row in before[:3]] == [[0, 5], [5, 12], [12, 20]]
    assert (done, again) == (True, False)
    assert after == [[0, 20, 4], [20, 33, 2], [33, 40, 2], [40, 45, 3], [45, 50, 4], [50, 60, 3]]
    assert worked == 0.5
    assert short == 2  # [40, 45) and [45, 50)


def test_nothing_is_moved_by_mistake(built, blender):
    """Tracks of ours are locked; what conform puts in place is not selected, what the editor selected is."""
    write_camera(built.parent / "0000000-exact.mp4", "cam1", 30)
    code = """
    from pathlib import Path
    from blender_addon.sequencer import conformed
    from blender_addon.sequencer.scene_properties import edl_of
    from mcsl_core.blender.messages import ConformedPiece
    from mcsl_core.timing import FrameRange
    channels = scene.sequence_editor.channels
    locked = [c.name for c in channels if c.lock]
    mine = strips.new_effect(name="mine", type="COLOR", channel=20, frame_start=1, **(
        {"length": 10} if bpy.app.version >= (5, 0, 0) else {"frame_end": 11}))
    mine.select = True
    pieces = [ConformedPiece(range=FrameRange(0, 30), path="0000000-exact.mp4")]
    for _ in conformed.insert(scene, edl_of(scene), pieces, None, Path(bpy.data.filepath).parent): pass
    out = [locked, [s.name for s in strips if s.select]]
    """
    locked, selected = in_blender(blender, built, SWITCH_ON + code)
    assert sorted(locked) == ["Centering", "Conformed"]
    assert selected == ["mine"]


def test_a_deleted_shot_is_told_and_laid_again(built, blender):
    """The video has the analysis' camera there; the preview, with nothing to go by, the topmost one."""
    code = """
    before = shots()
    scene.sequence_editor.strips.remove(at(5, 25))
    refresh.refresh_timeline(scene)
    told = state.notices
    scene.frame_set(30 + 1)
    done = bpy.ops.mcsl.revert() == {"FINISHED"}
    out = [told, done, shots() == before, "no shot" in state.notices, at(5, 25).name]
    """
    told, done, restored, still, name = in_blender(blender, built, SWITCH_ON + LEFT + code)
    assert "frames 21 to 40 have no shot" in told
    assert (done, restored, still, name) == (True, True, False, "2: cam2 [2]")


def test_a_muted_shot_keeps_its_place_and_what_it_leaves_empty_is_told(built, blender):
    """Muted on its own channel the shot cannot be laid beside it; on another channel it is in nobody's way."""
    code = """
    at(5, 25).mute = True
    refresh.refresh_timeline(scene)
    before, told = shots(), state.notices
    scene.frame_set(30 + 1)
    done = bpy.ops.mcsl.revert() == {"FINISHED"}
    out = [told, done, shots() == before, at(5, 25).mute]
    at(5, 25).channel = 20
    bpy.ops.mcsl.revert()
    refresh.refresh_timeline(scene)
    out += [shots(), [[s.channel, *span(s)] for s in strips if s.type == "MULTICAM" and s.mute], state.notices]
    """
    told, done, same, muted, after, off, still = in_blender(blender, built, SWITCH_ON + LEFT + code, save=False)
    assert "frames 21 to 40 show no shot, because strip '2: cam2 [2]' is muted" in told
    assert (done, same, muted) == (True, True, True)
    assert after.count([20, 40, 2]) == 2
    assert off == [[20, 20, 40]]
    assert "show no shot" not in still
