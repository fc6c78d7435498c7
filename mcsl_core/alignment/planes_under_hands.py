"""Planes that serve the field itself where hands rest over it: matches took the hands' height for its own."""

from __future__ import annotations

import attrs
import numpy as np

from mcsl_core.imaging.geometry import scaling, to_edl_matrix
from mcsl_core.imaging.masks import warp_mask
from mcsl_core.imaging.relief import between_nodes

from .dense_matching import pixels_of
from .observations import SolvedPose
from .protocol import Aligner
from .relief.pose_relief import PoseRelief
from .relief.surface_planes import surface_pairs

_COVERED = 0.05  # of the field by hands that rest, from which its planes are laid anew


def with_planes_under_hands(pose: SolvedPose, relief: PoseRelief, aligner: Aligner) -> SolvedPose:
    """The pose by planes that serve the field itself, where hands rest over it.

    Parameters
    ----------
    pose : SolvedPose
        Anchored.
    relief : PoseRelief
        Its relief.
    aligner : Aligner
        What ties its cameras together.

    Returns
    -------
    SolvedPose
        ``pose`` itself where hands cover little of the field or the surface does not tie all cameras. Without hands
        planes by matches are better: where no node is sure, on a limb's sides, they have the matches' own bend.
    """
    aligned, reference = pose.aligned, pose.aligned.reference
    full = aligned.camera_sizes[reference]
    warp = scaling(full, aligned.size) @ np.array(pose.pose.anchor) @ scaling(aligned.size, full)
    field = warp_mask(aligned.field, warp, aligned.size)
    hands = between_nodes(relief.hands[..., None], aligned.size, pixels_of(aligned.size)).reshape(field.shape)
    covered = field & (hands > 0.5)
    if reference not in relief.surface.cameras or covered.sum() < _COVERED * max(field.sum(), 1):
        return pose
    pairs = surface_pairs(relief, reference, field)
    if not pairs:
        return pose
    sizes = {name: aligned.camera_sizes[name] for name in (reference, *(name for _, name in pairs))}
    found = aligner.align(pairs, sizes, reference)
    if found.weak:
        return pose
    homographies = {**aligned.homographies, **found.homographies}
    made = attrs.evolve(
        pose.pose,
        homographies={name: to_edl_matrix(h) for name, h in homographies.items()},
        residual_px={**pose.pose.residual_px, **{n: round(v, 3) for n, v in found.residual_px.items()}},
        support={**pose.pose.support, **found.support},
    )
    return attrs.evolve(pose, pose=made, aligned=attrs.evolve(aligned, homographies=homographies))
