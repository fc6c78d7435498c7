"""How far a camera's views of several groups of moments bear each other out.

Hands and sleeves that rest for some seconds are steady, but not where the others have them.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray

from .protocol import ReliefView

# Grey levels of 255, exposure levelled; and of the slope of an edge, which shakes by a fraction of a pixel.
_SAME = 8.0
_SLOPE = 0.7
_AROUND = 9  # pixels
_MOST = 0.75  # of those around a place are the same where it is
_ENOUGH = 500  # pixels that both show, to level their exposure by
MOST_WEIGHT = 3


def weights_of(views: Sequence[ReliefView]) -> NDArray[np.uint8]:
    """How much each view counts at each of its pixels.

    Parameters
    ----------
    views : sequence of ReliefView
        One camera's, of one pose and all of one size.

    Returns
    -------
    (V, h, w) uint8 array
        3 where no other is borne out by more views, 2 where one is by up to twice as many, 1 where none is by any, and
        0 where a view stands alone against two that agree, or is not steady.
    """
    greys = [_grey(view) for view in views]
    slopes = [_slope(grey) for grey in greys]
    agree = np.zeros((len(views), *greys[0].shape), np.uint8)
    for i, j in combinations(range(len(views)), 2):
        both = views[i].steady & views[j].steady
        off = greys[i] - greys[j]
        off -= np.median(off[both]) if both.sum() > _ENOUGH else 0
        same = (np.abs(off) <= _SAME + _SLOPE * slopes[i]).astype(np.float32)
        found = both & (cv2.blur(same, (_AROUND, _AROUND)) > _MOST)
        agree[i] += found
        agree[j] += found
    most = agree.max(axis=0)
    alone = np.where(most > 1, 0, 1)
    weights = np.where(agree == 0, alone, np.where(2 * agree >= most, 2, 0))
    weights = np.where(agree == most, np.where(most == 0, 1, MOST_WEIGHT), weights)
    if len(views) == 1:
        weights[:] = MOST_WEIGHT
    return (weights * np.stack([view.steady for view in views])).astype(np.uint8)


def _grey(view: ReliefView) -> NDArray[np.float32]:
    grey = cv2.cvtColor(view.picture, cv2.COLOR_BGR2GRAY).astype(np.float32)
    return cv2.blur(grey, (3, 3))  # pyright: ignore[reportReturnType]


def _slope(grey: NDArray[np.float32]) -> NDArray[np.float32]:
    across, down = (cv2.Sobel(grey, cv2.CV_32F, *way, scale=0.125) for way in ((1, 0), (0, 1)))
    return cv2.blur(cv2.magnitude(across, down), (5, 5))  # pyright: ignore[reportReturnType]
