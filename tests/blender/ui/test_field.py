"""The surgical field drawn by hand in the preview: into the EDL by the panel, and from the saved file."""

from __future__ import annotations

import pytest
from blender_recording import R, in_blender
from notes import Notes
from panel_scripts import ON

from mcsl_core import edl as edls
from mcsl_core.blender.child import run_task
from mcsl_core.blender.messages import RefreshRequest
from mcsl_core.blender.timeline import pull_overrides
from mcsl_core.edl import edits

CORNERS = ((100.0, 60.0), (200.0, 60.0), (150.0, 140.0))


@pytest.mark.both_blenders
def test_it_is_drawn_undone_and_refused(built, blender):
    code = (
        ON
        + """
    refresh.refresh_timeline(scene)
    go(25)
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.mcsl.draw_field(corners="100,60 200,60 150,140")
    drawn = scene["mcsl_drawn_fields"]
    bpy.ops.ed.undo_push(message="after")
    bpy.ops.ed.undo()
    scene = next(s for s in bpy.data.scenes if s.get("mcsl_edl"))
    out = [drawn, "mcsl_drawn_fields" in scene]
    for wrong in ("", "1,1 2,2", "1,1 2,2 3,3", "900,1 990,1 950,80", "a,b c,d e,f", "1,1,1 2,2 9,1"):
        out.append([sorted(bpy.ops.mcsl.draw_field(corners=wrong)), "mcsl_drawn_fields" in scene])
    """
    )
    drawn, there, *refused = in_blender(blender, built, code, save=False)
    assert drawn == '[[0, 30, [[[100.0, 60.0], [200.0, 60.0], [150.0, 140.0]]], ""]]'
    assert not there
    assert refused == [[["CANCELLED"], False]] * 6


def test_it_comes_into_the_edl_and_goes_from_it(built, blender):
    path = built.parent / "edl.json"
    code = (
        ON
        + """
    refresh.refresh_timeline(scene)
    go(25)
    bpy.ops.mcsl.draw_field(corners="100,60 200,60 150,140")
    out = [texts("MCSL_PT_look")]
    """
    )
    (shown,) = in_blender(blender, built, code)
    assert "Field: drawn by hand" in shown
    assert "Analyse again to use the field" in shown
    assert edls.load(path).drawn_fields == ()
    made = pull_overrides(built, blender=blender)
    assert [(drawn.range, drawn.polygons) for drawn in made.drawn_fields] == [(R(0, 30), (CORNERS,))]
    assert edls.load(path) == made
    code = (
        ON
        + """
    refresh.refresh_timeline(scene)
    bpy.ops.mcsl.draw_field(corners="10,10 50,10 30,60", more=True)
    bpy.ops.mcsl.pull_overrides()
    both = len(refresh.decided(scene).drawn_fields[0].polygons)
    kept = "mcsl_drawn_fields" in scene
    bpy.ops.mcsl.clear_field()
    bpy.ops.mcsl.pull_overrides()
    out = [both, kept]
    """
    )
    assert in_blender(blender, built, code) == [2, False], "what the EDL holds the scene need not say"
    assert edls.load(path).drawn_fields == ()


def test_one_written_into_the_edl_meanwhile_stays(built, blender):
    """Saved, not pulled; then somebody draws with `mcsl field`: neither pulling nor the panel takes that away."""
    path = built.parent / "edl.json"
    code = (
        ON
        + """
    refresh.refresh_timeline(scene)
    go(25)
    bpy.ops.mcsl.draw_field(corners="100,60 200,60 150,140")
    out = []
    """
    )
    in_blender(blender, built, code)
    theirs = edits.draw_field(edls.load(path), (CORNERS[::-1],), R(10, 20), "drain")
    edls.save(theirs, path)
    progress = Notes()
    made = pull_overrides(built, blender=blender, progress=progress)
    there = [(drawn.range, drawn.polygons[0]) for drawn in made.drawn_fields]
    assert there == [(R(0, 10), CORNERS), (R(10, 20), CORNERS[::-1]), (R(20, 30), CORNERS)]
    assert any(
        note.startswith("programme frames 11 to 20: the field drawn in this timeline is") for note in progress.notes
    )
    run_task(blender, RefreshRequest(built, path, (), None), progress)
    gone = 'out = ["mcsl_drawn_fields" in scene, "mcsl_drawn_upon" in scene]'
    assert in_blender(blender, built, gone, save=False) == [False, False], "it would come back after a --clear"
    cleared = edits.clear_field(made)
    edls.save(cleared, path)
    assert pull_overrides(built, blender=blender) == cleared


def test_corners_are_of_the_frame_they_were_clicked_in_and_what_began_ends_once(built, blender):
    """Playback may have gone on, and a window can close under an operator: it is then told by `cancel` alone."""
    code = (
        ON
        + """
    from blender_addon.ui.operators import field, look, preview
    refresh.refresh_timeline(scene)
    go(25)
    bpy.ops.mcsl.draw_field(corners="100,60 200,60 150,140", frame=40)
    out = [scene["mcsl_drawn_fields"]]
    for kind in (field.MCSL_OT_draw_field, look.MCSL_OT_set_centre):
        handler = bpy.types.SpaceSequenceEditor.draw_handler_add(print, (), "PREVIEW", "POST_PIXEL")
        preview._lines.append(handler)
        for _ in range(2):
            kind.cancel(None, bpy.context)
        out.append(len(preview._lines))
    seen = []
    for view, channel in (("SEQUENCER", 0), ("PREVIEW", 0), ("PREVIEW", 2)):
        for area in bpy.context.screen.areas:
            if area.type == "SEQUENCE_EDITOR":
                area.spaces.active.view_type, area.spaces.active.display_channel = view, channel
        seen.append([found.value for _, found in preview._previews(bpy.context)])
    out.append(seen)
    """
    )
    drawn, *left, seen = in_blender(blender, built, code, save=False)
    assert drawn.startswith("[[30, 60, "), "the perspective of frame 40, not of the playhead"
    assert left == [0, 0]
    assert seen == [[], ["programme"], ["channel"]]
