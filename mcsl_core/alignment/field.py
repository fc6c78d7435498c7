"""Where the surgical field lies in a pose: what all cameras show there most of the time has its hue.

Masks are (H, W) bool in scene pixels.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from mcsl_core.imaging.masks import Mask, close_gaps, hue_mask, main_region

from .aligned_views import AlignedPose, Picture


def field_from_hue(pictures: Sequence[Picture]) -> Mask:
    """(h, w) bool: where most of a still camera's pictures have the field's hue, its main region only."""
    votes = np.mean([hue_mask(p) > 0 for p in pictures], axis=0)
    return main_region(votes > 0.5)


_BINS = 8  # a side of the colour cube


def typical_picture(scene: AlignedPose, moments: Iterable[Mapping[str, Picture | None]]) -> Picture:
    """(H, W, 3) BGR: the commonest colour at every scene pixel, over all moments and cameras, coarsely.

    A head or a hand hides a place from some cameras at some moments and never looks quite the same; what lies behind it
    does. (The mean of many moments instead gave gloves that work in one place for field.)
    """
    width, height = scene.size
    counts = np.zeros((height * width, _BINS**3), np.uint16)
    pixels = np.arange(height * width)
    for pictures in moments:
        for view in scene.views(pictures):
            lab = cv2.cvtColor(cv2.GaussianBlur(view.aligned, (0, 0), 0.7), cv2.COLOR_BGR2LAB).reshape(-1, 3)
            inside = view.inside.ravel()
            bins = _bins(lab.astype(np.int32))
            counts[pixels[inside], bins[inside]] += 1  # each pixel once a view
    cube = counts.reshape(height, width, _BINS, _BINS, _BINS).astype(np.float32)
    for axis in (2, 3, 4):  # a colour on the border of two bins must not lose to one in the middle of its own
        cube = uniform_filter1d(cube, 2, axis=axis, mode="constant")
    lab = _colours(cube.reshape(height * width, -1).argmax(axis=1)).reshape(height, width, 3)
    return cv2.cvtColor(lab, cv2.COLOR_LAB2BGR)  # pyright: ignore[reportReturnType]


def _bins(lab: NDArray[np.int32]) -> NDArray[np.int32]:
    """Lightness in steps of 32, a and b in steps of 16 about grey."""
    light, a, b = lab[:, 0] // 32, (lab[:, 1] - 64) // 16, (lab[:, 2] - 64) // 16
    top = _BINS - 1
    return (light * _BINS + np.clip(a, 0, top)) * _BINS + np.clip(b, 0, top)


def _colours(bins: NDArray[np.int64]) -> NDArray[np.uint8]:
    """The corner between a bin and the one before it in each direction, which is the middle of the smoothed bin."""
    light, a, b = bins // _BINS**2 * 32, bins // _BINS % _BINS * 16 + 64, bins % _BINS * 16 + 64
    return np.stack([light, a, b], axis=1).astype(np.uint8)


def field_by_hue(picture: Picture) -> Mask:
    """The field in a `typical_picture`: its hue's main region, with what lies in it filled in."""
    return close_gaps(main_region(hue_mask(picture) > 0))
