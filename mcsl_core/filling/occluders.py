"""Who is in the way of the camera that stands behind the chosen one."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
from attrs import frozen

from mcsl_core.imaging.rect import Rect

from .cells import Weight, shown_in, touched
from .layers import FillPlan
from .protocol import CELL, FillContext
from .sources import Source, crossfade, median_frames

_MOVES = (10.0, 24.0)  # codes by which a cell differs from its median: nothing moves, somebody does
_ALONE = (0.5, 0.8)  # share of the motion near by that the chosen camera does not have: both have it, the other alone
_NEAR = 1 / 12  # sigma, of the width
_LEAST = 2e-3  # of the motion near by, for which it counts


@frozen(eq=False)
class Occluder:
    """Somebody in the way of one camera.

    Attributes
    ----------
    cells : (ceil(height / 16), ceil(width / 16)) float32
        How much of each cell of the programme is hidden, 0..1.
    """

    cells: Weight

    def within(self, rect: Rect) -> Rect | None:
        """The part of ``rect`` outside of which nobody is in the way; None without any."""
        return touched(self.cells, CELL, rect)

    def weights(self, rect: Rect, step: int) -> Weight:
        """How much of a rectangle's samples is hidden; see `shown_in`."""
        return shown_in(self.cells, CELL, rect, step)


Occluders = Mapping[str, Occluder]  # by camera


@frozen(eq=False)
class Motion:
    """Who moves where, by cell of the programme, 0..1.

    Attributes
    ----------
    camera : str
        The one that is decoded beside the chosen one.
    own, other : (ceil(height / 16), ceil(width / 16)) float32
        In the chosen camera's picture, and in the other's.
    """

    camera: str
    own: Weight
    other: Weight

    def crosses(self, overlap: Weight) -> bool:
        """Whether in the other's picture something moves on both sides of the chosen one's edge."""
        count, labels = cv2.connectedComponents((self.other > 0.5).astype(np.uint8))
        inside = np.unique(labels[overlap > 0.5])
        return bool(np.isin(np.unique(labels[overlap < 0.5]), inside[inside > 0]).any()) if count > 1 else False


def find_motion(context: FillContext, plan: FillPlan) -> Motion | None:
    """Who moves; None where nobody does beyond the chosen camera's picture, or no camera is decoded beside it."""
    if plan.overlap is None:
        return None
    camera = next(source.camera for source in plan.sources[1:] if source.live)
    other = _motion(context, camera)
    if not (other * (1 - plan.overlap)).any():
        return None
    return Motion(camera, _motion(context, context.camera), other)


def find_occluders(overlap: Weight, motion: Motion) -> Occluders:
    """Where somebody hides the field from the camera decoded beside the chosen one, but not from the chosen one.

    The chosen camera is the least occluded; a head that hides the field from the other one would come back with its
    picture, as half a head beyond the edge. Whoever moves in both (hands, arms) belongs there and stays.

    Parameters
    ----------
    overlap : (ceil(height / 16), ceil(width / 16)) float32
        Where both have a picture.
    motion : Motion
        Of both.

    Returns
    -------
    mapping of str to Occluder
        By camera; empty where nobody is in the way.

    Notes
    -----
    Outside the chosen camera's picture it goes by the surroundings, in which both have one.
    """
    alone = _blurred(np.asarray(overlap * (motion.other * (1 - motion.own)), np.float32))
    near = _blurred(np.asarray(overlap * motion.other, np.float32))
    only = np.clip((alone / (near + _LEAST) - _ALONE[0]) / (_ALONE[1] - _ALONE[0]), 0, 1)
    cells = cv2.GaussianBlur(cv2.dilate(motion.other * only, np.ones((5, 5), np.uint8)), (0, 0), 1.0)
    return {motion.camera: Occluder(np.asarray(cells, np.float32))} if cells.max() > 0.02 else {}


def _motion(context: FillContext, camera: str) -> Weight:
    """0..1 by cell: whether the camera shows there now what it does not show most of the time."""
    changes = [context.change(camera, frames) for frames in median_frames(context, Source(camera, median=True))]
    weight = crossfade(context)
    change = changes[0] if len(changes) < 2 else changes[0] * weight + changes[1] * (1 - weight)
    return np.clip((change - _MOVES[0]) / (_MOVES[1] - _MOVES[0]), 0, 1).astype(np.float32)


def _blurred(cells: Weight) -> Weight:
    sigma = _NEAR * cells.shape[1]
    return np.asarray(cv2.GaussianBlur(cells, (0, 0), sigma, borderType=cv2.BORDER_CONSTANT), np.float32)
