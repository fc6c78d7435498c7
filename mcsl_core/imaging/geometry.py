"""Plane geometry on 3x3 arrays: scalings, translations, points through a homography, arrays as the EDL writes them.

Pixel centres lie at integers (OpenCV's convention).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mcsl_core.edl import Matrix, Matrix34
from mcsl_core.edl.placement import fit_matrix

Array = NDArray[np.float64]
Homography = NDArray[np.float64]


def transform_points(homography: Homography, points: Array) -> Array:
    """Points mapped by a homography.

    Parameters
    ----------
    homography
        (3, 3).
    points
        (N, 2), x and y in pixels.

    Returns
    -------
    Array
        (N, 2), pixels of the target picture.

    Examples
    --------
    >>> transform_points(translation(10, 0), np.array([[1.0, 2.0]])).tolist()
    [[11.0, 2.0]]
    """
    moved = points @ homography[:, :2].T + homography[:, 2]
    return moved[:, :2] / moved[:, 2:]


def project(projection: Array, scene: Array) -> Array:
    """Where a camera sees scene points.

    Parameters
    ----------
    projection
        (3, 4), the camera's: (x, y, 1, gamma) -> its pixel, homogeneous.
    scene
        (N, 3): x and y in pixels of the perspective, and gamma, the height over its plane.

    Returns
    -------
    Array
        (N, 2), camera pixels; of what lies behind the camera (`depths`), mirrored.
    """
    moved = scene[:, :2] @ projection[:, :2].T + scene[:, 2:] * projection[:, 3] + projection[:, 2]
    return moved[:, :2] / moved[:, 2:]


def depths(projection: Array, scene: Array) -> Array:
    """(N,): how far scene points lie before a camera, up to a factor; 0 and less is behind it."""
    return scene[:, :2] @ projection[2, :2] + scene[:, 2] * projection[2, 3] + projection[2, 2]


def inverse(matrix: Array) -> Array:
    """(N, N): the way back, as float64."""
    return np.asarray(np.linalg.inv(matrix), np.float64)


def translation(dx: float, dy: float) -> Homography:
    """(3, 3): a shift by ``dx``, ``dy`` pixels."""
    return np.array([[1.0, 0, dx], [0, 1.0, dy], [0, 0, 1]])


def half_widths(size: tuple[int, int]) -> Homography:
    """(3, 3): pixel of a picture of ``size`` (width, height) -> about its middle, in half widths."""
    width, height = size
    return np.diag([2 / width, 2 / width, 1.0]) @ np.array([[1, 0, -width / 2], [0, 1, -height / 2], [0, 0, 1]])


def scaling(from_size: tuple[int, int], to_size: tuple[int, int]) -> Homography:
    """(3, 3): pixel of a picture of ``from_size`` (width, height) -> the same point in one of ``to_size``."""
    return np.array(fit_matrix(from_size, to_size))


def size_at_columns(size: tuple[int, int], columns: int) -> tuple[int, int]:
    """``size`` (width, height) scaled to that many columns, its aspect kept."""
    return columns, max(1, round(size[1] * columns / size[0]))


def to_edl_matrix(homography: ArrayLike) -> Matrix:
    """A 3x3 array as the EDL writes it, scaled so that the last element is 1."""
    matrix = np.asarray(homography, np.float64)
    rows = [tuple(float(v) for v in row) for row in matrix / matrix[2, 2]]
    return rows[0], rows[1], rows[2]  # pyright: ignore[reportReturnType]


def to_edl_projection(projection: ArrayLike) -> Matrix34:
    """A 3x4 array as the EDL writes it, scaled so that [2, 2] is 1."""
    matrix = np.asarray(projection, np.float64)
    rows = [tuple(float(v) for v in row) for row in matrix / matrix[2, 2]]
    return rows[0], rows[1], rows[2]  # pyright: ignore[reportReturnType]
