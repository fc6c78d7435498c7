"""What lays the planes of a pose whose surface is known: points of the surface all over the field."""

from __future__ import annotations

import cv2
import numpy as np

from mcsl_core.imaging.geometry import Array, Homography, scaling, size_at_columns, transform_points
from mcsl_core.imaging.masks import Mask, resize_mask
from mcsl_core.imaging.relief import node_pixels

from .field_surface import field_gamma
from .matching import FIELD_POINTS, WIDTH

FEWEST = 20  # points of a field that lay a plane
_CORNERS, _SINGULAR = 4, 1e-9
SURE = 0.25  # confidence of the surface from which a node says where a plane lies


def sure_nodes(gamma: Array, confidence: Array, size: tuple[int, int]) -> Array:
    """Where a surface says how a plane lies.

    Parameters
    ----------
    gamma, confidence : (rows, columns) array
        At nodes over the programme's picture; confidence 0..1.
    size : (int, int)
        Width and height of the programme.

    Returns
    -------
    (N, 3) array
        Scene points: programme pixel and gamma.
    """
    sure = confidence > SURE
    return np.column_stack([node_pixels(gamma.shape, size)[sure.ravel()], gamma[sure]])


def field_points(nodes: Array, field: Mask, size: tuple[int, int], height: float) -> Array:
    """A grid of points of the surface all over the field.

    Parameters
    ----------
    nodes : (N, 3) array
        Scene points that are sure.
    field : (H, W) bool array
        Where the surgical field lies in the programme's picture, of any size.
    size : (int, int)
        Width and height of the programme.
    height : float
        See `height_of_gamma`.

    Returns
    -------
    (M, 3) array
        Scene points; as `field_gamma` carries the surface on where no node is sure. None without any sure node.
    """
    if not len(nodes):
        return np.zeros((0, 3))
    reduced = size_at_columns(size, WIDTH)
    mask = resize_mask(field, reduced)
    at_nodes = transform_points(scaling(size, reduced), nodes[:, :2])
    gamma = field_gamma(np.column_stack([at_nodes, nodes[:, 2]]), mask, height).astype(np.float64)
    every = max(1, int(np.sqrt(mask.sum() / FIELD_POINTS)))
    grid = np.zeros_like(mask)
    grid[::every, ::every] = True
    at = np.argwhere(grid & mask)
    pixels = transform_points(scaling(reduced, size), at[:, ::-1].astype(np.float64))
    return np.column_stack([pixels, gamma[at[:, 0], at[:, 1]]])


def plane_through(seen: Array, home: Array) -> Homography | None:
    """(3, 3): the homography of least squares, camera pixel -> another's, of (N, 2) points; None without one."""
    if len(seen) < _CORNERS or not np.isfinite(seen).all():
        return None
    found = cv2.findHomography(seen, home, 0)[0]
    if found is None or not np.isfinite(found).all() or abs(np.linalg.det(found)) < _SINGULAR:
        return None
    return np.asarray(found, np.float64)
