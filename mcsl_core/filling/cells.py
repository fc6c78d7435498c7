"""Weights by cells of the programme: spread over its pixels, and where they are anything."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.imaging.rect import Rect

Weight = NDArray[np.float32]


def shown_in(cells: Weight, cell: int, rect: Rect, step: int) -> Weight:
    """Weights by cell at a rectangle's samples.

    Parameters
    ----------
    cells : (ceil(height / cell), ceil(width / cell)) float32
        0..1.
    cell : int
        Programme pixels in a cell's side.
    rect : Rect
        In programme pixels.
    step : int
        At every so many pixels: 1 for luma samples, 2 for chroma samples.

    Returns
    -------
    (rect.height / step, rect.width / step) float32
        Interpolated.
    """
    side = cell / step
    matrix = np.array([[side, 0, side / 2 - 0.5 - rect.x / step], [0, side, side / 2 - 0.5 - rect.y / step]])
    size = (rect.width // step, rect.height // step)
    wide = cv2.warpAffine(cells, matrix, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(wide, np.float32)


def touched(cells: Weight, cell: int, rect: Rect) -> Rect | None:
    """The part of ``rect`` outside of which all weights are nothing; None without any."""
    x, y, width, height = cv2.boundingRect((cells > 1 / 512).astype(np.uint8))
    left, top = max(rect.x, cell * (x - 1)), max(rect.y, cell * (y - 1))
    right = min(rect.x + rect.width, cell * (x + width + 1))
    bottom = min(rect.y + rect.height, cell * (y + height + 1))
    return Rect(left, top, right - left, bottom - top) if width and left < right and top < bottom else None
