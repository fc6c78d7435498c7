"""Where the cameras' pictures lie in the programme, as arrays for warping."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from mcsl_core.edl import Edl, Pose
from mcsl_core.edl.placement import fit_matrix, placement_matrix
from mcsl_core.imaging.geometry import Homography, translation


def programme_matrix(edl: Edl, pose: Pose, camera: str, offset: tuple[float, float] = (0.0, 0.0)) -> Homography:
    """Camera pixel -> programme pixel in ``pose``, shifted by the centering ``offset`` in programme pixels.

    A camera that the pose has no homography for (a weak one an editor chose) fills the frame as it is: where its
    picture lies is not known, so neither the anchor nor the centering means anything for it.
    """
    known = placement_matrix(edl, pose, camera)
    if known is None:
        return np.array(fit_matrix(edl.camera(camera).size, edl.size))
    matrix = translation(*offset) @ np.array(known, np.float64)
    return matrix / matrix[2, 2]


def fully_covered(edl: Edl, pose: Pose, offsets: Sequence[tuple[float, float]]) -> bool:
    """Whether some camera of ``pose`` sees every programme pixel, under all ``offsets`` and what lies between them."""
    scale = 1 / 8
    (left, right), (top, bottom) = ((min(v), max(v)) for v in zip(*offsets, strict=True))
    size = tuple(int((v + b - a) * scale) + 2 for v, a, b in zip(edl.size, (left, top), (right, bottom), strict=True))
    to_grid = np.diag([scale, scale, 1.0]) @ translation(right, bottom)
    seen = np.zeros(size[::-1], np.uint8)
    for camera in edl.cameras:
        if placement_matrix(edl, pose, camera.name) is not None:
            ones = np.full((camera.size[1] // 8, camera.size[0] // 8), 255, np.uint8)
            matrix = to_grid @ programme_matrix(edl, pose, camera.name) @ np.diag([8.0, 8.0, 1.0])
            mask = cv2.warpPerspective(ones, matrix, size, flags=cv2.INTER_NEAREST)
            seen |= np.asarray(cv2.erode(mask, np.ones((3, 3), np.uint8), borderType=cv2.BORDER_REPLICATE), np.uint8)
    return bool(seen.all())
