"""Hands that rest over the field, told by their height: narrow things above their surroundings, and above the field.

A hand that works at one place all through a pose is as steady as the patient, and its bloody fingers have the wound's
colours. Nor do steep sides tell it: limbs and open wounds fall by 4 to 8 px of 960 over 8 px, hands by 4 to 11.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.imaging.geometry import Array
from mcsl_core.imaging.masks import Mask

from .field_surface import FieldBend, inside
from .interpolation import gamma_map

_CELL = 4  # pixels of the picture
_WIDE = 0.29  # of the picture's width: what is narrower is looked for; a hand is 0.1 to 0.17
_STANDS = 25.0  # pixels of 960 above what is around
_FLANK, _REACH = 12.0, 3  # what stands so high is part of it, so many cells on: matches ramp from a hand to the ground
# Above what the rest of the field says lies there: of limbs and wounds that is 6 to 17 px in the median, of hands 30
# to 65; then, without these, all that is no patient any more.
_ABOVE, _STILL_ABOVE, _ROUNDS = 20.0, 8.0, 2
_LEAST = 20  # points of the field, with fewer nothing can be said
_MOST = 0.75  # of the field's points; more is the field itself


def standing_above(points: Array, field: Mask, height: float) -> NDArray[np.bool_]:
    """Which points belong to hands that stand over the field.

    Parameters
    ----------
    points : (N, 3) array
        x and y in pixels of the picture, and gamma; of all the picture, one at least.
    field : (H, W) bool array
        Where the field lies in it.
    height : float
        Pixels of 960 that gamma 1 stands above gamma 0; see `height_of_gamma`.

    Returns
    -------
    (N,) bool array
        All false where the field is of one piece.

    Notes
    -----
    White top-hat of the heights, whose pieces are held against a robust quadric through the rest of the field: a limb's
    crest stands above its surroundings too, but not above its own sides carried on.

    Error over the best plane's, before and after: near-black skin 2.1 to 2.6, now 1.16 to 1.19; two recordings of hands
    on a limb 1.9 to 2.2, now 1.04 to 1.08, and 2.1 to 2.45, now 1.8 to 2.1. On 22 other poses of wounds, limbs and skin
    without such hands nothing changed by more than 0.04.
    """
    own = inside(points, field)
    nothing = np.zeros(len(points), bool)
    if own.sum() < _LEAST:
        return nothing
    pieces = _narrow(points, (field.shape[1], field.shape[0]), height)
    candidate = pieces[tuple(np.clip(points[:, 1::-1] // _CELL, 0, np.array(pieces.shape) - 1).astype(int).T)]
    hand, above = candidate, _ABOVE
    for _ in range(_ROUNDS + 1):
        if not (own & hand).any():
            return nothing
        rest = own & ~hand if (own & hand).sum() <= _MOST * own.sum() else own  # of a limb all stands above the drapes
        over = points[:, 2] * height - FieldBend.through(points[rest], field, height).at(points[:, :2])
        hand, above = candidate & (over > above), _STILL_ABOVE
    return hand if 0 < (own & hand).sum() <= _MOST * own.sum() else nothing


def _narrow(points: Array, size: tuple[int, int], height: float) -> Mask:
    """(rows, columns) of cells: where something narrow stands above its surroundings."""
    cells = (size[0] // _CELL + 1, size[1] // _CELL + 1)
    heights = cv2.resize(gamma_map(points, size) * height, cells, interpolation=cv2.INTER_AREA)
    around = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (round(_WIDE * cells[0]) | 1,) * 2)
    hat = cv2.morphologyEx(heights, cv2.MORPH_TOPHAT, around, borderType=cv2.BORDER_REPLICATE)
    found, flank = (hat > _STANDS).astype(np.uint8), hat > _FLANK
    for _ in range(_REACH):
        found |= (cv2.dilate(found, cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))) > 0) & flank
    return found > 0
