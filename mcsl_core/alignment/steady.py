"""What stays: a camera's commonest picture over some samples, and where that is steady in time.

The patient and the drapes lie still while the lamp stands; hands tremble even where they rest, heads come and go, glare
wanders. Pictures are a camera's own, reduced.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.imaging.exposure import common_gains, levelled, small
from mcsl_core.imaging.masks import Mask

from .aligned_views import Picture

# Grey levels of 255, exposure levelled.
_NEAR = 4  # two samples show the same
_SAME = 16  # a sample shows the commonest thing, in whatever light
_STEADY = 3.0  # noise and breathing; and of the slope of an edge, which shakes by a fraction of a pixel ...
_SLOPE = 0.3
_LEAST = 3  # samples that a place is seen in; with fewer in all nothing can be said
_OFTEN = 0.2  # of the samples
_TIGHT = 0.6  # of the samples that show the same thing are steady where it is the patient
_AROUND = 25  # pixels around a place, most of which are steady where it is: half of a head's are by chance
_MOST_AROUND = 0.7


@frozen(eq=False)
class SteadyView:
    """What one camera shows steadily over some samples.

    Attributes
    ----------
    picture : (h, w, 3) uint8 array
        The commonest, BGR, each sample brought to one exposure.
    steady : (h, w) bool array
        Where what is commonest keeps its grey while it is seen.
    """

    picture: Picture
    steady: Mask


def steady_view(pictures: Sequence[Picture | None]) -> SteadyView | None:
    """The steady view of a camera.

    Parameters
    ----------
    pictures : sequence of (h, w, 3) uint8 array or None
        Of samples in which it stands still, in order of time.

    Returns
    -------
    SteadyView or None
        None where there is no picture. Of fewer than three the last stands, all of it taken for steady.

    Notes
    -----
    The commonest grey and not the median: a head may hide a place from a camera more than half of the time. Exposure is
    levelled by one gain a channel and sample.
    """
    shown = [picture for picture in pictures if picture is not None]
    if not shown:
        return None
    if len(shown) < _LEAST:
        return SteadyView(shown[-1], np.ones(shown[-1].shape[:2], bool))
    few = [small(picture) for picture in shown]
    gains = common_gains(few, np.ones(few[0].shape[:2], bool))
    level = [levelled(picture, gain) for picture, gain in zip(shown, gains, strict=True)]
    greys = [_grey(picture) for picture in level]
    commonest = _commonest(greys)
    off = np.stack([cv2.absdiff(grey, commonest) for grey in greys])
    alike = off <= _SAME
    same = alike.sum(axis=0)
    total = np.zeros(shown[0].shape, np.float32)
    for one, like in zip(level, alike, strict=True):
        total += one * like[..., None]
    slope = cv2.magnitude(*(cv2.Sobel(commonest, cv2.CV_32F, *way, scale=0.125) for way in ((1, 0), (0, 1))))
    close = (off <= _STEADY + _SLOPE * cv2.blur(slope, (5, 5))).sum(axis=0)
    steady = _mean(close, 5) > _TIGHT * _mean(same, 5)
    steady &= same >= max(_LEAST, _OFTEN * len(shown))
    return SteadyView((total / same[..., None]).astype(np.uint8), steady & (_mean(steady, _AROUND) > _MOST_AROUND))


def _commonest(greys: Sequence[NDArray[np.uint8]]) -> NDArray[np.uint8]:
    """(h, w): at every pixel that sample's grey which most others are near to."""
    votes = np.zeros((len(greys), *greys[0].shape), np.uint8)
    for i, one in enumerate(greys):
        for j in range(i):
            near = (cv2.absdiff(one, greys[j]) <= _NEAR).view(np.uint8)
            votes[i] += near
            votes[j] += near
    return np.take_along_axis(np.stack(greys), votes.argmax(axis=0)[None], axis=0)[0]


def _mean(values: NDArray, box: int) -> NDArray[np.float32]:
    return cv2.blur(values.astype(np.float32), (box, box))  # pyright: ignore[reportReturnType]


def _grey(picture: Picture) -> NDArray[np.uint8]:
    return cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)  # pyright: ignore[reportReturnType]
