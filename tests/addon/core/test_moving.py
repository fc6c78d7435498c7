# SPDX-License-Identifier: GPL-3.0-or-later
"""Camera strips over a movement that is followed: keyed along its views, and no decision of an editor's."""

from __future__ import annotations

import math
from itertools import pairwise

import attrs
import numpy as np
import pytest
from builders import CAMERAS, small_edl, state_of

from blender_addon.core.camera_places import planned_transform
from blender_addon.core.moving import followed_ranges
from blender_addon.core.read_overrides import read_edl
from blender_addon.core.similarity import Transform, closest, matrix_of, touching
from blender_addon.core.strip_plan import MoviePiece, make_plan, tracks_key
from mcsl_core.edl import IDENTITY, Correction, Edl, Matrix, Media, Movement, MovementView, Pose
from mcsl_core.edl.following import placed_pose
from mcsl_core.edl.placement import placement_matrix
from mcsl_core.timing import FrameRange

R = FrameRange
SIZE = (320, 180)
SHIFT: Matrix = ((1.0, 0.0, 6.0), (0.0, 1.0, -4.0), (0.0, 0.0, 1.0))
VIEWS = range(96, 125, 2)
AROUND = [(x, y) for x in (100, 160, 220) for y in (60, 90, 120)]  # programme pixels round the field


def turned(degrees: float, tilt: float = 0.0) -> Matrix:
    """A picture turned about the programme's middle, and a little of perspective."""
    angle, middle = math.radians(degrees), np.array([[1, 0, 159.5], [0, 1, 89.5], [0, 0, 1.0]])
    turn = np.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [tilt, 0, 1]])
    matrix = middle @ turn @ np.linalg.inv(middle)
    a, b, c = (matrix / matrix[2, 2]).tolist()
    return tuple(a), tuple(b), tuple(c)


def at(frame: int) -> dict[str, Matrix]:
    """cam2 turns from 150 to 210 degrees, past where Blender's angle would jump; the others stand."""
    way = min(max((frame - 96) / 28, 0), 1)
    return {"cam1": IDENTITY, "cam2": turned(150 + 60 * way, 2e-4 * way), "cam3": IDENTITY}


def moving(views=VIEWS, **fields) -> Edl:
    given = {
        "movements": (Movement(R(100, 120), 1.0, tuple(MovementView(f, at(f)) for f in views)),),
        "poses": (Pose(R(0, 110), at(0)), Pose(R(110, 300), at(300))),
    }
    return small_edl(**{**given, **fields})


def pieces(edl: Edl, camera: str = "cam2") -> list[MoviePiece]:
    track = next(t for t in make_plan(edl).cameras if t.camera == camera)
    return [piece for file in track.files for piece in file.pieces]


def shown(transform: Transform, points=AROUND) -> np.ndarray:
    """Where camera pixels that lie at these programme points under the half-way view are shown."""
    there = np.linalg.inv(np.array(at(110)["cam2"])) @ np.array([(x, y, 1) for x, y in points]).T
    found = np.array(matrix_of(transform, SIZE, SIZE)) @ (there / there[2])
    return (found[:2] / found[2]).T


def apart(a: Transform, b: Transform) -> float:
    return float(np.hypot(*(shown(a) - shown(b)).T).max())


def test_strips_are_cut_at_the_first_and_after_the_last_view_and_keyed_between() -> None:
    before, over, after = pieces(moving())
    assert [piece.range for piece in (before, over, after)] == [R(0, 96), R(96, 125), R(125, 300)]
    assert [(piece.planned is None, bool(piece.keys)) for piece in (before, over, after)] == [
        (False, False),
        (True, True),
        (False, False),
    ]
    assert {key.frame for key in over.keys} == {*VIEWS, 109}  # and the frames on both sides of the new pose
    assert over.transform == over.keys[0].transform
    assert not any(key.hold for key in over.keys)


def test_keys_join_the_standing_strips_and_show_what_is_placed_between() -> None:
    edl = moving()
    camera = edl.camera("cam2")
    before, over, after = pieces(edl)
    assert apart(over.keys[0].transform, before.transform) < 1e-6
    assert apart(over.keys[-1].transform, after.transform) < 1e-6
    for key in over.keys:
        assert apart(key.transform, planned_transform(edl, camera, placed_pose(edl, key.frame))) < 1.0, key.frame
    for a, b in pairwise(over.keys):
        assert abs(a.transform.rotation - b.transform.rotation) < 0.2  # no strip spins round


def test_without_views_strips_are_as_they_always_were() -> None:
    edl = moving(views=())
    assert [piece.range for piece in pieces(edl)] == [R(0, 110), R(110, 300)]
    assert followed_ranges(edl) == []
    plain = attrs.evolve(edl, movements=())
    assert tracks_key(make_plan(edl).cameras) == tracks_key(make_plan(plain).cameras)
    assert tracks_key(make_plan(moving()).cameras) != tracks_key(make_plan(plain).cameras)


def test_an_untouched_timeline_decides_nothing() -> None:
    corrections = (Correction(R(110, 300), "cam2", SHIFT),)
    for edl in (moving(), moving(corrections=corrections), moving(views=range(100, 101))):
        assert read_edl(edl, state_of(make_plan(edl))) == edl


def test_a_strip_that_stands_is_corrected_for_its_pose_and_one_that_moves_says_nothing() -> None:
    edl = moving()
    state = state_of(make_plan(edl))

    def by_hand(start: int) -> Edl:
        found = []
        for strip in state.cameras:
            if (strip.camera, strip.start) == ("cam2", start):
                assert strip.transform is not None
                strip = attrs.evolve(strip, transform=attrs.evolve(strip.transform, offset_x=40.0))
            found.append(strip)
        assert tuple(found) != state.cameras
        return read_edl(edl, attrs.evolve(state, cameras=tuple(found)))

    for start, pose in ((0, R(0, 110)), (125, R(110, 300))):
        [correction] = by_hand(start).corrections
        assert (correction.range, correction.camera) == (pose, "cam2")
    assert by_hand(96) == edl


def test_corrections_hold_in_the_movement_as_they_do_in_pictures() -> None:
    edl, plain = moving(corrections=(Correction(R(110, 300), "cam2", SHIFT),)), moving()
    for key, bare in zip(pieces(edl)[1].keys, pieces(plain)[1].keys, strict=True):
        moved = shown(key.transform) - shown(bare.transform)
        placed = [placement_matrix(e, placed_pose(e, key.frame), "cam2") for e in (edl, plain)]
        assert placed[0] is not None
        by = [6, -4] if placed[0] != placed[1] else [0, 0]
        np.testing.assert_allclose(moved, np.broadcast_to(by, moved.shape), atol=1e-6)
        assert key.planned == bare.transform
    assert tracks_key(make_plan(edl).cameras) == tracks_key(make_plan(plain).cameras)


def test_files_and_gaps_cut_a_movement_as_they_cut_poses() -> None:
    cameras = tuple(
        attrs.evolve(c, media=(Media("a.mp4", 105), Media("b.mp4", 195)), gaps=(R(112, 115),))
        if c.name == "cam2"
        else c
        for c in moving().cameras
    )
    found = pieces(moving(cameras=cameras))
    assert [p.range for p in found] == [R(0, 96), R(96, 105), R(105, 112), R(115, 125), R(125, 300)]
    assert found[1].keys == found[2].keys == found[3].keys


def test_a_camera_that_is_lost_on_the_way_is_shown_whole_meanwhile_without_sliding_there() -> None:
    def seen(frame: int) -> dict[str, Matrix]:
        return {name: m for name, m in at(frame).items() if name != "cam2" or not 104 <= frame <= 112}

    movement = Movement(R(100, 120), 1.0, tuple(MovementView(f, seen(f)) for f in VIEWS))
    edl = moving(movements=(movement,))
    keys = {key.frame: key for key in pieces(edl)[1].keys}
    whole = [frame for frame, key in keys.items() if key.transform == Transform(0, 0, 1, key.transform.rotation)]
    assert min(whole) in (102, 104)
    assert max(whole) in (110, 112)
    assert [f for f, key in keys.items() if key.hold] == [max(f for f in keys if f < min(whole)), max(whole)]
    never = moving(movements=(attrs.evolve(movement, views=tuple(MovementView(f, {}) for f in VIEWS)),))
    assert {attrs.astuple(key.transform)[:4] for key in pieces(never)[1].keys} == {(0.0, 0.0, 1.0, 0.0)}


def test_movements_that_follow_close_upon_each_other_up_to_the_last_frame() -> None:
    views = [tuple(MovementView(f, at(f)) for f in span) for span in ((96, 110, 124), (125, 140), (290, 299))]
    ranges = (R(100, 120), R(127, 138), R(292, 300))
    edl = moving(movements=tuple(Movement(r, 1.0, v) for r, v in zip(ranges, views, strict=True)))
    assert [span for span, _ in followed_ranges(edl)] == [R(96, 125), R(125, 141), R(290, 300)]
    assert [(p.range, bool(p.keys)) for p in pieces(edl)][-2:] == [(R(141, 290), False), (R(290, 300), True)]
    assert read_edl(edl, state_of(make_plan(edl))) == edl


@pytest.mark.parametrize("point", [159.5 + 89.5j, 40 + 20j])
def test_the_touching_similarity_is_the_limit_of_fits_over_ever_less(point: complex) -> None:
    homography = at(120)["cam2"]
    found = touching(homography, point)
    assert found is not None
    inverse = np.linalg.inv(np.array(homography))
    near = [(point.real + dx, point.imag + dy) for dx in (-0.01, 0.01) for dy in (-0.01, 0.01)]
    there = inverse @ np.array([(x, y, 1) for x, y in near]).T
    moved = np.array(found) @ (there / there[2])
    np.testing.assert_allclose(moved[:2].T, near, atol=2e-3)


def test_a_camera_that_looks_away_from_the_field_is_fitted_where_it_looks() -> None:
    away: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (-0.02, 0.0, 1.0))  # the field's middle is behind its horizon
    point = 159.5 + 89.5j
    assert touching(away, -400 + 0j) is None or touching(away, point) is not None
    views = tuple(MovementView(f, {name: away for name in CAMERAS}) for f in VIEWS)
    edl = moving(movements=(Movement(R(100, 120), 1.0, views),))
    for key in pieces(edl)[1].keys:
        fit = closest(away, SIZE, SIZE, point)
        assert apart(key.transform, attrs.evolve(fit, rotation=fit.rotation)) < 60
