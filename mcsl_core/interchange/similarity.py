"""The nearest that an editor's own transform comes to a homography: moved, scaled and turned, without perspective."""

from __future__ import annotations

from math import atan2, degrees, hypot

import numpy as np
from numpy.typing import NDArray

from mcsl_core.edl import Camera, Edl, Pose
from mcsl_core.edl.placement import placement_matrix
from mcsl_core.edl.resolve import offset_at

from .model import Transform

_GRID = 17  # points a side
_SPREAD = 0.3  # of the picture's width: how far from the field's middle a point still weighs e**-0.5


def nearest_transform(edl: Edl, camera: Camera, pose: Pose) -> Transform:
    """The similarity nearest to how ``camera`` lies in ``pose``, by least squares, most of all about the field.

    A camera that could not be tied in is shown upright and whole.
    """
    width, height = edl.size
    whole = Transform(0.0, 0.0, min(width / camera.size[0], height / camera.size[1]), 0.0)
    matrix = placement_matrix(edl, pose, camera.name)
    if matrix is None:
        return whole
    shift = np.array(offset_at(edl.centering, (pose.range.start + pose.range.stop) / 2))
    field = np.array([(width - 1) / 2, (height - 1) / 2]) - shift  # what centering moves to the middle
    x, y = np.meshgrid(np.linspace(0, width - 1, _GRID), np.linspace(0, height - 1, _GRID))
    target = np.stack([x.ravel(), y.ravel()], axis=1)
    source, seen = _taken_back(np.array(matrix), target)
    inside = seen & (source >= -0.5).all(axis=1) & (source <= np.array(camera.size) - 0.5).all(axis=1)
    used = inside if inside.sum() >= _GRID else seen
    if used.sum() < _GRID:
        return whole
    weight = np.exp(-0.5 * (np.linalg.norm(target - field, axis=1) / (_SPREAD * width)) ** 2)
    middle = (np.array(camera.size) - 1) / 2
    scaled_cos, scaled_sin, shift_x, shift_y = _fitted(source[used] - middle, target[used], weight[used])
    return Transform(
        x=shift_x - (width - 1) / 2,
        y=shift_y - (height - 1) / 2,
        scale=hypot(scaled_cos, scaled_sin),
        rotation=degrees(atan2(scaled_sin, scaled_cos)) + 0.0,
    )


def _taken_back(
    matrix: NDArray[np.float64], target: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Programme points (n, 2) in the camera's picture, and which of them lie before its horizon."""
    points = np.column_stack([target, np.ones(len(target))]) @ np.linalg.inv(matrix).T
    seen = points[:, 2] > 1e-9
    return points[:, :2] / np.where(seen, points[:, 2], 1.0)[:, None], seen


def _fitted(source: NDArray[np.float64], target: NDArray[np.float64], weight: NDArray[np.float64]) -> list[float]:
    """Of target = [[c, -s], [s, c]] source + (x, y): c, s, x, y."""
    x, y = source.T
    zero, one = np.zeros_like(x), np.ones_like(x)
    rows = np.concatenate([np.stack([x, -y, one, zero], axis=1), np.stack([y, x, zero, one], axis=1)])
    root = np.sqrt(np.concatenate([weight, weight]))
    found, *_ = np.linalg.lstsq(rows * root[:, None], target.T.ravel() * root, rcond=None)
    return [float(value) for value in found]
