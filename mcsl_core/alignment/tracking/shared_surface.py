"""One surface for a perspective: what one of its poses does not show well, it has from the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs
import numpy as np

from ..relief.pose_relief import relief_document
from .standing_poses import StandingPose

_SURER = 0.25  # in confidence: another pose's surface that is so much surer is taken whole, by degrees before
_SURE = 0.75  # confidence from which a pose's own height stays, whoever is surer
_KNOWN = 0.2  # confidence at which two poses are compared
_COMPARED, _SAME = 30, 4.0 / 960  # nodes at least; of the width, median: heights that mean the same


def with_shared_surface(poses: Mapping[int, StandingPose]) -> dict[int, StandingPose]:
    """The poses of a perspective, each with the surest surface that any of them shows.

    Parameters
    ----------
    poses : mapping of int to StandingPose
        Whose projections one rigid rig explains, so that a height means the same in all.

    Returns
    -------
    dict of int to StandingPose
        Planes, projections and fields as they were. A place that a pose shows as well itself keeps its own height: an
        operation changes what it works on. A pose whose heights contradict another's shares none with it: where it was
        not tied to the first one's scene its heights mean something else.
    """
    shapes = {pose.gamma.shape for pose in poses.values()}
    if len(poses) < 2 or len(shapes) > 1:
        return dict(poses)
    return {
        i: _lent(own, [pose for n, pose in poses.items() if n != i and _alike(own, pose)]) for i, own in poses.items()
    }


def _lent(own: StandingPose, others: Sequence[StandingPose]) -> StandingPose:
    """The pose with what the surest of others knows better; itself where that is nothing."""
    if not others:
        return own
    best = np.stack([pose.confidence for pose in others]).argmax(axis=0)[None]
    theirs, sure = (
        np.take_along_axis(np.stack(values), best, axis=0)[0]
        for values in ([pose.gamma for pose in others], [pose.confidence for pose in others])
    )
    share = np.clip(np.minimum(sure - own.confidence, _SURE - own.confidence) / _SURER, 0, 1)
    if not share.any():
        return own
    gamma = own.gamma + share * (theirs - own.gamma)
    confidence = own.confidence + share * (sure - own.confidence)
    relief = relief_document(own.projections, gamma, confidence)
    standing = StandingPose.of(attrs.evolve(own.pose, pose=attrs.evolve(own.pose.pose, relief=relief)))
    return own if standing is None else attrs.evolve(standing, view=own.view)


def _alike(one: StandingPose, other: StandingPose) -> bool:
    """Whether two poses say the same where both know something."""
    both = (one.confidence > _KNOWN) & (other.confidence > _KNOWN)
    width = one.pose.aligned.camera_sizes[one.pose.aligned.reference][0]
    return both.sum() >= _COMPARED and float(np.median(np.abs(one.gamma - other.gamma)[both])) < _SAME * width
