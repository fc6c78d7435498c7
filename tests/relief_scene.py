"""A scene with a relief whose truth is known: cameras as matrices, heights as a formula, pictures by exact lookup."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.alignment.dense_matching import pixels_of
from mcsl_core.edl import IDENTITY, Pose, Relief
from mcsl_core.imaging.geometry import inverse, project, to_edl_matrix, to_edl_projection, transform_points
from mcsl_core.timing import FrameRange

PROJECTION = np.array([[1.03, 0.04, -4.0, 0.9], [-0.03, 0.98, 5.0, 0.35], [2e-5, -4e-5, 1.0, 2e-4]])
IN_PLACE = np.eye(3, 4)


def gamma_at(x: NDArray, y: NDArray, size: tuple[int, int], height: float = 6.0) -> NDArray:
    """A round hill of ``height`` and a shallow valley, as shares of the picture."""
    u, v = x / size[0] - 0.5, y / size[1] - 0.5
    return height * (np.exp(-(u**2 + v**2) / 0.03) - 0.5 * np.exp(-((u - 0.3) ** 2 + (v + 0.25) ** 2) / 0.02))


def grid(size: tuple[int, int], *, height: float = 6.0, nodes: tuple[int, int] = (96, 54)):
    """The heights as the EDL has them, at (columns, rows) nodes."""
    x, y = np.meshgrid(np.linspace(0, size[0] - 1, nodes[0]), np.linspace(0, size[1] - 1, nodes[1]))
    return tuple(tuple(row) for row in gamma_at(x, y, size, height).round(3).tolist())


def seen(points: NDArray, size: tuple[int, int], height: float = 6.0) -> NDArray:
    """(N, 2): where the tilted camera sees (N, 2) programme pixels."""
    return project(PROJECTION, np.column_stack([points, gamma_at(points[:, 0], points[:, 1], size, height)]))


def shown_at(projection: NDArray, gamma_of: Callable[[NDArray], NDArray], size: tuple[int, int]) -> NDArray:
    """(H, W, 2) float32: the scene point, as the reference's pixel, that each pixel of a camera shows; by iteration."""
    back, pixels = inverse(projection[:, :3]), pixels_of(size)
    laid = at = transform_points(back, pixels)
    for _ in range(30):
        there = project(projection, np.column_stack([at, gamma_of(at)]))
        at = at + laid - transform_points(back, there)
    return at.reshape(size[1], size[0], 2).astype(np.float32)


def picture_of(texture: NDArray, height: float = 6.0) -> NDArray:
    """What the tilted camera takes of a scene that the reference sees as ``texture`` (H, W, 3)."""
    size = texture.shape[1], texture.shape[0]
    where = shown_at(PROJECTION, lambda at: gamma_at(at[:, 0], at[:, 1], size, height), size)
    return cv2.remap(texture, where, None, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT)  # pyright: ignore


def pose_of(frames: int, size: tuple[int, int], *, height: float = 6.0, confidence: int = 100, **changes) -> Pose:
    """Cameras "a", the reference, and "b", the tilted one, with the relief; b's plane is where there is no height."""
    projections = {"a": to_edl_projection(IN_PLACE), "b": to_edl_projection(PROJECTION)}
    values = {
        "relief": Relief(projections, grid(size, height=height), ((confidence,) * 96,) * 54),
        **changes,
    }
    return Pose(FrameRange(0, frames), {"a": IDENTITY, "b": to_edl_matrix(inverse(PROJECTION[:, :3]))}, **values)
