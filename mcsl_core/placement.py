"""Where the cameras' pictures lie in the programme, and when they lie there."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from .decisions import fitted, placed
from .edl import Edl, Pose
from .resampling import Matrix, translation
from .timing import FrameRange


def programme_matrix(edl: Edl, pose: Pose, camera: str, offset: tuple[float, float] = (0.0, 0.0)) -> Matrix:
    """Camera pixel -> programme pixel in ``pose``, shifted by the centering ``offset`` in programme pixels.

    A camera that the pose has no homography for (a weak one an editor chose) fills the frame as it is: where its
    picture lies is not known, so neither the anchor nor the centering means anything for it.
    """
    known = placed(edl, pose, camera)
    if known is None:
        return np.array(fitted(edl.camera(camera).size, edl.size))
    matrix = translation(*offset) @ np.array(known, np.float64)
    return matrix / matrix[2, 2]


def still_range(edl: Edl, pose: Pose) -> FrameRange:
    """The stretch of ``pose`` in which the lamp stands still; all of it where it never does."""
    start, stop = pose.range.start, pose.range.stop
    for movement in edl.movements:
        if start in movement.range:
            start = movement.range.stop
        if stop - 1 in movement.range:
            stop = movement.range.start
    return FrameRange(start, stop) if start < stop else pose.range


def elsewhere(edl: Edl, number: int) -> tuple[int, ...]:
    """The other poses of the perspective of pose ``number``: earlier ones, the latest first, then later ones."""
    same = [i for i, pose in enumerate(edl.poses) if pose.perspective == edl.poses[number].perspective]
    return (*(i for i in reversed(same) if i < number), *(i for i in same if i > number))


def first_of_perspective(edl: Edl, number: int) -> int:
    """The first pose of the perspective of pose ``number`` with a known place for the reference camera; itself without.

    The perspective is that camera's there: what lies off the plane lies right in its picture, and beside it elsewhere.
    """
    pose = edl.poses[number]
    same = (i for i, other in enumerate(edl.poses) if other.perspective == pose.perspective)
    return next((i for i in same if placed(edl, edl.poses[i], edl.reference) is not None), number)


def covered(edl: Edl, pose: Pose, offsets: Sequence[tuple[float, float]]) -> bool:
    """Whether some camera of ``pose`` sees every programme pixel, under all ``offsets`` and what lies between them."""
    scale = 1 / 8
    (left, right), (top, bottom) = ((min(v), max(v)) for v in zip(*offsets, strict=True))
    size = tuple(int((v + b - a) * scale) + 2 for v, a, b in zip(edl.size, (left, top), (right, bottom), strict=True))
    to_grid = np.diag([scale, scale, 1.0]) @ translation(right, bottom)
    seen = np.zeros(size[::-1], np.uint8)
    for camera in edl.cameras:
        if placed(edl, pose, camera.name) is not None:
            ones = np.full((camera.size[1] // 8, camera.size[0] // 8), 255, np.uint8)
            matrix = to_grid @ programme_matrix(edl, pose, camera.name) @ np.diag([8.0, 8.0, 1.0])
            mask = cv2.warpPerspective(ones, matrix, size, flags=cv2.INTER_NEAREST)
            seen |= np.asarray(cv2.erode(mask, np.ones((3, 3), np.uint8), borderType=cv2.BORDER_REPLICATE), np.uint8)
    return bool(seen.all())
