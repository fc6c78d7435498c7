"""The cut written for another editor by the button, with what was decided in the timeline just before."""

from __future__ import annotations

from blender_recording import in_blender
from interchange_readers import by_otio
from panel_scripts import MCSL, ON

from mcsl_core import edl as edls


def test_the_button_writes_what_the_timeline_says_now(built, blender):
    code = (
        ON
        + MCSL
        + """
    at(5, 0).multicam_source = 2
    bpy.ops.mcsl.export(filepath=bpy.data.filepath.replace("edit.blend", "cut ü.x"), kind=".otio")
    out = [wait(120).outcome, job_runner.desk.message]
    """
    )
    outcome, message = in_blender(blender, built, code, save=False)
    assert outcome == "done", message
    timeline = by_otio((built.parent / "cut ü.otio").read_bytes())
    first = timeline.video_tracks()[-1].find_clips()[0]  # before it cam2 has no picture yet
    assert first.name == "cam2"
    assert first.range_in_parent().start_time.value < 20
    assert edls.load(built.parent / "edl.json").overrides[-1].camera == "cam2"
