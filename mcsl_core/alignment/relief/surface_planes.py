"""What ties the planes of a pose in which hands rest: points of the surface all over the field, hands left out."""

from __future__ import annotations

import numpy as np

from mcsl_core.imaging.geometry import project, scaling, size_at_columns, transform_points
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
    full, size = relief.scene.size, size_at_columns(relief.scene.size, WIDTH)
    mask = resize_mask(field, size)
    surface = relief.seen
    sure = surface.confidence > _LAYS
    if not sure.any():
        return {}
    nodes = np.column_stack([node_pixels(sure.shape, full)[sure.ravel()], surface.gamma[sure]])
    at_nodes = transform_points(scaling(full, size), nodes[:, :2])
    gamma = field_gamma(np.column_stack([at_nodes, nodes[:, 2]]), mask, relief.height).astype(np.float64)
    every = max(1, int(np.sqrt(mask.sum() / FIELD_POINTS)))
    inside = np.zeros_like(mask)
    inside[::every, ::every] = True
    at = np.argwhere(inside & mask)
    to_full = scaling(size, full)
    scene = np.column_stack([transform_points(to_full, at[:, ::-1].astype(np.float64)), gamma[at[:, 0], at[:, 1]]])
    beside = nodes[~mask_at(mask, at_nodes)]
    weight = np.concatenate([np.ones(len(scene)), np.full(len(beside), AROUND_WEIGHT)])
    scene = np.concatenate([scene, beside])
    seen = np.ones(len(scene), np.int64)
    own = project(relief.scene.cameras[reference].projection, scene)
    return {
        (reference, name): Correspondences(own, project(camera.projection, scene), weight, seen)
        for name, camera in relief.scene.cameras.items()
        if name != reference and name in relief.surface.cameras
    }
