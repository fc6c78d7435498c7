"""Places by the relief: against a scene whose truth is a formula, and there and back."""

from __future__ import annotations

import attrs
import cv2
import numpy as np
import pytest
import relief_scene as scene
from hypothesis import given, settings
from hypothesis import strategies as st

from mcsl_core.edl import Relief
from mcsl_core.imaging.geometry import depths, inverse, project, transform_points, translation
from mcsl_core.imaging.rect import Rect
from mcsl_core.imaging.relief import STEEPEST, Placement, ReliefMap, between_nodes, node_pixels, surface_field
from mcsl_core.imaging.warp import warp_field_maps

SIZE = (960, 540)
PLANE = inverse(scene.PROJECTION[:, :3])


def relief_of(confidence=100, height=30.0) -> ReliefMap:
    projections = {"b": tuple(tuple(row) for row in scene.PROJECTION.tolist())}
    rows = np.broadcast_to(np.asarray(confidence, int), (54, 96)).tolist()
    return ReliefMap.of(Relief(projections, scene.grid(SIZE, height=height), tuple(map(tuple, rows))), SIZE)


def points(count=400, margin=0.0) -> np.ndarray:
    low, high = -margin * np.array(SIZE), (1 + margin) * np.array(SIZE)
    return np.random.default_rng(3).uniform(low, high, (count, 2))


def place(**changes) -> Placement:
    return attrs.evolve(Placement(PLANE, surface_field(relief_of(), scene.PROJECTION, PLANE)), **changes)


def test_every_point_of_the_scene_is_where_the_camera_sees_it_and_the_plane_misses_it_by_pixels():
    at = points()
    truth = scene.seen(at, SIZE, 30.0)
    by_plane = np.linalg.norm(Placement(PLANE).to_camera(at) - truth, axis=1)
    by_relief = np.linalg.norm(place().to_camera(at) - truth, axis=1)
    assert np.percentile(by_plane, 90) > 5
    assert np.percentile(by_relief, 99) < 0.3
    assert np.median(by_relief) < 0.03


def test_where_the_relief_is_not_known_it_is_the_plane_exactly_and_between_it_goes_over_softly():
    half = np.where(np.arange(96) < 48, 100, 0)
    field = surface_field(relief_of(np.broadcast_to(half, (54, 96))), scene.PROJECTION, PLANE)
    laid, at = Placement(PLANE, field), points(2000)
    off = np.linalg.norm(laid.to_camera(at) - Placement(PLANE).to_camera(at), axis=1)
    assert off[at[:, 0] > 0.56 * SIZE[0]].max() < 0.01
    truth = np.linalg.norm(laid.to_camera(at) - scene.seen(at, SIZE, 30.0), axis=1)
    assert truth[at[:, 0] < 0.44 * SIZE[0]].max() < 0.5
    assert surface_field(relief_of(0), scene.PROJECTION, PLANE) is None


def test_from_half_of_full_confidence_on_the_relief_holds_and_below_it_is_the_plane_by_degrees():
    at = points()
    for confidence, share in ((100, 1.0), (75, 1.0), (50, 1.0), (25, 0.5), (10, 0.2)):
        field = surface_field(relief_of(confidence, 15.0), scene.PROJECTION, PLANE)
        moved = Placement(PLANE, field).to_camera(at) - Placement(PLANE).to_camera(at)
        full = scene.seen(at, SIZE, 15.0) - Placement(PLANE).to_camera(at)
        assert np.abs(moved - share * full).max() < 0.7, confidence


def test_the_reference_in_its_own_perspective_is_not_moved():
    assert surface_field(relief_of(), scene.IN_PLACE, np.eye(3)) is None


def test_far_outside_of_the_programme_it_is_the_plane():
    at = np.array([[-400.0, 200.0], [1400.0, 300.0], [500.0, 900.0], [-1e6, 1e6]])
    assert np.allclose(place().to_camera(at), Placement(PLANE).to_camera(at))


def test_a_correction_by_hand_moves_the_surface_as_it_does_the_plane():
    correction = translation(12.0, -7.0) @ np.array([[1.01, 0.02, 0], [-0.02, 1.01, 0], [0, 0, 1]])
    field = surface_field(relief_of(), scene.PROJECTION, correction @ PLANE, correction)
    at = points()
    at = at[np.all((at > 100) & (at < np.array(SIZE) - 100), axis=1)]
    moved = Placement(correction @ PLANE, field).to_camera(transform_points(correction, at))
    assert np.abs(moved - place().to_camera(at)).max() < 0.2


@settings(deadline=None, max_examples=25)
@given(
    st.floats(-200, 200),
    st.integers(0, 2**32 - 1),
    st.tuples(st.floats(-300, 300), st.floats(-300, 300)),
)
def test_there_is_a_way_back_from_everywhere_however_wild_the_relief(height, seed, offset):
    rng = np.random.default_rng(seed)
    gamma = (height * rng.normal(size=(9, 16))).round(2)
    confidence = rng.integers(0, 101, (9, 16))
    wild = ReliefMap(gamma.astype(np.float32), (confidence / 100).astype(np.float32), SIZE)
    laid = Placement(PLANE, surface_field(wild, scene.PROJECTION, PLANE), offset)
    at = points(200, margin=0.5)
    assert np.abs(laid.to_programme(laid.to_camera(at)) - at).max() < 1e-6
    seen = laid.to_camera(at)
    assert np.abs(laid.to_camera(laid.to_programme(seen)) - seen).max() < 1e-6


@pytest.mark.parametrize("height", [30.0, 200.0, -500.0])
def test_nothing_is_stretched_beyond_the_bound(height):
    """A step in the relief, the worst there is: the picture neither tears nor folds."""
    gamma = np.zeros((54, 96), np.float32)
    gamma[:, 40:] = height
    field = surface_field(ReliefMap(gamma, np.ones_like(gamma), SIZE), scene.PROJECTION, PLANE)
    assert field is not None
    x, y = np.meshgrid(np.arange(10, 950, 3.0), np.arange(10, 530, 3.0))
    laid = Placement(np.eye(3), field)
    at = np.column_stack([x.ravel(), y.ravel()])
    across = laid.to_camera(at + np.array([0.5, 0])) - laid.to_camera(at - np.array([0.5, 0]))
    down = laid.to_camera(at + np.array([0, 0.5])) - laid.to_camera(at - np.array([0, 0.5]))
    stretch = np.linalg.svd(np.stack([across, down], axis=-1), compute_uv=False)
    assert stretch.min() >= 1 - STEEPEST - 1e-3
    assert stretch.max() <= 1 + STEEPEST + 1e-3


def test_a_relief_that_is_wild_on_one_side_holds_on_the_other() -> None:
    noise = np.random.default_rng(1).normal(0, 1, (108, 192)).astype(np.float32)
    wild = cv2.GaussianBlur(noise, (0, 0), 12)
    gamma = np.where(np.arange(192) < 120, 400 * wild / np.abs(wild).max(), 12).astype(np.float32)
    field = surface_field(ReliefMap(gamma, np.ones_like(gamma), SIZE), scene.PROJECTION, PLANE)
    at = np.column_stack([np.linspace(800, 940, 20), np.linspace(60, 500, 20)])
    there = project(scene.PROJECTION, np.column_stack([at, np.full(20, 12.0)]))
    assert np.abs(Placement(PLANE, field).to_camera(at) - there).max() < 0.1


def test_points_and_pictures_are_laid_alike():
    laid = place(offset=(13.4, -6.2))
    maps = warp_field_maps(laid.matrix, laid.field, Rect(0, 0, *SIZE), laid.offset)
    y, x = np.mgrid[20:520:37, 15:940:41]
    found = laid.to_camera(np.column_stack([x.ravel(), y.ravel()]).astype(float))
    drawn = np.column_stack([table[y.ravel(), x.ravel()] for table in maps.luma])
    assert np.abs(drawn - found).max() < 0.15


def test_what_lies_behind_a_camera_has_no_place():
    behind = scene.PROJECTION.copy()
    behind[2, 3] = -1.0
    at = points(2000)
    gamma = scene.gamma_at(*at.T, SIZE, 30.0)
    laid = Placement(PLANE, surface_field(relief_of(), behind, PLANE))
    off = np.linalg.norm(laid.to_camera(at) - Placement(PLANE).to_camera(at), axis=1)
    assert (depths(behind, np.column_stack([at, gamma])) < 0).sum() > 100
    assert off[gamma > 5].max() < 0.05
    assert np.isnan(place().to_camera(np.array([[np.nan, 3.0]]))).any()


def test_nodes_reach_from_the_first_to_the_last_pixel_centre() -> None:
    values = np.random.default_rng(4).normal(size=(5, 8, 2))
    pixels = node_pixels((5, 8), (960, 540))
    assert pixels[[0, 7, -1]].tolist() == [[0, 0], [959, 0], [959, 539]]
    np.testing.assert_allclose(between_nodes(values, (960, 540), pixels), values.reshape(-1, 2), atol=1e-9)
