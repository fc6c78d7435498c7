"""The surgical field drawn in the preview: where its corners lie in the EDL, and over which frames they hold."""

from __future__ import annotations

import attrs
import pytest
from builders import R, small_edl, state_of

from blender_addon.core.field import (
    FoundDrawing,
    from_text,
    remarks_on_drawing,
    stretch_at,
    take_drawing,
    to_text,
    with_field,
    without_field,
)
from blender_addon.core.read_overrides import read_edl
from blender_addon.core.strip_plan import make_plan
from mcsl_core.edl import DrawnField

CORNERS = ((100.0, 60.0), (200.0, 60.0), (150.0, 140.0))
OTHER, THIRD = (tuple((x + by, y + 20) for x, y in CORNERS) for by in (10, 20))


def three_poses():
    """The perspective changes at 200; up to there two poses share one."""
    pose = small_edl().poses[0]
    ends = ((0, 80, 0), (80, 200, 0), (200, 300, 1))
    return small_edl(poses=tuple(attrs.evolve(pose, range=R(a, b), perspective=p) for a, b, p in ends))


def test_corners_hold_as_far_as_the_perspective_does():
    edl = three_poses()
    assert [stretch_at(edl, frame) for frame in (0, 90, 199, 200)] == [R(0, 200)] * 3 + [R(200, 300)]
    made = with_field(edl, 90, CORNERS)
    assert made.drawn_fields == (DrawnField(R(0, 200), (CORNERS,)),)
    both = with_field(made, 250, CORNERS[::-1])
    assert [drawn.range for drawn in both.drawn_fields] == [R(0, 200), R(200, 300)]
    assert without_field(both, 10).drawn_fields == both.drawn_fields[1:]


def test_what_is_clicked_in_the_shifted_picture_lies_where_the_field_does():
    edl = attrs.evolve(small_edl(), centering=((0, 30.0, -10.0),))
    made = with_field(edl, 50, [(x + 30, y - 10) for x, y in CORNERS])
    assert made.drawn_fields[0].polygons == (CORNERS,)
    off = attrs.evolve(edl, look=attrs.evolve(edl.look, centering=False))
    assert with_field(off, 50, CORNERS).drawn_fields[0].polygons == (CORNERS,)


def test_another_region_stands_beside_what_is_drawn():
    one = with_field(small_edl(), 50, CORNERS)
    assert with_field(one, 50, OTHER, more=True).drawn_fields[0].polygons == (CORNERS, OTHER)
    assert with_field(one, 50, OTHER).drawn_fields[0].polygons == (OTHER,)


def test_fields_drawn_for_other_stretches_of_a_perspective_stay():
    first, second = DrawnField(R(0, 80), (CORNERS,), "wound"), DrawnField(R(80, 200), (OTHER,), "drain")
    edl = small_edl(drawn_fields=(first, second))
    more = with_field(edl, 10, THIRD, more=True).drawn_fields
    assert more == tuple(attrs.evolve(f, polygons=(*f.polygons, THIRD)) for f in (first, second)), "notes too"
    assert with_field(edl, 10, THIRD).drawn_fields == (second, DrawnField(R(0, 80), (THIRD,)))
    assert without_field(edl, 10).drawn_fields == (second,)
    beyond = with_field(edl, 250, THIRD, more=True).drawn_fields
    assert beyond == (first, second, DrawnField(R(200, 300), (THIRD,))), "where nothing is drawn it stands alone"
    assert without_field(edl, 250) == edl


def test_what_the_scene_keeps_reads_back_and_odd_text_is_told():
    fields = with_field(three_poses(), 90, CORNERS).drawn_fields
    assert from_text(to_text(fields)) == fields
    flat = '[[0, 9, [[[0, 0], [1, 1]]], ""]]'
    for odd in ("", "{", "3", "[[1]]", "null", '[[0, 9, [[["a", 1]]], ""]]', flat, "[[9, 0, [], 1]]"):
        with pytest.raises((ValueError, TypeError)):
            from_text(odd)


def test_the_scene_says_nothing_or_all():
    edl = with_field(small_edl(), 50, CORNERS)
    untouched = state_of(make_plan(edl))
    assert read_edl(edl, untouched) == edl
    assert read_edl(edl, attrs.evolve(untouched, drawing=FoundDrawing(()))).drawn_fields == ()


@pytest.mark.parametrize("upon", [None, ()])
def test_what_is_drawn_past_the_end_is_told_and_the_rest_taken(upon):
    """It may not stop the reading that drawing anew and clearing begin with."""
    drawing = FoundDrawing((DrawnField(R(0, 900), (CORNERS,)), DrawnField(R(900, 950), (OTHER,))), upon)
    new = read_edl(small_edl(), attrs.evolve(state_of(make_plan(small_edl())), drawing=drawing))
    assert new.drawn_fields == (DrawnField(R(0, 300), (CORNERS,)),)
    assert remarks_on_drawing(new, drawing) == ("what is drawn past the programme's 300 frames is not taken",)


MINE, THEIRS, BASE = (DrawnField(R(0, 100), (p,), note) for p, note in ((CORNERS, ""), (OTHER, "wound"), (THIRD, "")))


@pytest.mark.parametrize(
    ("mine", "upon", "theirs", "fields", "refused"),
    [
        ((MINE,), (), (), (MINE,), ()),  # only drawn here
        ((MINE,), (BASE,), (BASE,), (MINE,), ()),
        ((BASE,), (BASE,), (THEIRS,), (THEIRS,), ()),  # only there
        ((), (BASE,), (THEIRS,), (THEIRS,), (R(0, 100),)),  # taken away here, drawn anew there
        ((MINE,), (), (THEIRS,), (THEIRS,), (R(0, 100),)),
        ((MINE,), (BASE,), (), (), (R(0, 100),)),  # drawn anew here, taken away there
        ((MINE,), (), (MINE,), (MINE,), ()),  # pulled already
        ((), (BASE,), (BASE, attrs.evolve(THEIRS, range=R(200, 300))), (attrs.evolve(THEIRS, range=R(200, 300)),), ()),
        (
            (MINE,),
            (),
            (attrs.evolve(THEIRS, range=R(60, 200)),),
            (attrs.evolve(MINE, range=R(0, 60)), attrs.evolve(THEIRS, range=R(60, 200))),
            (R(60, 100),),
        ),
    ],
)
def test_a_field_written_meanwhile_is_not_lost_and_what_is_not_taken_is_told(mine, upon, theirs, fields, refused):
    edl, drawing = small_edl(drawn_fields=theirs), FoundDrawing(mine, upon)
    taken = take_drawing(edl, drawing)
    assert (taken.fields, taken.refused) == (fields, refused)
    told = remarks_on_drawing(edl, drawing)
    assert [note.split(":")[0] for note in told] == [f"programme frames {r.start + 1} to {r.stop}" for r in refused]
    again = attrs.evolve(edl, drawn_fields=fields)
    assert take_drawing(again, drawing).fields == fields, "a second pull changes nothing"


def test_a_drawing_of_an_older_file_is_taken_and_what_it_replaces_told():
    edl, drawing = small_edl(drawn_fields=(attrs.evolve(THEIRS, range=R(60, 200)),)), FoundDrawing((MINE,))
    assert take_drawing(edl, drawing).fields == (MINE,)
    (note,) = remarks_on_drawing(edl, drawing)
    assert note.startswith("programme frames 61 to 200: the field drawn in the EDL gives way")
