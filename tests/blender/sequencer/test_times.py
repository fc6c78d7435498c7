"""Edits of time itself, as Blender makes them, are refused by pull and before a render; nothing is written."""

from __future__ import annotations

import pytest
from blender_recording import in_blender
from notes import Notes

from mcsl_core.blender.render import render
from mcsl_core.blender.timeline import pull_overrides
from mcsl_core.errors import InputError

READY = """
for w in bpy.data.workspaces:
    if hasattr(w, "sequencer_scene"): w.sequencer_scene = scene
"""


def refused(built, blender, code, match):
    in_blender(blender, built, READY + code)
    before = (built.parent / "edl.json").read_bytes()
    with pytest.raises(InputError, match=match):
        pull_overrides(built, blender=blender)
    out = built.parent / "out.mp4"
    with pytest.raises(InputError, match=match):
        render(built, out, preset="review", blender=blender)
    assert not out.exists()
    assert not (built.parent / "edl.conformed").exists()
    assert (built.parent / "edl.json").read_bytes() == before


RIPPLE = """
for s in strips:
    if span(s)[0] >= 40: s.frame_start -= 10 if s.type != "MULTICAM" else 0
for s in sorted((s for s in strips if s.type == "MULTICAM"), key=span):
    if span(s)[0] >= 40: cut(s, span(s)[0] - 10, span(s)[1] - 10)
"""
SHOTS_ALONE = """
strips.remove(at(5, 40))
for s in sorted((s for s in strips if s.type == "MULTICAM"), key=span):
    if span(s)[0] >= 40: s.frame_start -= 5
"""


@pytest.mark.both_blenders
@pytest.mark.parametrize(
    ("code", "match"),
    [
        (RIPPLE, "frame 31: stands 10 frames earlier than it was recorded.*cannot be cut"),
        (SHOTS_ALONE, r"strip '4: cam1 \[1\]', frame 41: and the 1 after it stand 5 frames earlier"),
        ("for s in strips: s.select = True\nbpy.ops.sequencer.gap_insert(frames=7)", "stands 7 frames later"),
        ("at(3, 10).frame_start += 2", r"camera strip 'cam3', frame 3: stands 2 frames later"),
        ("s = at(3, 10); a, b = span(s); s.frame_start += 2; cut(s, a, b)", "frame 1: stands 2 frames later"),
        ("at(2, 10).use_reverse_frames = True", r"camera strip 'cam2', frame 4: is reversed"),
        ("at(2, 10).strobe = 3", "is shown every 3 frames"),
        ("scene.render.fps, scene.render.fps_base = 50, 1.0", r"runs at 50 frames/s, the programme at 29\.97"),
        ("scene.render.fps_base = 1.0", "runs at 30 frames/s"),
        ("scene.frame_step = 2", "every 2. frame"),
        ("scene.render.frame_map_new = 50", "stretched time"),
        (
            "m = strips.new_meta(name='group', channel=30, frame_start=1); at(3, 10).move_to_meta(m)",
            "strip 'cam3', frame 1: is a camera strip of this timeline inside a meta strip",
        ),
    ],
)
def test_time_that_was_changed_is_refused(built, blender, code, match):
    refused(built, blender, code, match)


def test_a_retimed_camera_is_refused(built, blender):
    code = """
for s in strips: s.select = s == at(3, 40)
scene.sequence_editor.active_strip = at(3, 40)
bpy.ops.sequencer.retiming_segment_speed_set(speed=50.0)
"""
    refused(built, blender, code, "camera strip 'cam3.001', frame 31: is retimed")


def test_a_timeline_that_does_not_say_where_its_strips_were_laid(built, blender):
    code = "[s.pop('mcsl_placed', None) for s in strips]\nat(3, 10).frame_start += 2"
    refused(built, blender, code, "camera strip 'cam3', frame 3: stands 2 frames later")


@pytest.mark.slow
def test_exact_pictures_out_of_time_are_refused(built, blender):
    render(built, built.parent / "out.mp4", preset="review", blender=blender)
    for code, match in (
        ("at(7, 0).frame_start += 3", "conformed strip 'conformed', frame 4: stands 3 frames later"),
        ("s = strips['conformed']; s.frame_start -= 3; cut(s, 0, 80)", "drawn out beyond its pictures"),
    ):
        in_blender(blender, built, READY + code)
        with pytest.raises(InputError, match=match):
            pull_overrides(built, blender=blender)


def test_what_may_be_meant_so_is_told(built, blender):
    code = """
        scene.frame_start, scene.frame_end = 11, 30
        scene.render.resolution_x = 200
        for s in strips:
            if s.type == "SOUND": s.frame_start -= 2
    """
    in_blender(blender, built, code)
    heard = Notes()
    pull_overrides(built, blender=blender, progress=heard)
    notes = heard.notes
    assert [n for n in notes if "renders frames 11 to 30" in n or "200 x 180" in n or "2 frames earlier" in n] == notes
    assert len(notes) == 4
