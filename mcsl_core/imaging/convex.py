"""Convex regions: what the straight edges of drapes leave open, whatever lies above it."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from .masks import Mask

_DIRECTIONS = 36  # of edges; with 16 a slanted field's sides are missed by up to 11 degrees
_MOST_MOVES = 60
_REACH = 7  # pixels that a region may reach out of its start
_LEAST = 3  # pixels from the middle of the start to an edge
# What a pixel of outline costs: a finger in blood beside a narrow field is cut off (overlap 0.80 to 0.88); with 4 the
# whole field is, where its colours are unsure.
_OUTLINE = 2.0


def convex_region(worth: NDArray[np.float32], start: Mask) -> Mask:
    """A convex region whose pixels are worth much, and whose outline is short.

    Parameters
    ----------
    worth : (H, W) float array
        Of every pixel: positive inside, negative outside, 0 where nothing is known.
    start : (H, W) bool array
        Convex; the region reaches seven pixels out of it at most.

    Returns
    -------
    (H, W) bool array
        Empty where ``start`` is.

    Notes
    -----
    An intersection of half planes. The one edge whose best place gains most is moved there, again and again, until none
    gains. Begun from outside, since edges that have closed in hold each other back.
    """
    if not start.any():
        return start.copy()
    use = cv2.dilate(start.astype(np.uint8), np.ones((2 * _REACH + 1,) * 2, np.uint8)) > 0
    y, x = np.nonzero(use)
    middle = np.argwhere(start).mean(axis=0)
    turn = np.arange(_DIRECTIONS) * 2 * np.pi / _DIRECTIONS
    along = np.outer(np.cos(turn), x - middle[1]) + np.outer(np.sin(turn), y - middle[0])
    off = np.clip(np.round(along), 0, None).astype(np.int16)  # from the middle, in each direction
    cut = off > off[:, start[use]].max(axis=1)[:, None]
    cuts = cut.sum(axis=0)  # by how many edges every pixel is cut off
    now = -np.inf
    for _ in range(_MOST_MOVES):
        places = []
        for edge in range(_DIRECTIONS):
            free = np.zeros(worth.shape, np.uint8)
            free[use] = cuts == cut[edge]  # by no other edge
            line = (free > cv2.erode(free, np.ones((3, 3), np.uint8)))[use]
            places.append((*_best_place(off[edge], worth[use], free[use] > 0, line), edge))
        best, place, edge = max(places)
        if best - now < 0.002 * abs(best) + 0.5:
            break
        now = best
        cuts -= cut[edge]
        cut[edge] = off[edge] > place
        cuts += cut[edge]
    region = np.zeros(worth.shape, bool)
    region[use] = cuts == 0
    return region


def _best_place(off: NDArray[np.int16], worth: NDArray[np.float32], free: Mask, line: Mask) -> tuple[float, int]:
    """What a region is worth whose edge lies where that is most, and how far out that is.

    ``free``: pixels within all other edges; ``line``: those on their outline. The edge itself is as long as there are
    free pixels along it.
    """
    count = max(int(off.max()), _LEAST) + 1
    within = np.cumsum(np.bincount(off[free], worth[free], minlength=count))
    outline = np.cumsum(np.bincount(off[line], minlength=count))
    chord = np.convolve(np.bincount(off[free], minlength=count), [0.25, 0.5, 0.25], "same")  # slanted rows alternate
    total = within - _OUTLINE * (outline + chord)
    place = _LEAST + int(total[_LEAST:].argmax())
    return float(total[place]), place
