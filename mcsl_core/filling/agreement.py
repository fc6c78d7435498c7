"""Where two cameras show the same at the relief: both then look through free air down to it.

On cells of the programme before centering, into which the cameras' pictures are laid by the relief, colours matched.
"""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.imaging.correlation import correlation, mean

from .visual_hull import Cells

_CHROMA = 1.5  # weight of a code of chroma against one of luma
_SAME = (8.0, 16.0)  # codes between two cameras' pictures: the same, no longer surely
_ALSO = (0.4, 0.7)  # correlation of what is the same by its codes
_ANOTHER = (14.0, 24.0)  # codes: hardly the same any more, another thing; towards the edges a picture is darker
CORRELATED = 0.8  # luma that goes up and down alike
_AROUND = 7  # cells: of what agrees together
_AGREED = (0.45, 0.7)  # share of them that must be the same: nothing agrees, all
_FINER = (1.2, 1.6)  # times as much detail: as fine, finer
_GAPS = 25  # cells: what agrees all about such a gap is the field with a hand over it
_BLACK = 16  # of luma
_MOST_GAIN, _BINS = 0.4, 40  # of exposure, natural logarithm; votes for it are counted in such bins
_ALL_BUT = 0.3  # of a picture that must share the gain: heads cover the rest

Contradicted = dict[str, tuple[Cells, Cells]]


def agreement(laid: Mapping[str, Cells]) -> dict[str, Cells]:
    """How surely each camera shows what another one shows as well, here and near by.

    Parameters
    ----------
    laid : mapping of str to (rows, columns, 3) float32
        By camera its picture in codes, NaN where it has none.

    Returns
    -------
    dict of str to (rows, columns) float32
        0..1; 0 where nothing tells, as on smooth drapes.
    """
    names = list(laid)
    found = {name: np.zeros(cells.shape[:2], np.float32) for name, cells in laid.items()}
    inside = {name: (~np.isnan(cells[..., 0])).astype(np.float32) for name, cells in laid.items()}
    for i, a in enumerate(names):
        for b in names[:i]:
            both = inside[a] * inside[b]
            alike = ramp(codes_apart(laid[a], laid[b]), *_SAME[::-1])
            like, told = correlation(laid[a][..., 0], laid[b][..., 0])
            told = np.asarray(told * both, np.float32)
            same = np.asarray(alike * told * ramp(like, *_ALSO), np.float32)
            known = mean(told, _AROUND)
            share = np.asarray(both * mean(same, _AROUND) / np.maximum(known, 0.02), np.float32)
            share = np.asarray(ramp(share, *_AGREED) * ramp(known, 0.03, 0.1), np.float32)
            found[a], found[b] = np.maximum(found[a], share), np.maximum(found[b], share)
    return found


def closed_agreement(agreed: Mapping[str, Cells], laid: Mapping[str, Cells]) -> dict[str, Cells]:
    """An agreement with its gaps closed: smooth drape, and hands that work on the field.

    Parameters
    ----------
    agreed
        `agreement` of ``laid``.
    laid
        See there.

    Returns
    -------
    dict of str to (rows, columns) float32
        0..1; less where a camera that contradicts shows more detail: then it may be the only one to see.
    """
    side = np.ones((_GAPS, _GAPS), np.uint8)
    closed = {n: np.asarray(cv2.morphologyEx(v, cv2.MORPH_CLOSE, side), np.float32) for n, v in agreed.items()}
    detail = {name: _detail(cells[..., 0]) for name, cells in laid.items()}
    found = {}
    for name, own in closed.items():
        doubt = np.zeros_like(own)
        for other in closed:
            if other != name:
                more = ramp(np.asarray(detail[other] / (detail[name] + 0.1), np.float32), *_FINER)
                doubt = np.maximum(doubt, more * (1 - closed[other]))
        found[name] = np.asarray(own * (1 - doubt), np.float32)
    return found


def contradicted(laid: Mapping[str, Cells], agreed: Mapping[str, Cells], closed: Mapping[str, Cells]) -> Contradicted:
    """Where a camera shows another thing than two others that agree: what stands in its way.

    Parameters
    ----------
    laid, agreed
        See `closed_agreement`.
    closed
        What that gave.

    Returns
    -------
    dict of str to ((rows, columns) float32, (rows, columns, 3) float32)
        By camera: 0..1, and what the others show.
    """
    found = {}
    for name in laid:
        others = [other for other in laid if other != name]
        weights = np.stack([(agreed[o] + 0.3 * closed[o]) ** 2 for o in others]) + 1e-6
        theirs = (np.nan_to_num(np.stack([laid[o] for o in others])) * weights[..., None]).sum(0)
        theirs = np.asarray(theirs / weights.sum(0)[..., None], np.float32)
        two = np.sort(np.stack([closed[o] for o in others]), axis=0)[-2]
        alike = correlation(laid[name][..., 0], theirs[..., 0])[0] > CORRELATED
        another = ramp(codes_apart(levelled(laid[name], theirs, alike), theirs), *_ANOTHER)
        inside = ~np.isnan(laid[name][..., 0])
        found[name] = ramp(inside * two * (1 - closed[name]) * another, 0.2, 0.8), theirs
    return found


def _detail(luma: Cells) -> Cells:
    """Codes of fine structure, in the surroundings; heads are before the focus."""
    inside = (~np.isnan(luma)).astype(np.float32)
    luma = np.nan_to_num(luma)
    fine = np.asarray(np.abs(luma - mean(luma, 3)) * _eroded(inside), np.float32)
    return np.asarray(inside * mean(fine, _GAPS) / np.maximum(mean(_eroded(inside), _GAPS), 0.1), np.float32)


def codes_apart(a: Cells, b: Cells) -> Cells:
    """(rows, columns): codes by which two pictures differ in the mean of 3 x 3 cells, laid right to a cell."""
    found = np.full(a.shape[:2], np.inf, np.float32)
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            apart = np.nan_to_num(codes(a - np.roll(b, (dy, dx), (0, 1))), nan=99.0)
            found = np.minimum(found, mean(apart, 3))
    return found


def levelled(cells: Cells, shown: Cells, where: NDArray[np.bool_] | None = None) -> Cells:
    """A picture at the exposure of another: by the one gain that most cells share, where they share one.

    Parameters
    ----------
    cells, shown : (rows, columns, 3) float32
        What is levelled, and to what.
    where : (rows, columns) bool array, optional
        The cells that are asked; all without.

    Returns
    -------
    (rows, columns, 3) float32
        ``cells`` itself without such a gain.
    """
    light, usual = cells[..., 0] - _BLACK, shown[..., 0] - _BLACK
    known = (np.minimum(light, usual) > 12) & (np.maximum(light, usual) < 210)
    if where is not None:
        known &= where
    logs = np.log(usual[known] / light[known])
    votes, edges = np.histogram(logs, _BINS, (-_MOST_GAIN, _MOST_GAIN))
    near = np.convolve(votes, np.ones(5), "same")
    best = int(near.argmax())
    if near[best] <= _ALL_BUT * known.sum():  # none at all of a black picture
        return cells
    middle = (edges[best] + edges[best + 1]) / 2
    gain = np.exp(np.median(logs[np.abs(logs - middle) < 5 * (edges[1] - edges[0]) / 2]))
    dark = np.array([_BLACK, 128, 128], np.float32)
    return np.asarray((cells - dark) * np.float32(gain) + dark, np.float32)


def codes(difference: Cells) -> Cells:
    """(rows, columns): the largest of the (rows, columns, 3) differences of Y', Cb and Cr, chroma weighing more."""
    y, u, v = (np.abs(difference[..., k]) for k in range(3))  # a third of the time of a maximum over the last axis
    return np.maximum(y, np.float32(_CHROMA) * np.maximum(u, v))


def ramp(values: Cells, zero: float, one: float) -> Cells:
    """0 up to ``zero``, 1 from ``one``, straight between them; falling where ``one`` is less."""
    return np.clip((values - zero) / (one - zero), 0, 1).astype(np.float32)


def _eroded(values: Cells) -> Cells:
    return np.asarray(cv2.erode(values, np.ones((3, 3), np.uint8)), np.float32)
