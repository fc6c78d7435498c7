"""A perspective laid anew over what the reference camera shows in its first pose, once that is known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs
import numpy as np

from mcsl_core.edl import Pose
from mcsl_core.imaging.geometry import Array, Homography, depths, inverse, project, to_edl_matrix
from mcsl_core.imaging.relief import between_nodes, node_pixels

from ..observations import SolvedPose
from ..relief.pose_relief import relief_document
from ..relief.surface_planes import FEWEST, plane_through
from .standing_poses import StandingPose

_EXACT, _STEPS = 0.01, 30  # pixels; a surface over other pixels


def based_on_first(poses: list[SolvedPose], known: Mapping[int, StandingPose], here: Sequence[int]) -> None:
    """Lays a perspective's programme over what the reference camera shows in its first pose, changing ``poses``.

    The programme's pixels were a later pose's, by an anchor that the first one's bad views made.

    Parameters
    ----------
    poses : list of SolvedPose
        The recording's.
    known : mapping of int to StandingPose
        By their positions in ``poses``, the first of the perspective among them.
    here : sequence of int
        The perspective's positions, in order.
    """
    first = known[here[0]]
    reference = first.pose.aligned.reference
    to_new = np.vstack([first.projections[reference], [0, 0, 0, 1]])
    points = _laying(first)
    between = plane_through(points[:, :2], project(to_new[:3], points))
    if between is None:
        return
    for i in here:
        if i in known:
            pose = _over(known[i], to_new, between)
        else:  # its relief, if it has one, is over the old pixels
            anchor = between @ np.array(poses[i].pose.anchor)
            pose = attrs.evolve(poses[i].pose, anchor=to_edl_matrix(anchor), relief=None)
        poses[i] = attrs.evolve(poses[i], pose=pose)


def _over(standing: StandingPose, to_new: Array, between: Homography) -> Pose:
    """The pose over other pixels: (4, 4) ``to_new`` leads there from programme pixels and gamma, ``between`` nearly."""
    reference = standing.pose.aligned.reference
    size = standing.pose.aligned.camera_sizes[reference]
    scene, confidence = _showing(standing, to_new, size)
    shape = standing.gamma.shape
    gamma = scene[:, 2] / depths(to_new[:3], scene)
    projections = {name: p @ inverse(to_new) for name, p in standing.projections.items()}
    relief = relief_document(projections, gamma.reshape(shape), confidence.reshape(shape))
    points = _laying(standing)
    anchor = plane_through(project(standing.projections[reference], points), project(to_new[:3], points))
    if anchor is None:
        anchor = between @ np.array(standing.pose.pose.anchor)
    return attrs.evolve(standing.pose.pose, anchor=to_edl_matrix(anchor), relief=relief)


def _showing(standing: StandingPose, to_new: Array, size: tuple[int, int]) -> tuple[Array, Array]:
    """(N, 3) and (N,): the scene points, and how sure they are, that nodes over the new pixels show."""
    nodes = at = node_pixels(standing.gamma.shape, size)
    both = np.stack([standing.gamma, standing.confidence], axis=-1)
    for _ in range(_STEPS):
        off = nodes - project(to_new[:3], np.column_stack([at, between_nodes(both, size, at)[:, 0]]))
        at = at + off
        if np.abs(off).max() < _EXACT:
            break
    gamma, confidence = between_nodes(both, size, at).T
    return np.column_stack([at, gamma]), confidence


def _laying(standing: StandingPose) -> Array:
    """(N, 3): scene points that lay a pose; all that are known where the field has few."""
    points = standing.field_points()
    return points if len(points) >= FEWEST else standing.points
