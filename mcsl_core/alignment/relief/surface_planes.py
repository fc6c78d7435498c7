"""What ties the planes of a pose whose surface is known: points of the surface all over the field, hands left out."""

from __future__ import annotations

import numpy as np

from mcsl_core.imaging.geometry import Array, project, scaling, size_at_columns, transform_points
from mcsl_core.imaging.masks import Mask, mask_at, resize_mask
from mcsl_core.imaging.relief import node_pixels

from ..correspondences import Correspondences, Pairs
from .field_surface import field_gamma
from .matching import AROUND_WEIGHT, FIELD_POINTS, WIDTH
from .pose_relief import PoseRelief

_LAYS = 0.25  # confidence of the surface from which a node says where a plane lies


def surface_pairs(relief: PoseRelief, reference: str, field: Mask) -> Pairs:
    """Where every camera sees a grid of points all over the field, by the surface as it goes on under hands.

    Parameters
    ----------
    relief : PoseRelief
        Of a pose in which hands rest; it serves the reference camera.
    reference : str
        The pose's reference camera.
    field : (H, W) bool array
        Where the surgical field lies in the programme's picture, of any size.

    Returns
    -------
    mapping of (str, str) to Correspondences
        Each camera's with the reference; outside of the field what weighs next to nothing, as `field_pairs` has it.
    """
    size = relief.scene.size
    nodes = sure_nodes(relief.seen.gamma, relief.seen.confidence, size)
    if not len(nodes):
        return {}
    inside = field_points(nodes, field, size, relief.height)
    beside = nodes[~mask_at(field, transform_points(scaling(size, field.shape[::-1]), nodes[:, :2]))]
    weight = np.concatenate([np.ones(len(inside)), np.full(len(beside), AROUND_WEIGHT)])
    scene = np.concatenate([inside, beside])
    seen = np.ones(len(scene), np.int64)
    own = project(relief.scene.cameras[reference].projection, scene)
    return {
        (reference, name): Correspondences(own, project(camera.projection, scene), weight, seen)
        for name, camera in relief.scene.cameras.items()
        if name != reference and name in relief.surface.cameras
    }


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
    sure = confidence > _LAYS
    return np.column_stack([node_pixels(gamma.shape, size)[sure.ravel()], gamma[sure]])


def field_points(nodes: Array, field: Mask, size: tuple[int, int], height: float) -> Array:
    """A grid of points of the surface all over the field.

    Parameters
    ----------
    nodes : (N, 3) array
        Scene points that are sure; one at least.
    field : (H, W) bool array
        Where the surgical field lies in the programme's picture, of any size.
    size : (int, int)
        Width and height of the programme.
    height : float
        See `height_of_gamma`.

    Returns
    -------
    (M, 3) array
        Scene points; as `field_gamma` carries the surface on where no node is sure.
    """
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
