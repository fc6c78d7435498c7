"""What is in the way has colours of its own: those that come and go before the field, and are not the field's.

A hand or a head that stays becomes its view's background. It is of the same gloves, sleeves and caps as what comes and
goes beside it, so its colours tell it from the patient.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
import scipy
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.imaging.masks import Mask

Lab = NDArray[np.uint8]
Float = NDArray[np.float32]
_SHAPE = (16, 32, 32)  # bins of L, a and b, smoothed by one: shading moves lightness, noise all three
_FOREIGN = 0.6  # odds from which a background is foreign; with 0.4 a third of a real limb was
_HIDES = 0.4  # odds from which what is seen before a foreign background hides the field
_MOST = 0.5  # of the field: where more seems foreign its colours tell nothing, as of bare hands
_LIKELIER = 10.0  # more is not believed; with 5 hands that work at one place were still chosen as the field
_PASSES = 2  # what was found foreign is no part of the field's colours, and is of what comes and goes


@frozen(eq=False)
class SeenView:
    """What one camera shows about the field over some samples; colours are 8-bit Lab, like the other cameras'.

    Attributes
    ----------
    background : (h, w, 3) uint8 array
        What stands for the field.
    pictures : sequence of (h, w, 3) uint8 array
        The samples.
    hidden : sequence of (h, w) bool array
        Where each of them differs from the background.
    inside : (h, w) bool array
        What the camera covers.
    """

    background: Lab
    pictures: Sequence[Lab]
    hidden: Sequence[Mask]
    inside: Mask


@frozen(eq=False)
class ForeignBackground:
    """Where a background is not the field, and by which colours what is before it is judged.

    Attributes
    ----------
    odds : (N,) float array
        For each bin of colours 0 (the field's) to 1 (of what comes and goes).
    places : mapping of str to (h, w) bool array
        Camera -> where its background is foreign.
    """

    odds: Float
    places: Mapping[str, Mask]

    def likely(self, lab: Lab) -> Float:
        """(h, w): how many times likelier a colour is the field's than of what comes and goes, a tenth to ten times."""
        times = (1 - self.odds) / (self.odds + 1e-3)
        return cv2.blur(np.clip(times, 1 / _LIKELIER, _LIKELIER)[_bins(lab)], (3, 3))  # pyright: ignore[reportReturnType]

    def hidden(self, camera: str, now: Lab, changed: Mask) -> Mask:
        """Where a picture does not show the field: where it has changed, and by its colours before what is foreign."""
        return np.where(self.places[camera], cv2.blur(self.odds[_bins(now)], (3, 3)) > _HIDES, changed)


def foreign_background(views: Mapping[str, SeenView], field: Mask) -> ForeignBackground:
    """Finds what of the backgrounds is a hand or a head that stays.

    Parameters
    ----------
    views : mapping of str to SeenView
        Every camera's.
    field : (h, w) bool array
        The surgical field.

    Returns
    -------
    ForeignBackground
        With no place at all where the colours of what comes and goes are those of half the field.

    Notes
    -----
    Mean absolute error of the scores with the true field and alignment, before and after: near-black skin 0.126 and
    0.071, a narrow field 0.082 and 0.036, a limb 0.102 and 0.059, hands that rest 0.197 and 0.147, bare hands 0.040 and
    0.036. Hands that cover a third of the field for the whole time keep their share in its colours.
    """
    backgrounds = {name: _bins(view.background) for name, view in views.items()}
    pictures = {name: [_bins(picture) for picture in view.pictures] for name, view in views.items()}
    nowhere = {name: np.zeros(field.shape, bool) for name in views}
    places, odds = nowhere, np.zeros(int(np.prod(_SHAPE)), np.float32)
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (5, 5))
    for _ in range(_PASSES):
        own, coming = np.zeros(odds.size), np.zeros(odds.size)
        for name, view in views.items():
            own += _share(_counted(backgrounds[name], field & view.inside & ~places[name]))
            for picture, hidden in zip(pictures[name], view.hidden, strict=True):
                coming += _counted(picture, (hidden ^ places[name]) & view.inside)
        own, coming = own / max(len(views), 1), _share(coming)
        odds = (coming / (coming + own + 1e-6)).astype(np.float32)
        likely = {name: cv2.blur(odds[bins], (5, 5)) > _FOREIGN for name, bins in backgrounds.items()}
        places = {n: cv2.morphologyEx(m.astype(np.uint8), cv2.MORPH_OPEN, disk) > 0 for n, m in likely.items()}
        share = np.mean([(place & field).sum() for place in places.values()] or [0]) / max(field.sum(), 1)
        if share > _MOST:
            return ForeignBackground(odds, nowhere)
    return ForeignBackground(odds, places)


def _bins(lab: Lab) -> NDArray[np.int32]:
    """(h, w): the bin of every colour."""
    light, a, b = (lab[..., channel].astype(np.int32) * bins // 256 for channel, bins in enumerate(_SHAPE))
    return (light * _SHAPE[1] + a) * _SHAPE[2] + b


def _counted(bins: NDArray[np.int32], where: Mask) -> NDArray[np.int64]:
    return np.bincount(bins[where], minlength=int(np.prod(_SHAPE)))


def _share(counted: NDArray) -> NDArray[np.float64]:
    smooth = scipy.ndimage.gaussian_filter(counted.reshape(_SHAPE).astype(np.float64), 1.0, mode="nearest").ravel()
    return smooth / max(float(smooth.sum()), 1e-9)
