"""Where every camera's aligned view has the hands that rest in a pose, at their own height."""

from __future__ import annotations

import cv2
import numpy as np

from mcsl_core.imaging.geometry import project, transform_points
from mcsl_core.imaging.masks import Mask
from mcsl_core.imaging.relief import between_nodes, node_pixels

from ..aligned_views import AlignedPose
from .pose_relief import PoseRelief

_FINER = 4  # times as fine as the nodes hands are laid into a view


def hand_masks(relief: PoseRelief, aligned: AlignedPose) -> dict[str, Mask]:
    """Where each camera's view of an aligned pose has the hands that rest in it.

    Parameters
    ----------
    relief : PoseRelief
        Of the same pose.
    aligned : AlignedPose
        How its views lie.

    Returns
    -------
    dict of str to (H, W) bool array
        At the hands' own height; of cameras that the relief does not know as the reference camera has them. Empty
        without hands.
    """
    if not relief.hands.any():
        return {}
    size = relief.scene.size
    pixels = node_pixels((_FINER * relief.hands.shape[0], _FINER * relief.hands.shape[1]), size)
    hand, gamma = between_nodes(np.stack([relief.hands, relief.over], axis=-1), size, pixels).T
    scene = np.column_stack([pixels, gamma])[hand > 0.5]
    found = {}
    for name in sorted(relief.scene.cameras.keys() & aligned.homographies.keys()):
        seen = project(relief.scene.cameras[name].projection, scene)
        laid = np.round(transform_points(aligned.warp_of(name, aligned.camera_sizes[name]), seen)).astype(int)
        laid = laid[((laid >= 0) & (laid < aligned.size)).all(axis=1)]
        mask = np.zeros(aligned.size[::-1], np.uint8)
        mask[laid[:, 1], laid[:, 0]] = 1
        found[name] = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8)) > 0
    nearest = found.get(aligned.reference, np.zeros(aligned.size[::-1], bool))
    return {name: found.get(name, nearest) for name in sorted(aligned.homographies)}
