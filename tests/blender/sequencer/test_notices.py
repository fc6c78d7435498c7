"""What a person is told before a timeline is conformed, rendered or made anew."""

from __future__ import annotations

import shutil

import pytest
from blender_recording import in_blender
from notes import Notes

from mcsl_core.blender.child import run_task
from mcsl_core.blender.messages import ConformedPiece, RefreshRequest
from mcsl_core.blender.timeline import pull_overrides
from mcsl_core.timing import FrameRange


def told(built, blender, code):
    heard = Notes()
    in_blender(blender, built, code)
    pull_overrides(built, blender=blender, progress=heard)
    return heard.notes


def test_work_that_would_not_be_seen_or_kept(built, blender):
    exact = built.parent / "0000000-0000060-aa.mp4"
    shutil.copy(built.parent / "cam3.mp4", exact)
    pieces = (ConformedPiece(FrameRange(0, 60), exact),)
    run_task(blender, RefreshRequest(edl=built.parent / "edl.json", blend=built, conformed=pieces, sound=None))
    code = """
        at(5, 0).modifiers.new("grade", "BRIGHT_CONTRAST")
        at(5, 20).modifiers.new("grade", "BRIGHT_CONTRAST")
        at(5, 20).mute = True
        scene.sequence_editor.channels[7].mute = True
    """
    notes = told(built, blender, code)
    for text in (
        "strip '2: cam2 [2]', frame 21 is muted and decides nothing: your work on it (modifiers) goes",
        "strip '1: cam1 [1]', frame 1: your work on it (modifiers) is hidden by the exact pictures",
        "channel 7, Conformed, is muted",
    ):
        assert len([note for note in notes if text in note]) == 1


def test_files_that_are_missing_or_come_from_elsewhere(built, blender, tmp_path):
    elsewhere = tmp_path / "elsewhere.mp4"
    shutil.copy(built.parent / "cam3.mp4", elsewhere)
    shutil.copy(built.parent / "cam3.mp4", built.parent / "gone.mp4")
    code = f"""
        for n, name in enumerate(({str(elsewhere)!r}, bpy.path.abspath("//gone.mp4"), bpy.path.abspath("//cam3.mp4"))):
            strips.new_movie(name=f"mine {{n}}", filepath=name, channel=20 + n, frame_start=1)
        os.unlink(bpy.path.abspath("//gone.mp4"))
    """
    notes = told(built, blender, code)
    assert len(notes) == 2
    assert "strip 'mine 0', frame 1," in notes[0]
    assert "from outside this project" in notes[0]
    assert "gone.mp4, which is missing" in notes[1]


@pytest.mark.both_blenders
def test_as_built_nothing_is_said(built, blender):
    assert told(built, blender, "pass") == []
