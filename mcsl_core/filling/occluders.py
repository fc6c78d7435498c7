"""Who is in the way of the camera that stands behind the chosen one."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
from attrs import frozen

from mcsl_core.imaging.rect import Rect

from .layers import FillPlan, Weight
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
        x, y, width, height = cv2.boundingRect((self.cells > 1 / 512).astype(np.uint8))
        left, top = max(rect.x, CELL * (x - 1)), max(rect.y, CELL * (y - 1))
        right = min(rect.x + rect.width, CELL * (x + width + 1))
        bottom = min(rect.y + rect.height, CELL * (y + height + 1))
        return Rect(left, top, right - left, bottom - top) if width and left < right and top < bottom else None

    def weights(self, rect: Rect, step: int) -> Weight:
        """How much of a rectangle's samples is hidden.

        Parameters
        ----------
        rect : Rect
            In programme pixels.
        step : int
            At every so many pixels: 1 for luma samples, 2 for chroma samples.

        Returns
        -------
        (rect.height / step, rect.width / step) float32
            0..1, interpolated from ``cells``.
        """
        cell = CELL // step
        matrix = np.array([[cell, 0, cell / 2 - 0.5 - rect.x / step], [0, cell, cell / 2 - 0.5 - rect.y / step]])
        size = (rect.width // step, rect.height // step)
        wide = cv2.warpAffine(self.cells, matrix, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(wide, np.float32)


Occluders = Mapping[str, Occluder]  # by camera


def find_occluders(context: FillContext, plan: FillPlan) -> Occluders:
    """Where somebody hides the field from the camera decoded beside the chosen one, but not from the chosen one.

    The chosen camera is the least occluded; a head that hides the field from the other one would come back with its
    picture, as half a head beyond the edge. Whoever moves in both (hands, arms) belongs there and stays.

    Parameters
    ----------
    context : FillContext
        The programme frame.
    plan : FillPlan
        Says which camera is decoded beside the chosen one, and where both have a picture.

    Returns
    -------
    mapping of str to Occluder
        By camera; empty where nobody is in the way.

    Notes
    -----
    Outside the chosen camera's picture it goes by the surroundings, in which both have one.
    """
    if plan.overlap is None:
        return {}
    camera = next(source.camera for source in plan.sources[1:] if source.live)
    other = _motion(context, camera)
    if not (other * (1 - plan.overlap)).any():
        return {}
    own = _motion(context, context.camera)
    alone = _blurred(np.asarray(plan.overlap * (other * (1 - own)), np.float32))
    near = _blurred(np.asarray(plan.overlap * other, np.float32))
    only = np.clip((alone / (near + _LEAST) - _ALONE[0]) / (_ALONE[1] - _ALONE[0]), 0, 1)
    cells = cv2.GaussianBlur(cv2.dilate(other * only, np.ones((5, 5), np.uint8)), (0, 0), 1.0)
    return {camera: Occluder(np.asarray(cells, np.float32))} if cells.max() > 0.02 else {}


def _motion(context: FillContext, camera: str) -> Weight:
    """0..1 by cell: whether the camera shows there now what it does not show most of the time."""
    changes = [context.change(camera, frames) for frames in median_frames(context, Source(camera, median=True))]
    weight = crossfade(context)
    change = changes[0] if len(changes) < 2 else changes[0] * weight + changes[1] * (1 - weight)
    return np.clip((change - _MOVES[0]) / (_MOVES[1] - _MOVES[0]), 0, 1).astype(np.float32)


def _blurred(cells: Weight) -> Weight:
    sigma = _NEAR * cells.shape[1]
    return np.asarray(cv2.GaussianBlur(cells, (0, 0), sigma, borderType=cv2.BORDER_CONSTANT), np.float32)
