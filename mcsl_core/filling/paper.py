"""The paper's filler ("Filling Missing Region"), as its text and its figure say."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.imaging.planes import U8, Planes
from mcsl_core.imaging.rect import Rect

from .protocol import FillContext

# "pixel values above 10" of 255 are luma 26 and more in limited range: 25 is 10.48, which is 10 in 8 bits.
_DARK = 25
_KERNEL = (49, 49)
_AGE_KERNEL = (9, 9)  # the paper gives no figure


class PaperFiller:
    """The paper's: pixels above 10, blurred by a Gaussian of 49 pixels, are the alpha over the reference camera.

    What then is missing comes from the frame before, blurred, so that it is the more blurred the older it is.

    Notes
    -----
    It works in Y'CbCr, where the formulas are the same: blending is linear. Its name is "reference".

    References
    ----------
    The paper's section "Filling Missing Region".
    """

    name = "reference"
    version = 2
    remembers = True

    def fill(self, context: FillContext) -> Planes:
        """Fill one programme frame; see `Filler`."""
        reference = context.others[0] if context.others else None
        behind = context.picture(reference, Rect(0, 0, *context.size)) if reference is not None else None
        out = context.front
        if behind is not None:
            alpha = np.asarray(cv2.GaussianBlur(_bright(out), _KERNEL, 0), np.uint8)
            half = (alpha.shape[1] // 2, alpha.shape[0] // 2)
            small = np.asarray(cv2.resize(alpha, half, interpolation=cv2.INTER_AREA), np.uint8)
            out = Planes(*(_over(*p) for p in zip(out, behind, (alpha, small, small), strict=True)))
        if context.previous is None:
            return out
        hole = np.asarray(cv2.bitwise_not(_bright(out)), np.uint8)
        if not hole.any():
            return out
        holes = (hole, hole[::2, ::2], hole[::2, ::2])
        return Planes(*(_filled_from_before(*p) for p in zip(out, context.previous, holes, strict=True)))


def _bright(planes: Planes) -> U8:
    return cv2.threshold(planes.y, _DARK, 255, cv2.THRESH_BINARY)[1]  # pyright: ignore[reportReturnType]


def _over(front: U8, behind: U8, alpha: U8) -> U8:
    weight: NDArray[np.float32] = alpha.astype(np.float32) / np.float32(255)
    return cv2.blendLinear(front, behind, weight, 1 - weight)  # pyright: ignore[reportReturnType]


def _filled_from_before(plane: U8, before: U8, hole: U8) -> U8:
    """``plane`` with blurred pixels of the frame before in ``hole``; only its surroundings are blurred."""
    x, y, width, height = cv2.boundingRect(np.ascontiguousarray(hole))
    part = (slice(max(0, y - 8), y + height + 8), slice(max(0, x - 8), x + width + 8))
    out = plane.copy()
    cv2.copyTo(cv2.GaussianBlur(before[part], _AGE_KERNEL, 0), hole[part], out[part])
    return out
