"""Whether two pictures go up and down alike about each place, whatever their exposure."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

_WINDOW, _FLAT = 9, 3.0  # cells: of a local correlation; codes: less goes neither up nor down

Values = NDArray[np.float32]  # (rows, columns)


def correlation(a: Values, b: Values) -> tuple[Values, Values]:
    """The local correlation of two luma pictures, whatever their exposure.

    Two caps of one colour, before two cameras, are alike anywhere, but their folds go up and down each in its own way.

    Parameters
    ----------
    a, b : (rows, columns) float32
        NaN where there is none.

    Returns
    -------
    (rows, columns) float32
        -1..1, 0 where either is flat.
    (rows, columns) float32
        1 where one of them is not, else 0.
    """
    inside = (~(np.isnan(a) | np.isnan(b))).astype(np.float32)
    share = np.maximum(mean(inside, _WINDOW), 1e-3)
    a, b = (np.asarray(mean(np.nan_to_num(each), 3) * inside, np.float32) for each in (a, b))
    mean_a, mean_b = mean(a, _WINDOW) / share, mean(b, _WINDOW) / share
    var_a = np.maximum(mean(a * a, _WINDOW) / share - mean_a**2, 0)
    var_b = np.maximum(mean(b * b, _WINDOW) / share - mean_b**2, 0)
    both = mean(a * b, _WINDOW) / share - mean_a * mean_b
    seen = share > 0.5
    sure = seen & (var_a * var_b > _FLAT**4)
    found = np.where(sure, both / np.sqrt(np.maximum(var_a * var_b, 1e-6)), 0)
    return found.astype(np.float32), (seen & (np.maximum(var_a, var_b) > _FLAT**2)).astype(np.float32)


def mean(values: Values, side: int) -> Values:
    """The mean of ``side`` x ``side`` cells about each."""
    return np.asarray(cv2.blur(values, (side, side), borderType=cv2.BORDER_REPLICATE), np.float32)
