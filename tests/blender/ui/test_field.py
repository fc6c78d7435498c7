"""The surgical field drawn by hand in the preview: into the EDL by the panel, and from the saved file."""

from __future__ import annotations

import pytest
from blender_recording import R, in_blender
from panel_scripts import ON

from mcsl_core import edl as edls
from mcsl_core.blender.timeline import pull_overrides

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
