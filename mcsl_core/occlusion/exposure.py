"""A camera's exposure at a moment against its usual one: what only grew lighter or darker counts as unchanged."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.alignment.aligned_views import Picture
from mcsl_core.imaging.masks import Mask, resize_mask

Float = NDArray[np.float32]
_COLUMNS = 80  # of the small pictures that gains are read off
_DARK, _BRIGHT = 16, 235  # of 255: beyond, ratios say nothing
_ALIKE = 0.06  # two ratios that are one gain
_LEAST = 0.35  # of the picture that must have one gain: hands and heads cover the rest
_MOST = 2.0  # largest gain, and its inverse the least
_UNCHANGED = 0.02


@frozen(eq=False)
class Exposure:
    """The usual picture of one camera, (h, w, 3) float, small, and where it is covered at all."""

    usual: Float
    inside: Mask

    @classmethod
    def of(cls, pictures: Sequence[Picture], inside: Mask) -> Exposure:
        """By small pictures of one camera at several moments; ``inside``: what it covers, at any size."""
        stack = np.stack(pictures)
        covered = resize_mask(inside, (stack.shape[2], stack.shape[1]))
        return cls(np.median(stack, axis=0).astype(np.float32), covered)

    def gain(self, picture: Picture) -> Float:
        """(3,): what a picture, given small, is to be multiplied with to look as usual; 1 where that is not sure."""
        now = picture.astype(np.float32)
        low, high = np.minimum(now, self.usual).min(axis=2), np.maximum(now, self.usual).max(axis=2)
        known = self.inside & (low > _DARK) & (high < _BRIGHT)
        if known.sum() < 0.1 * max(self.inside.sum(), 1):
            return np.ones(3, np.float32)
        ratio = np.log(self.usual[known] / now[known])
        tried = ratio[:: max(1, len(ratio) // 150)]
        near = np.asarray(np.all(np.abs(tried[:, None] - ratio) < _ALIKE, axis=2))
        best = near[int(np.argmax(near.sum(axis=1)))]
        gain = np.exp(np.median(ratio[best], axis=0)) if best.mean() >= _LEAST else np.ones(3)
        sure = (np.abs(np.log(gain)) < np.log(_MOST)).all() and (np.abs(gain - 1) > _UNCHANGED).any()
        return (gain if sure else np.ones(3)).astype(np.float32)


def levelled(picture: Picture, gain: Float) -> Picture:
    """A picture times a gain of each channel."""
    if (gain == 1).all():
        return picture
    return cv2.convertScaleAbs(picture.astype(np.float32) * gain)  # pyright: ignore[reportReturnType]


def small(picture: Picture) -> Picture:
    """A whole aligned picture as small as gains need it."""
    height, width = picture.shape[:2]
    size = (min(_COLUMNS, width), max(1, round(height * min(_COLUMNS, width) / width)))
    return cv2.resize(picture, size, interpolation=cv2.INTER_AREA)  # pyright: ignore[reportReturnType]
