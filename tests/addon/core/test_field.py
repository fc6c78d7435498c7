"""The surgical field drawn in the preview: where its corners lie in the EDL, and over which frames they hold."""

from __future__ import annotations

import attrs
import pytest
from builders import R, small_edl, state_of

from blender_addon.core.field import from_text, stretch_at, to_text, with_field, without_field
from blender_addon.core.read_overrides import read_edl
from blender_addon.core.strip_plan import make_plan
from mcsl_core.edl import DrawnField
from mcsl_core.errors import InputError

CORNERS = ((100.0, 60.0), (200.0, 60.0), (150.0, 140.0))


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
    other = tuple((x + 10, y + 20) for x, y in CORNERS)
    assert with_field(one, 50, other, more=True).drawn_fields[0].polygons == (CORNERS, other)
    assert with_field(one, 50, other).drawn_fields[0].polygons == (other,)


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
    assert read_edl(edl, attrs.evolve(untouched, drawn_fields=())).drawn_fields == ()
    with pytest.raises(InputError, match="past the programme's 300 frames"):
        read_edl(edl, attrs.evolve(untouched, drawn_fields=(DrawnField(R(0, 900), (CORNERS,)),)))
