"""Whether views laid over each other show the same: a test that knows nothing of the matches that laid them so.

A block of one view is looked for in the other where it should be, and in the eight windows around. By chance it is
most alike in the middle one once in nine times; where the two are laid rightly, most times.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.imaging.masks import Mask

# For some 640 aligned columns. Over chance by: 5 to 50 standard deviations where laid rightly, below 2 50 px off.
_BLOCK = 24
_STEP = 16
_CONTRAST = 4.0  # grey levels, standard deviation of a block that can be found again
_CHANCE = 1 / 9
_SURE = 4.0  # standard deviations over chance
_ENOUGH = 80  # blocks tried, by which a tie can be refused: one true one failed by 64, hidden for a whole pose


@frozen
class Agreement:
    """How many blocks of one view are found in the other where they should be.

    Attributes
    ----------
    found : int
        Those most alike in the middle window.
    tried : int
        Those with texture that both views show steadily.
    """

    found: int = 0
    tried: int = 0

    def __add__(self, other: Agreement) -> Agreement:
        return Agreement(self.found + other.found, self.tried + other.tried)

    @property
    def over_chance(self) -> float:
        """By how many standard deviations more are found than by chance."""
        return (self.found - _CHANCE * self.tried) / float(np.sqrt(max(self.tried, 1) * _CHANCE * (1 - _CHANCE)))

    @property
    def refutes(self) -> bool:
        """Whether that is too little for views that are laid rightly."""
        return self.tried >= _ENOUGH and self.over_chance < _SURE


@frozen(eq=False)
class LaidView:
    """A view in aligned pixels: grey (H, W), and where it shows what is steady."""

    grey: NDArray[np.uint8]
    steady: Mask


def agreement(a: LaidView, b: LaidView, reach: int) -> Agreement:
    """Compares two views.

    Parameters
    ----------
    a, b : LaidView
        Laid over each other.
    reach : int
        Half a window in pixels: how far a relief may lead off the plane.

    Returns
    -------
    Agreement
    """
    height, width = a.grey.shape
    half, margin = _BLOCK // 2, 3 * reach + 1 + _BLOCK // 2
    grey = a.grey.astype(np.float32)
    mean = cv2.blur(grey, (_BLOCK, _BLOCK))
    spread = np.sqrt(np.maximum(cv2.blur(grey * grey, (_BLOCK, _BLOCK)) - mean * mean, 0))
    both = (_share(a.steady, _BLOCK) > 0.9) & (_share(b.steady, 2 * margin) > 0.6) & (spread > _CONTRAST)
    found = tried = 0
    for y in range(margin, height - margin, _STEP):
        for x in range(margin, width - margin, _STEP):
            if not both[y, x]:
                continue
            block = a.grey[y - half : y + half, x - half : x + half]
            around = b.grey[y - margin : y + margin, x - margin : x + margin]
            alike = cv2.matchTemplate(around, block, cv2.TM_CCOEFF_NORMED)
            at = cv2.minMaxLoc(alike)[3]
            found += max(abs(v - alike.shape[0] // 2) for v in at) <= reach
            tried += 1
    return Agreement(found, tried)


def refuted(laid: Mapping[str, LaidView], reference: str, reach: int) -> dict[str, Agreement]:
    """The views that are not where the others are.

    Parameters
    ----------
    laid : mapping of str to LaidView
        Camera -> its view, the reference among them.
    reference : str
        The camera that the others are laid over.
    reach : int
        See `agreement`.

    Returns
    -------
    dict of str to Agreement
        Camera -> its agreement with those that agree with the reference, by way of others too. Where too few blocks
        can be tried nothing is refuted: plain drapes, a head before the reference.
    """
    pairs = {pair: agreement(laid[pair[0]], laid[pair[1]], reach) for pair in combinations(sorted(laid), 2)}
    right = {reference}
    while True:
        sure = [pair for pair, found in pairs.items() if found.over_chance >= _SURE]
        near = [pair for pair in sure if len(right.intersection(pair)) == 1]
        if not near:
            break
        right.update(*near)
    wrong = {}
    for name in laid.keys() - right:
        all_found = sum((found for pair, found in pairs.items() if name in pair and right & set(pair)), Agreement())
        if all_found.refutes:
            wrong[name] = all_found
    return wrong


def _share(mask: Mask, box: int) -> NDArray[np.float32]:
    return cv2.blur(mask.astype(np.float32), (box, box), borderType=cv2.BORDER_CONSTANT)  # pyright: ignore
