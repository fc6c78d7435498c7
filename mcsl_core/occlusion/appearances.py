"""The ways in which the pixels of a view are seen over some samples, and how often each."""

from __future__ import annotations

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

Lab = NDArray[np.uint8]
Float = NDArray[np.float32]
APPEARANCES = 3  # of a pixel in one view that are told apart: the field, and what hides it for long


@frozen(eq=False)
class Appearance:
    """One of the ways in which the pixels of a view are seen.

    Attributes
    ----------
    lab : (h, w, 3) uint8 array
        The colour of every pixel of the cut-out.
    share : (h, w) float array
        The share of the time that the pixel is seen so, 0..1; times how likely its colour is the field's, where that
        is known.
    """

    lab: Lab
    share: Float


def appearances_of(
    pictures: Lab, candidates: int, tolerance: int, likely: NDArray[np.float32] | None = None
) -> list[Appearance]:
    """The commonest appearances of every pixel.

    Parameters
    ----------
    pictures : (T, h, w, 3) uint8 array
        What the view shows in the samples.
    candidates : int
        So many of them are tried.
    tolerance : int
        Largest difference in any channel of what counts as the same appearance.
    likely : (T, h, w) float array, optional
        How much each pixel of each picture counts by its colour.

    Returns
    -------
    list of Appearance
        `APPEARANCES` of them, the one that counts most first.
    """
    count, height, width = pictures.shape[:3]
    planes = np.ascontiguousarray(pictures.transpose(3, 0, 1, 2))
    tried = np.unique(np.linspace(0, count - 1, min(candidates, count)).astype(int))
    share = np.stack([_near(planes, planes[:, k], tolerance).mean(axis=0, dtype=np.float32) for k in tried])
    share = np.stack([cv2.blur(one, (3, 3)) for one in share])  # what hides a pixel hides its neighbours too
    if likely is not None:
        share = share * likely[tried]
    rows, columns = np.ogrid[:height, :width]
    found = []
    for _ in range(APPEARANCES):
        best = share.argmax(axis=0)
        colour = pictures[tried[best], rows, columns]
        near = _near(planes, np.ascontiguousarray(colour.transpose(2, 0, 1)), tolerance)
        total = np.stack([np.einsum("thw,thw->hw", plane, near, dtype=np.float32) for plane in planes], axis=2)
        mean = total / np.maximum(near.sum(axis=0), 1)[..., None]
        found.append(Appearance(np.rint(mean).astype(np.uint8), share[best, rows, columns]))
        # The next appearance must be another one, not this one with some noise.
        share = np.where(_apart(planes[:, tried], colour.transpose(2, 0, 1)) <= 2 * tolerance, 0, share)
    return found


def _near(planes: Lab, colour: Lab, tolerance: int) -> NDArray[np.bool_]:
    """(T, h, w): whether (3, T, h, w) and (3, h, w) count as the same appearance."""
    return _apart(planes, colour) <= tolerance


def _apart(planes: Lab, colour: Lab) -> NDArray[np.uint8]:
    """(T, h, w): the largest difference of the three channels between (3, T, h, w) and (3, h, w)."""
    return np.maximum.reduce(
        [np.maximum(plane, own) - np.minimum(plane, own) for plane, own in zip(planes, colour, strict=True)]
    )
