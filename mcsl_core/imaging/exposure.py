"""A camera's exposure and white balance at different moments, compared by what has only grown lighter or darker.

Between two pictures of a camera that stands still: one gain of each channel, found by vote. What neither picture hides
has one gain, however it is lit; heads and hands that have moved give many different ones. From many such pairs follows
what brings every picture to one level.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array, eye_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from .masks import Mask, resize_mask
from .planes import U8

Float = NDArray[np.float32]
Logs = NDArray[np.float64]  # natural logarithms of gains of blue, green and red
_COLUMNS = 80  # of the small pictures that gains are read off
_DARK, _BRIGHT = 16, 235  # of 255: beyond, ratios say nothing
_ALIKE = 0.06  # two ratios that are one gain, natural logarithms
_LEAST = 0.35  # of the picture that must have one gain: hands and heads cover the rest
# Enough where all channels have it alike, as of exposure: a head, hands and glare left 0.31 to 0.35 of a field in view.
_LEAST_GREY = 0.2
_KNOWN = 0.1  # of what counts that must be neither dark nor blown out
_MOST = np.log(2.0)  # largest gain, and its inverse the least
_TRIED, _VOTERS = 60, 500
_APART = (1, 2, 3, 5, 8, 13, 21)  # pictures that are compared: what is near in time has more in common
_WRONG = 0.01  # a pair that is further off what the others say counts less than half
_ROUNDS = 8


@frozen(eq=False)
class Exposure:
    """The usual picture of one camera.

    Attributes
    ----------
    usual : (h, w, 3) float array
        As `small` makes it.
    inside : (h, w) bool array
        Where it counts.
    """

    usual: Float
    inside: Mask

    @classmethod
    def of(cls, pictures: Sequence[Float], inside: Mask) -> Exposure:
        """The usual one among several moments: the median of pictures brought to one level.

        Parameters
        ----------
        pictures : sequence of (h, w, 3) float array
            Of one camera in order of time, as `small` makes them.
        inside : (H, W) bool array
            What counts, of any size.
        """
        covered = resize_mask(inside, pictures[0].shape[1::-1])
        gains = common_gains(pictures, covered)
        level = [picture if gain is None else picture * gain for picture, gain in zip(pictures, gains, strict=True)]
        return cls(np.median(level, axis=0).astype(np.float32), covered)

    def gain(self, picture: Float) -> Float | None:
        """What a picture is to be multiplied with to look as usual; see `gain_between`.

        Where heads and hands cover much, a gain that is alike in all channels is believed by less of the picture.
        """
        log = gain_between(picture, self.usual, self.inside)
        if log is None:
            grey = gain_between(picture, self.usual, self.inside, _LEAST_GREY)
            log = grey if grey is not None and np.ptp(grey) < _ALIKE else None
        return None if log is None else np.exp(log).astype(np.float32)


def gain_between(picture: Float, other: Float, inside: Mask, share: float = _LEAST) -> Logs | None:
    """What one picture is to be multiplied with to look as another.

    Parameters
    ----------
    picture, other : (h, w, 3) array
        Of one camera, as `small` makes them.
    inside : (h, w) bool array
        What counts.
    share : float, optional
        So much of what counts must have the gain.

    Returns
    -------
    (3,) float array or None
        Natural logarithms for blue, green and red, of gains of 0.5 to 2; None where it is not sure.
    """
    low, high = _channels(np.minimum, picture, other), _channels(np.maximum, picture, other)
    known = inside & (low > _DARK) & (high < _BRIGHT)
    if known.sum() < max(_KNOWN * inside.sum(), 1):
        return None
    ratio = np.log(other[known] / picture[known])
    voters, tried = (ratio[:: max(1, len(ratio) // count)] for count in (_VOTERS, _TRIED))
    near = _all_near(tried[:, None], voters)
    middle = tried[int(np.argmax(near.sum(axis=1)))]
    best = np.zeros(len(ratio), bool)
    for _ in range(2):  # the pixel tried was one of many, and has noise
        best = _all_near(ratio, middle)
        if not best.any():
            return None
        middle = np.median(ratio[best], axis=0)
    return None if best.mean() < share or (np.abs(middle) >= _MOST).any() else middle.astype(np.float64)


def _channels(least: np.ufunc, picture: Float, other: Float) -> Float:
    """The least (or greatest) of all channels of both; numpy is slow over a last axis of three."""
    both = least(picture, other)
    return least(least(both[..., 0], both[..., 1]), both[..., 2])


def _all_near(a: Float, b: Float) -> Mask:
    """Whether two ratios are one gain in every channel."""
    near = [np.abs(a[..., k] - b[..., k]) < _ALIKE for k in range(3)]
    return near[0] & near[1] & near[2]


def common_gains(pictures: Sequence[Float], inside: Mask) -> list[Float | None]:
    """What brings each picture of a camera to one exposure, the middle of all.

    Parameters
    ----------
    pictures : sequence of (h, w, 3) float array
        In order of time, as `small` makes them.
    inside : (h, w) bool array
        What counts.

    Returns
    -------
    list of (3,) float array or None
        Of blue, green and red; None for a picture that has too little in common with the others.
    """
    pairs, ratios = [], []
    for apart in _APART:
        for i in range(len(pictures) - apart):
            log = gain_between(pictures[i], pictures[i + apart], inside)
            if log is not None:
                pairs.append((i, i + apart))
                ratios.append(log)
    if not pairs:
        return [None] * len(pictures)
    logs, group = levels(len(pictures), np.array(pairs), np.array(ratios))
    known = group == np.bincount(group).argmax()
    logs = logs - np.median(logs[known], axis=0)
    return [np.exp(log).astype(np.float32) if sure else None for log, sure in zip(logs, known, strict=True)]


def levels(
    count: int, pairs: NDArray[np.int64], ratios: Logs, weights: NDArray[np.float64] | None = None
) -> tuple[Logs, NDArray[np.int32]]:
    """The level of every picture from what pairs of them say; pairs that contradict the others count little.

    Parameters
    ----------
    count : int
        How many pictures there are.
    pairs : (E, 2) int array
        Which pictures were compared.
    ratios : (E, 3) float array
        What `gain_between` says of the first of each pair against the second.
    weights : (E,) float array, optional
        How much each pair counts; alike without.

    Returns
    -------
    levels : (count, 3) float array
        Natural logarithms: what brings picture i to the level of picture j is levels[i] - levels[j].
    group : (count,) int array
        Pictures of one group hang together by pairs; between groups levels say nothing.
    """
    rows = np.arange(len(pairs))
    ends = (np.r_[np.ones(len(pairs)), -np.ones(len(pairs))], (np.r_[rows, rows], np.r_[pairs[:, 0], pairs[:, 1]]))
    difference = csr_array(coo_array(ends, shape=(len(pairs), count)))
    own = np.ones(len(pairs)) if weights is None else weights
    weight = own
    found = np.zeros((count, 3))
    for _ in range(_ROUNDS):
        weighted = difference.T.multiply(weight)
        found = splu((weighted @ difference + 1e-9 * eye_array(count)).tocsc()).solve(weighted @ ratios)
        off = np.abs(difference @ found - ratios).max(axis=1)
        weight = own / (1 + (off / _WRONG) ** 2)
    _, group = connected_components(difference.T @ difference, directed=False)
    return found, group


def changed(gain: Float | None, least: float) -> Float | None:
    """The gain, where it is known and any channel of it is further than ``least`` from 1."""
    return None if gain is None or (np.abs(gain - 1) <= least).all() else gain


def levelled(picture: U8, gain: Float | None) -> U8:
    """A picture times a gain of each channel; as it is without one."""
    if gain is None:
        return picture
    return cv2.convertScaleAbs(picture.astype(np.float32) * gain)  # pyright: ignore[reportReturnType]


def small(picture: U8) -> Float:
    """A whole picture as small as gains need it; in fractions of codes, or small changes would be rounded away."""
    height, width = picture.shape[:2]
    size = (min(_COLUMNS, width), max(1, round(height * min(_COLUMNS, width) / width)))
    return cv2.resize(picture.astype(np.float32), size, interpolation=cv2.INTER_AREA)  # pyright: ignore[reportReturnType]
