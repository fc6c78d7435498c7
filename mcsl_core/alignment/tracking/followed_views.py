"""The views of a frame in which the lamp moves and is followed, over the pixels of the pose that its samples are of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs
import numpy as np

from mcsl_core.edl import Movement
from mcsl_core.edl.following import homographies_at
from mcsl_core.imaging.geometry import Array, inverse

from ..aligned_views import AlignedPose


def aligned_at(
    aligned: AlignedPose, anchor: Array, movements: Sequence[Movement], shown: Mapping[str, float]
) -> AlignedPose:
    """A pose as its cameras lie at some instants.

    Parameters
    ----------
    aligned : AlignedPose
        How they lie in it.
    anchor : (3, 3) array
        Its reference camera's pixel -> programme pixel.
    movements : sequence of Movement
        Those that are followed have views.
    shown : mapping of str to float
        Camera -> when its picture was taken, in programme frames.

    Returns
    -------
    AlignedPose
        ``aligned`` itself where the lamp stands for all of them. A camera that is not known while it moves is left out.
    """
    found, moves = dict(aligned.homographies), False
    for name, at in shown.items():
        for movement in movements:
            if movement.views and movement.views[0].frame < at < movement.views[-1].frame:
                moves = True
                there = homographies_at(movement, {name: at}).get(name)
                found.pop(name, None)
                if there is not None:
                    found[name] = inverse(anchor) @ np.array(there)
    return attrs.evolve(aligned, homographies=found) if moves else aligned
