"""The field's points lie on the surface, and the plane through them is theirs of least squares."""

from __future__ import annotations

import numpy as np
from hand_over_slope import PROJECTIONS, SIZE, slope, under_hand

from mcsl_core.alignment.relief.surface_planes import field_points, plane_through, sure_nodes
from mcsl_core.imaging.geometry import project, transform_points

FIELD = np.zeros((270, 480), bool)
FIELD[90:180, 160:320] = True


def test_points_lie_on_the_surface_all_over_the_field() -> None:
    relief = under_hand()
    confidence = relief.surface.confidence.copy()
    confidence[20:30, 40:50] = 0.1  # a hole in it
    nodes = sure_nodes(relief.surface.gamma, confidence, SIZE)
    assert len(nodes) == 54 * 96 - 100
    points = field_points(nodes, FIELD, SIZE, 1.0)
    assert len(points) > 300
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    np.testing.assert_allclose([*low, *high], [320, 180, 640, 360], atol=12)
    np.testing.assert_allclose(points[:, 2], slope(points[:, 0]), atol=0.3)
    seen = project(PROJECTIONS["b"], points)
    laid = transform_points(plane_through(seen, points[:, :2]), seen)
    assert np.hypot(*(laid - points[:, :2]).T).max() < 0.5, "a slope is a plane"


def test_without_a_sure_node_there_are_no_points() -> None:
    relief = under_hand()
    nodes = sure_nodes(relief.surface.gamma, np.zeros_like(relief.surface.confidence), SIZE)
    assert field_points(nodes, FIELD, SIZE, 1.0).shape == (0, 3)
