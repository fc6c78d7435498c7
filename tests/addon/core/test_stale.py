"""Where conformed pictures hold: told by frames, checked against counting frame by frame."""

from __future__ import annotations

import attrs
import pytest
import relief_scene as scene
from builders import R, small_edl
from hypothesis import given
from hypothesis import strategies as st
from strategies import edls, ranges, tilings

from blender_addon.core import stale as o
from mcsl_core.edl import Correction, Look, MadeBy, Movement, MovementView, Override, Shot, dumps, loads
from mcsl_core.timing import check_tiles, joined

EDL = small_edl(centering=((0, 5.0, 0.0), (150, 9.0, 1.0)))
SHIFT = ((1.0, 0.0, 4.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def falls(**fields) -> tuple:
    """Where the pictures made for EDL fall away when these fields of it change."""
    return o.changed(o.basis_of(attrs.evolve(EDL, **fields)), o.basis_of(EDL))


def test_the_same_decisions_keep_every_picture():
    assert falls() == ()


@pytest.mark.parametrize(
    ("fields", "where"),
    [
        ({"overrides": (Override(R(20, 40), camera="cam3"),)}, (R(20, 40),)),
        ({"overrides": (Override(R(20, 40), camera="cam1", note="as it was"),)}, ()),
        ({"overrides": (Override(R(20, 40), fill=False), Override(R(40, 50), colour=False))}, (R(20, 50),)),
        ({"overrides": (Override(R(90, 110), offset=(3.0, 4.0)),)}, (R(90, 110),)),
        ({"overrides": (Override(R(90, 110), centering=False, offset=(3.0, 4.0)),)}, (R(90, 110),)),
        ({"look": Look(fill=False)}, (R(0, 300),)),
        ({"centering": ((0, 5.0, 0.0),)}, (R(0, 300),)),
        ({"shots": (Shot(R(0, 120), "cam1"), Shot(R(120, 200), "cam2"), Shot(R(200, 300), "cam3"))}, (R(100, 120),)),
        ({"shots": tuple(attrs.evolve(s, why="other words", score=0.5) for s in EDL.shots)}, ()),
        ({"made_by": MadeBy("1", {}, {"filler": "reference (mcsl 1)"})}, (R(0, 300),)),
        ({"corrections": (Correction(R(0, 300), "cam3", SHIFT),)}, (R(0, 300),)),  # the fill takes from every camera
    ],
    ids=str,
)
def test_what_falls_away(fields, where):
    assert falls(**fields) == where


def test_without_fill_a_correction_touches_that_cameras_shots_alone():
    plain = attrs.evolve(EDL, look=Look(fill=False))
    moved = attrs.evolve(plain, corrections=(Correction(R(0, 300), "cam3", SHIFT),))
    assert o.changed(o.basis_of(moved), o.basis_of(plain)) == (R(200, 300),)


def test_a_drift_of_colours_touches_the_shots_that_it_is_seen_in():
    plain = attrs.evolve(EDL, look=Look(fill=False))
    pose = attrs.evolve(EDL.poses[0], colour_keys={"cam3": ((0, 1.0, 1.0, 1.0), (250, 1.1, 1.0, 0.9))})
    drifting = attrs.evolve(plain, poses=(pose,))
    assert o.changed(o.basis_of(drifting), o.basis_of(plain)) == (R(200, 300),)


def test_a_relief_counts_where_pictures_are_laid_by_it_alone():
    relief = scene.pose_of(10, EDL.size).relief
    own = {EDL.cameras[1].name: relief.projections["b"]}
    made = attrs.evolve(EDL.poses[0], relief=attrs.evolve(relief, projections=own))
    with_it = attrs.evolve(EDL, poses=(made, *EDL.poses[1:]))
    assert o.changed(o.basis_of(with_it), o.basis_of(EDL)) == (made.range,)
    off = attrs.evolve(with_it, look=attrs.evolve(EDL.look, surface=False))
    assert o.changed(o.basis_of(off), o.basis_of(EDL)) == ()


def test_a_text_that_is_not_ours_holds_nothing():
    for text in ("", "null", "[[3]]", "[[0, 'a']]", '[[5, "a"], [4, "b"]]'):
        assert o.from_text(text) == ()
    assert o.changed(o.basis_of(EDL), ()) == (R(0, 300),)


@given(edls())
def test_the_basis_tiles_and_survives_saving(edl):
    basis = o.basis_of(edl)
    check_tiles((piece for piece, _ in basis), edl.frames, "basis")
    assert o.from_text(o.to_text(basis)) == basis
    assert o.basis_of(loads(dumps(edl))) == basis


def frames(pieces) -> set[int]:
    return {frame for piece in pieces for frame in range(piece.start, piece.stop)}


@st.composite
def bases(draw, length: int) -> o.Basis:
    return tuple((piece, draw(st.sampled_from("abc"))) for piece in draw(tilings(length)))


def says(basis: o.Basis, frame: int) -> str | None:
    return next((digest for piece, digest in basis if frame in piece), None)


@given(st.data())
def test_changed_is_where_a_frame_says_otherwise(data):
    first, second = (data.draw(bases(data.draw(st.integers(1, 40)))) for _ in range(2))
    found = o.changed(first, second)
    assert frames(found) == {f for f in range(40) if says(first, f) != says(second, f)}
    assert all(a.stop < b.start for a, b in zip(found, found[1:], strict=False)), "as few as can be"


@given(st.lists(ranges(40), max_size=6))
def test_what_no_picture_covers_is_outstanding(pieces):
    assert frames(o.outstanding(40, pieces)) == set(range(40)) - frames(pieces)


@given(ranges(40), st.lists(ranges(40), max_size=6))
def test_parts_tile_the_strip_and_hold_where_nothing_is_gone(strip, holes):
    gone = joined(holes)
    found = o.parts(strip, gone)
    assert [part.range.start for part in found] == [strip.start, *(part.range.stop for part in found[:-1])]
    assert found[-1].range.stop == strip.stop
    assert frames(part.range for part in found if part.holds) == frames([strip]) - frames(gone)


def test_a_movement_that_is_followed_otherwise_touches_its_frames_alone():
    def moving(shift):
        views = tuple(MovementView(f, {"cam2": ((1.0, 0.0, shift * f), *SHIFT[1:])}) for f in (96, 110, 124))
        return attrs.evolve(EDL, movements=(Movement(R(100, 120), 1.0, views),))

    held = attrs.evolve(EDL, movements=(Movement(R(100, 120)),))
    assert o.basis_of(held) == o.basis_of(EDL), "what was conformed before lamps were followed holds"
    assert o.changed(o.basis_of(moving(1.0)), o.basis_of(held)) == (R(96, 125),)
    assert o.changed(o.basis_of(moving(1.0)), o.basis_of(moving(2.0))) == (R(96, 125),)
    assert o.basis_of(loads(dumps(moving(1.0)))) == o.basis_of(moving(1.0))
    check_tiles([piece for piece, _ in o.basis_of(moving(1.0))], EDL.frames, "basis")
