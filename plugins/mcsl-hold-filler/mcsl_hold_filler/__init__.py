"""A filler that holds: where the chosen camera sees nothing, the last picture of that place stays, unblurred.

One camera's picture and its own past, nobody else's: what the viewer sees beside the chosen context is always something
that he saw there before, never what is behind it now. What nobody ever showed is black.
"""

from __future__ import annotations

import cv2
import numpy as np

from mcsl_core.hooks import U8, FillContext, Planes, hookimpl

# Of the footprint's border, in chroma samples: there the warp has mixed the picture with black.
_BORDER = np.ones((3, 3), np.uint8)


class HoldFiller:
    """Holds the last pixels seen at each place of the programme.

    Along a hard edge: a soft one would be blended into the memory anew with every frame, and creep. The memory is what
    `FillContext.previous` is, so it begins anew every ten seconds from ever earlier frames: a frame comes out the same
    in whatever stretch it is made, and a shot that fell between those frames is not remembered beyond ten seconds.
    """

    name = "hold"
    version = 1
    remembers = True

    def fill(self, context: FillContext) -> Planes:
        """The frame before, and over it what the chosen camera shows now."""
        if context.previous is None:
            return context.front
        mask = cv2.erode(context.footprint(context.camera), _BORDER, borderType=cv2.BORDER_REPLICATE)
        if mask.all():
            return context.front
        full = cv2.resize(mask, None, fx=2, fy=2, interpolation=cv2.INTER_NEAREST)
        return Planes(*(_over(*p) for p in zip(context.previous, context.front, (full, mask, mask), strict=True)))


def _over(before: U8, now: U8, mask: np.ndarray) -> U8:
    return cv2.copyTo(now, mask, before.copy())  # pyright: ignore[reportReturnType]


@hookimpl
def register_fillers():
    return [HoldFiller()]
