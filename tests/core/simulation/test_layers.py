"""What is drawn lies where the truth says: the drawing's own maps and masks against plain projection."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from mcsl_core.simulation.backdrop import Backdrop
from mcsl_core.simulation.ground import Ground
from mcsl_core.simulation.layers import Overlay, Picture, layer_of
from mcsl_core.simulation.rig import cross
from mcsl_core.simulation.scenario import Scenario
from mcsl_core.simulation.scene import Scene
from mcsl_core.simulation.surface import HALF_MM


@pytest.fixture(scope="module")
def scene() -> tuple[Scene, Ground]:
    simulated = Scene.of(Scenario(seed=5, size=(640, 360), heads=0, hands=0, movements=1))
    return simulated, Ground.of(simulated.scenario, simulated.surface, simulated.rig)


@pytest.mark.parametrize("camera", range(5))
def test_each_pixel_shows_the_point_that_projects_to_it(scene, camera):
    simulated, ground = scene
    backdrop = Backdrop(simulated, ground, camera, np.ones(3))
    for pose in simulated.path.poses:
        pinhole = simulated.rig.pinhole(camera, pose)
        map_x, map_y = backdrop._maps(pinhole)
        rng = np.random.default_rng(camera)
        x, y = rng.integers(2, 638, 500), rng.integers(2, 358, 500)
        plan = np.stack([map_x[y, x], map_y[y, x]], 1) * ground.pitch_mm - HALF_MM
        near = np.hypot(*plan.T) < 150
        height = simulated.surface.height_at(plan[near, :1], plan[near, 1:])
        px = pinhole.project(np.concatenate([plan[near], height], 1))
        error = np.linalg.norm(px - np.stack([x, y], 1)[near], axis=1)
        # Rays are interpolated between every fourth pixel; the wound's walls are the worst.
        assert np.median(error) < 0.02
        assert np.percentile(error, 99) < 0.25


def test_a_dot_on_the_field_is_seen_where_its_point_projects(scene):
    """Black dots painted on a white table are found again by their centroids."""
    simulated, ground = scene
    pinhole = simulated.rig.pinhole(2, simulated.path.poses[0])
    backdrop = Backdrop(simulated, ground, 2, np.ones(3))
    table = np.full(ground.base.shape[:2], 255, np.uint8)
    points = simulated.surface.field_points_mm[::7]
    for x, y, _ in points:
        at = tuple(round(float(v + HALF_MM) / ground.pitch_mm * 16) for v in (x, y))
        cv2.circle(table, at, int(2.0 / ground.pitch_mm * 16), 0, -1, cv2.LINE_AA, 4)
    shown = 255.0 - cv2.remap(table, *backdrop._maps(pinhole), cv2.INTER_LINEAR)
    errors = []
    for px in pinhole.project(points):
        x, y = np.rint(px).astype(int)
        if not (8 < x < 631 and 8 < y < 351):
            continue
        window = shown[y - 6 : y + 7, x - 6 : x + 7]
        rows, columns = np.mgrid[-6:7, -6:7]
        centroid = np.array([(window * columns).sum(), (window * rows).sum()]) / window.sum() + (x, y)
        errors.append(np.linalg.norm(centroid - px))
    # A dot on a steep wall is foreshortened more on one side than on the other.
    assert len(errors) > 30
    assert np.median(errors) < 0.1
    assert max(errors) < 1


def test_turns_are_right_handed():
    a, b = np.array([1.0, 2, 3]), np.array([-2.0, 0.5, 4])
    assert np.allclose(cross(a, b), np.cross(a, b))


def test_a_sprite_lies_where_its_matrix_says():
    """A white square, drawn directly and by way of the small overlays, covers the same place."""
    square = np.full((40, 60, 4), 255, np.uint8)
    layer = layer_of(square, np.ones(3))
    # The third row is depth in mm.
    matrix = 900 * np.array([[1.5, -0.3, 100.0], [0.2, 1.4, 50.0], [1e-4, 0, 1.0]])
    black = layer_of(np.zeros((270, 480, 3), np.uint8), np.ones(3))
    corners = cv2.perspectiveTransform(np.array([[[-0.5, -0.5], [59.5, -0.5], [59.5, 39.5], [-0.5, 39.5]]]), matrix)
    moments = cv2.moments(corners.astype(np.float32))
    centre = np.array([moments["m01"], moments["m10"]]) / moments["m00"]
    for scale in (1, 2, 4, 8):
        picture = Picture.of(black)
        if scale == 1:
            picture.draw(layer, matrix)
        else:
            overlay = Overlay((480, 270), scale)
            overlay.draw(layer, matrix)
            overlay.onto(picture)
            assert not overlay.layer.any()
        covered = picture.y > (16 + 235) / 2
        assert picture.y.max() == pytest.approx(235, abs=1)
        assert covered.sum() == pytest.approx(moments["m00"], rel=0.02)
        assert np.abs(np.argwhere(covered).mean(0) - centre).max() < 0.1 * scale
        assert abs(int(picture.u.min()) - 128) <= 2
        assert abs(int(picture.v.max()) - 128) <= 2
