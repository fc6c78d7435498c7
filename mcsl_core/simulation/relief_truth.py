"""The relief of a simulated recording as its truth has it: exact projections, heights from the field's own points."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import griddata

from mcsl_core.edl import Relief
from mcsl_core.imaging.geometry import to_edl_projection

from .truth import Truth


def true_relief(truth: Truth, pose_index: int, *, every: int = 1, nodes: tuple[int, int] = (96, 54)) -> Relief:
    """The relief of one pose.

    Parameters
    ----------
    truth
        Of the recording.
    pose_index
        Which pose; in the reference's perspective then. The plane, gamma 0, is the one nearest to the points.
    every
        It is made from every so many-th point, and confident among them.
    nodes
        Of its grid, columns and rows.
    """
    pose, reference = truth.poses[pose_index], truth.camera_index(truth.reference)
    at = pose.field_points_px[reference][::every]
    world = truth.field_points_mm[::every]
    turn, shift = pose.R[reference], pose.t[reference]
    depth = (world @ turn.T + shift)[:, 2]
    ahead = np.column_stack([at, np.ones(len(at))])
    plane = np.linalg.lstsq(ahead, 1 / depth, rcond=None)[0]
    own = {}
    for k, name in enumerate(truth.cameras):
        between = pose.R[k] @ turn.T
        far = pose.K[k] @ between @ np.linalg.inv(pose.K[reference])
        near = pose.K[k] @ (pose.t[k] - between @ shift)
        own[name] = np.column_stack([far + np.outer(near, plane), near])
    scale = 1e-6  # of an inverse mm: about a pixel
    projections = {}
    for name, matrix in own.items():
        matrix[:, 3] *= scale
        projections[name] = to_edl_projection(matrix)
    x, y = np.meshgrid(*(np.linspace(0, n - 1, count) for n, count in zip(truth.size, nodes, strict=True)))
    gamma = griddata(at, (1 / depth - ahead @ plane) / scale, (x, y), method="linear")
    known = np.isfinite(gamma)
    return Relief(
        projections,
        tuple(map(tuple, np.nan_to_num(gamma).round(3).tolist())),
        tuple(map(tuple, np.where(known, 100, 0).tolist())),
    )
