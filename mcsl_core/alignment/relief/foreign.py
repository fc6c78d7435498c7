"""Foreign colours: where a steady picture has those of what comes and goes before it, gloves and sleeves.

A hand that rests all through a pose is as steady as the patient; its colours tell it apart.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
import scipy
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.imaging.exposure import gain_between, levelled, small
from mcsl_core.imaging.geometry import size_at_columns
from mcsl_core.imaging.masks import Mask, resize_mask

from ..aligned_views import Picture
from ..steady import SteadyView

_COLUMNS = 240  # of the pictures that are counted
_SAMPLES = 12  # of a camera
_SHAPE = (16, 32, 32)  # bins of L, a and b, smoothed by one: shading moves lightness, noise all three
_PASSES = 16  # grey levels of 255 that a sample is off the steady picture where something passes
# How probable it is that a colour comes and goes rather than belongs to the scene, from which it is surely or likely
# foreign. Tan gloves on a tan limb have 0.5, the limb and its drapes 0.2 to 0.3; a table beside it 0.7, but lies flat.
_SURE, _LIKELY = 0.6, 0.45
_MOST = 0.5  # of the field: where more would be foreign colours tell nothing, as of bare hands
_ROUNDS = 2  # of counting: in the second, what the first found foreign no longer counts as the scene's


@frozen(eq=False)
class ForeignColours:
    """Where a steady picture has the colours of what comes and goes, and is steady.

    Attributes
    ----------
    sure : (h, w) bool array
        Of the picture's size.
    likely : (h, w) bool array
        The same by less: enough for what stands above its surroundings as well.
    """

    sure: Mask
    likely: Mask


def foreign_colours(
    samples: Sequence[Mapping[str, Picture | None]],
    steady: Mapping[str, SteadyView],
    fields: Mapping[str, Mask],
) -> dict[str, ForeignColours]:
    """Where the steady pictures show what else comes and goes.

    Parameters
    ----------
    samples : sequence of mapping of str to (h, w, 3) uint8 array or None
        Moments of a pose: camera -> its picture.
    steady : mapping of str to SteadyView
        What each camera shows steadily over them.
    fields : mapping of str to (h, w) bool array
        Camera -> where it sees the surgical field, about; of any size. Its colours are the scene's.

    Returns
    -------
    dict of str to ForeignColours
        Camera -> where; nowhere where colours do not tell.
    """
    seen = {name: _Seen.of(view, [s.get(name) for s in samples], fields[name]) for name, view in steady.items()}
    nowhere = {name: np.zeros(own.bins.shape, bool) for name, own in seen.items()}
    surely = likely = nowhere
    for _ in range(_ROUNDS):
        whole, field, coming = (np.zeros(int(np.prod(_SHAPE))) for _ in range(3))
        for name, own in seen.items():
            whole += _counted(own.bins[own.steady & ~surely[name]])
            field += _counted(own.bins[own.field & ~surely[name]])
            coming += own.coming + _counted(own.bins[surely[name]])
        of_scene = np.maximum(_share(whole), _share(field))
        by_colour = (_share(coming) / (_share(coming) + of_scene + 1e-6)).astype(np.float32)
        probable = {name: np.asarray(cv2.blur(by_colour[own.bins], (5, 5)), np.float32) for name, own in seen.items()}
        surely, likely = ({name: own > least for name, own in probable.items()} for least in (_SURE, _LIKELY))
        if _most_of_field(surely, seen):
            surely = likely = nowhere
            break
    if _most_of_field(likely, seen):
        likely = surely
    found = {}
    for name, view in steady.items():
        size = view.steady.shape[::-1]
        rim = cv2.dilate(surely[name].astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
        found[name] = ForeignColours(*(resize_mask(mask, size) & view.steady for mask in (rim, likely[name])))
    return found


@frozen(eq=False)
class _Seen:
    """One camera's. bins: (h, w), of the steady picture. steady, field: (h, w). coming: of what passes, by bin."""

    bins: NDArray[np.int32]
    steady: Mask
    field: Mask
    coming: NDArray[np.float64]

    @classmethod
    def of(cls, view: SteadyView, samples: Sequence[Picture | None], field: Mask) -> _Seen:
        size = size_at_columns(view.picture.shape[1::-1], _COLUMNS)
        picture = _reduced(view.picture, size)
        grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
        usual = small(view.picture)
        shown = [sample for sample in samples if sample is not None]
        coming = np.zeros(int(np.prod(_SHAPE)))
        for sample in shown[:: max(1, len(shown) // _SAMPLES)]:
            small_sample = _reduced(sample, size)
            log = gain_between(small(sample), usual, np.ones(usual.shape[:2], bool))
            now = levelled(small_sample, None if log is None else np.exp(log).astype(np.float32))
            passes = cv2.absdiff(cv2.cvtColor(now, cv2.COLOR_BGR2GRAY), grey) > _PASSES
            coming += _counted(_bins(now)[passes])
        return cls(_bins(picture), resize_mask(view.steady, size), resize_mask(field, size), coming)


def _most_of_field(places: Mapping[str, Mask], seen: Mapping[str, _Seen]) -> bool:
    inside = sum(int(own.field.sum()) for own in seen.values())
    return sum(int((places[name] & own.field).sum()) for name, own in seen.items()) > _MOST * max(inside, 1)


def _reduced(picture: Picture, size: tuple[int, int]) -> Picture:
    return cv2.resize(picture, size, interpolation=cv2.INTER_AREA)  # pyright: ignore[reportReturnType]


def _bins(picture: Picture) -> NDArray[np.int32]:
    """(h, w): the bin of every colour."""
    lab = cv2.cvtColor(picture, cv2.COLOR_BGR2LAB)
    light, a, b = (lab[..., channel].astype(np.int32) * bins // 256 for channel, bins in enumerate(_SHAPE))
    return (light * _SHAPE[1] + a) * _SHAPE[2] + b


def _counted(bins: NDArray[np.int32]) -> NDArray[np.float64]:
    return np.bincount(bins.ravel(), minlength=int(np.prod(_SHAPE))).astype(np.float64)


def _share(counted: NDArray[np.float64]) -> NDArray[np.float64]:
    smooth = scipy.ndimage.gaussian_filter(counted.reshape(_SHAPE), 1.0, mode="nearest").ravel()
    return smooth / max(float(smooth.sum()), 1e-9)
