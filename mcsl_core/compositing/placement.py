"""Where the cameras' pictures lie in the programme, as arrays for warping."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from mcsl_core.edl import Edl, Pose
from mcsl_core.edl.placement import correction_of, fit_matrix, placement_matrix
from mcsl_core.imaging.geometry import Homography, translation
from mcsl_core.imaging.planes import Planes
from mcsl_core.imaging.rect import Rect
from mcsl_core.imaging.relief import Placement, ReliefMap, surface_field
from mcsl_core.imaging.warp import WarpField, warp_planes, warp_planes_by_field


def programme_matrix(edl: Edl, pose: Pose, camera: str, offset: tuple[float, float] = (0.0, 0.0)) -> Homography:
    """Where a camera's picture lies in the programme.

    Parameters
    ----------
    edl : Edl
        The programme.
    pose : Pose
        One of its poses.
    camera : str
        The camera's name.
    offset : (float, float)
        The centering's, in programme pixels.

    Returns
    -------
    (3, 3) float64
        Camera pixel -> programme pixel.

    Notes
    -----
    A camera that the pose has no homography for (a weak one an editor chose) fills the frame as it is: where its
    picture lies is not known, so neither the anchor nor the centering means anything for it.
    """
    known = placement_matrix(edl, pose, camera)
    if known is None:
        return np.array(fit_matrix(edl.camera(camera).size, edl.size))
    matrix = translation(*offset) @ np.array(known, np.float64)
    return matrix / matrix[2, 2]


def has_relief(edl: Edl, pose: Pose, camera: str) -> bool:
    """Whether the pose's relief says how the camera's picture lies, which is known at all."""
    known = pose.relief is not None and camera in pose.relief.projections
    return known and placement_matrix(edl, pose, camera) is not None


def surface_of(edl: Edl, pose: Pose, camera: str, *, coarser: float = 1.0) -> WarpField | None:
    """What the pose's relief adds to where `programme_matrix` lays a camera's picture; None where it adds nothing.

    ``coarser``: see `surface_field`.
    """
    if pose.relief is None or not has_relief(edl, pose, camera):
        return None
    correction = correction_of(edl, pose, camera)
    return surface_field(
        ReliefMap.of(pose.relief, edl.size),
        np.array(pose.relief.projections[camera], np.float64),
        programme_matrix(edl, pose, camera),
        None if correction is None else np.array(correction, np.float64),
        coarser=coarser,
    )


def camera_placement(edl: Edl, pose: Pose, camera: str, *, surface: bool) -> Placement | None:
    """Where a camera's picture lies before centering, by the pose's relief or its plane; None where it is not known."""
    if placement_matrix(edl, pose, camera) is None:
        return None
    return Placement(programme_matrix(edl, pose, camera), surface_of(edl, pose, camera) if surface else None)


def laid(planes: Planes, placement: Placement, size: tuple[int, int]) -> Planes:
    """A camera's picture as it lies in a programme of ``size`` (width, height), nothing filled."""
    whole = Rect(0, 0, *size)
    if placement.field is None:
        return warp_planes(planes, translation(*placement.offset) @ placement.matrix, whole)
    return warp_planes_by_field(planes, placement.matrix, placement.field, whole, placement.offset)


def fully_covered(edl: Edl, pose: Pose, offsets: Sequence[tuple[float, float]], *, surface: bool = False) -> bool:
    """Whether the cameras of a pose cover every programme pixel together.

    Parameters
    ----------
    edl : Edl
        The programme.
    pose : Pose
        One of its poses.
    offsets : sequence of (float, float)
        The centering's, in programme pixels: under all of them and what lies between.
    surface : bool
        Whether cameras are laid by the pose's relief, where it has one.

    Returns
    -------
    bool
        As found on a grid of every eighth pixel, whose edge cells do not count.
    """
    scale = 1 / 8
    shifts_x, shifts_y = zip(*offsets, strict=True)
    left, top = min(shifts_x), min(shifts_y)
    right, bottom = max(shifts_x), max(shifts_y)
    size = (int((edl.size[0] + right - left) * scale) + 2, int((edl.size[1] + bottom - top) * scale) + 2)
    to_grid = np.diag([scale, scale, 1.0]) @ translation(right, bottom)
    covered = np.zeros(size[::-1], np.uint8)
    for camera in edl.cameras:
        if placement_matrix(edl, pose, camera.name) is None:
            continue
        ones = np.full((camera.size[1] // 8, camera.size[0] // 8), 255, np.uint8)
        matrix = programme_matrix(edl, pose, camera.name) @ np.diag([8.0, 8.0, 1.0])
        warp_field = surface_of(edl, pose, camera.name) if surface else None
        if warp_field is None:
            mask = cv2.warpPerspective(ones, to_grid @ matrix, size, flags=cv2.INTER_NEAREST)
        else:
            x, y = np.meshgrid(*((np.arange(n) / scale - by for n, by in zip(size, (right, bottom), strict=True))))
            at = warp_field.source(matrix, x.astype(np.float32), y.astype(np.float32))
            mask = cv2.remap(ones, at, None, cv2.INTER_NEAREST)  # pyright: ignore
        covered |= np.asarray(cv2.erode(mask, np.ones((3, 3), np.uint8), borderType=cv2.BORDER_REPLICATE), np.uint8)
        if covered.all():
            return True
    return False
