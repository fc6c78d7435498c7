"""Which part of a camera's picture shows a head, a shoulder or an arm above the field: by geometry, never by colour.

All on cells of 4 pixels of 640, of live pictures and of the medians of every camera, laid by the relief, colours
matched.

1. **What is verified.** Where two cameras' medians show the same at the relief, both show the field there. Where others
   agree and a camera's median does not, something stands in its way all the time (a head that stays through the whole
   median): there the others' medians take the place of its own.
2. **What is changed.** Where a live picture differs from that, somebody is there: hand, instrument or head.
3. **What is above.** A camera that shows verified field, unchanged, looks through free air down to it. Where free air
   of other cameras covers a ray from the relief to hand height, what is seen along it stands higher. Where another
   camera shows, somewhere along the ray up to there, something changed of the same colour, it may be a hand, and stays.
4. **What is large.** A head is: regions of such cells that are small, narrow or hardly crossed by free air stay.
"""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.imaging.planes import U8
from mcsl_core.lru_cache import kept

from .visual_hull import Cells, Index, Rays, taken

VERSION = 1  # rises when the same frames come out differently: conformed chunks are then made again
_CHROMA = 1.5  # weight of a code of chroma against one of luma
_SAME = (8.0, 16.0)  # codes between two cameras' medians: the same, no longer surely
_ANOTHER = (14.0, 24.0)  # codes: hardly the same any more, another thing; towards the edges a picture is darker
_ALSO = (0.4, 0.7)  # correlation of what is the same by its codes
_CORRELATED, _WINDOW, _FLAT = 0.8, 9, 3.0  # luma that goes up and down alike, over so many cells; codes
_SHARED = 15  # cells: gaps that are closed of what two cameras show now
_AROUND = 7  # cells: of what is verified together
_VERIFIED = (0.45, 0.7)  # share of them that must be the same: nothing verified, all
_FINER = (1.2, 1.6)  # times as much detail: as fine, finer
_GAPS = 25  # cells: what is verified all about such a gap is the field with a hand over it
_CHANGED = (8.0, 20.0)  # codes: noise, somebody
_BLACK = 16  # of luma
_MOST_GAIN, _BINS = 0.4, 40  # of exposure, natural logarithm; votes for it are counted in such bins
_ALL_BUT = 0.3  # of a picture that must share the gain: heads cover the rest
_ALIKE = (12.0, 26.0)  # codes between two cameras' live pictures: the same thing, another one
_THIN, _GAP, _BAY = 7, 5, 21  # cells: a region narrower than that is no head; gaps and bays that are closed
_LEAST = 0.025  # of the picture: a smaller region is no head; what was cut of a resting hand was 0.016
_SOLID = 0.75  # of a region that changed: 0.81 to 1 of heads, 0.67 of a hand that had moved a little
_FREE = 0.15  # of a region that free air crosses for certain
_RIM = 5  # cells: a head's blurred outline lies within two of what is found of it


@frozen(eq=False)
class Background:
    """What a camera shows where nobody is in its way, in cells of its own picture.

    Attributes
    ----------
    shown : (rows, columns, 3) float32
        Codes, matched to the reference camera's.
    verified : (rows, columns) float32
        0..1: another camera shows the same, here or all about.
    bare : (rows, columns) float32
        0..1: here. A hand that rests in all medians is all about the field, and no camera looks through it.
    hidden : (rows, columns) float32
        0..1: where its own median shows something in its way.
    median : (rows, columns, 3) float32
        Its own.
    """

    shown: Cells
    verified: Cells
    bare: Cells
    hidden: Cells
    median: Cells


def backgrounds(medians: Mapping[str, Cells], rays: Mapping[str, Rays]) -> dict[str, Background]:
    """The backgrounds of all cameras at one time.

    Parameters
    ----------
    medians
        (rows, columns, 3) of each camera's own picture, colours matched.
    rays
        Of each of these cameras.
    """
    laid = {name: taken(cells, rays[name].own, np.nan) for name, cells in medians.items()}
    exact = _verified(laid)
    side = np.ones((_GAPS, _GAPS), np.uint8)
    closed = {n: np.asarray(cv2.morphologyEx(v, cv2.MORPH_CLOSE, side), np.float32) for n, v in exact.items()}
    about = _undoubted(closed, {name: _detail(cells[..., 0]) for name, cells in laid.items()})
    found = {}
    for name, median in medians.items():
        others = [other for other in medians if other != name]
        back = rays[name].programme
        verified = taken(about[name], back)
        bare = taken(np.minimum(about[name], exact[name]), back)
        if len(others) < 2:
            found[name] = Background(median, verified, bare, np.zeros_like(verified), median)
            continue
        weights = np.stack([(exact[o] + 0.3 * about[o]) ** 2 for o in others]) + 1e-6
        theirs = (np.nan_to_num(np.stack([laid[o] for o in others])) * weights[..., None]).sum(0)
        theirs /= weights.sum(0)[..., None]
        agreed = np.sort(np.stack([about[o] for o in others]), axis=0)[-2]  # two of them at least
        another = _ramp(_apart(laid[name], theirs), *_ANOTHER)
        hidden = taken(_ramp(agreed * (1 - about[name]) * another, 0.2, 0.8), back)
        shown = median + hidden[..., None] * (taken(theirs.astype(np.float32), back) - median)
        found[name] = Background(shown.astype(np.float32), verified, bare, hidden, median)
    return found


def _undoubted(verified: Mapping[str, Cells], detail: Mapping[str, Cells]) -> dict[str, Cells]:
    """What is verified, but where a camera that contradicts shows more detail: then it may be the only one to see."""
    found = {}
    for name, own in verified.items():
        doubt = np.zeros_like(own)
        for other in verified:
            if other != name:
                more = _ramp(np.asarray(detail[other] / (detail[name] + 0.1), np.float32), *_FINER)
                doubt = np.maximum(doubt, more * (1 - verified[other]))
        found[name] = np.asarray(own * (1 - doubt), np.float32)
    return found


def _detail(luma: Cells) -> Cells:
    """Codes of fine structure, in the surroundings; heads are before the focus."""
    inside = (~np.isnan(luma)).astype(np.float32)
    luma = np.nan_to_num(luma)
    fine = np.asarray(np.abs(luma - _mean(luma, 3)) * _eroded(inside), np.float32)
    return np.asarray(inside * _mean(fine, _GAPS) / np.maximum(_mean(_eroded(inside), _GAPS), 0.1), np.float32)


def _verified(laid: Mapping[str, Cells]) -> dict[str, Cells]:
    """By camera and cell of the programme, 0..1: whether another camera's median shows the same, near by as well."""
    names = list(laid)
    found = {name: np.zeros(cells.shape[:2], np.float32) for name, cells in laid.items()}
    inside = {name: (~np.isnan(cells[..., 0])).astype(np.float32) for name, cells in laid.items()}
    for i, a in enumerate(names):
        for b in names[:i]:
            both = inside[a] * inside[b]
            alike = _ramp(_apart(laid[a], laid[b]), *_SAME[::-1])
            correlation, told = _correlation(laid[a][..., 0], laid[b][..., 0])
            told = np.asarray(told * both, np.float32)
            same = np.asarray(alike * told * _ramp(correlation, *_ALSO), np.float32)
            known = _mean(told, _AROUND)
            share = np.asarray(both * _mean(same, _AROUND) / np.maximum(known, 0.02), np.float32)
            share = np.asarray(_ramp(share, *_VERIFIED) * _ramp(known, 0.03, 0.1), np.float32)
            found[a], found[b] = np.maximum(found[a], share), np.maximum(found[b], share)
    return found


def _apart(a: Cells, b: Cells) -> Cells:
    """Codes by which two pictures differ in the mean of 3 x 3 cells, laid over each other to a cell."""
    found = np.full(a.shape[:2], np.inf, np.float32)
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            codes = np.nan_to_num(_codes(a - np.roll(b, (dy, dx), (0, 1))), nan=99.0)
            found = np.minimum(found, _mean(codes, 3))
    return found


def _correlation(a: Cells, b: Cells) -> tuple[Cells, Cells]:
    """-1..1: the local correlation of two luma pictures, whatever their exposure; and where either is not flat, 0 or 1.

    Two caps of one colour, before two cameras, are alike anywhere, but their folds go up and down each in its own way.
    """
    inside = (~(np.isnan(a) | np.isnan(b))).astype(np.float32)
    share = np.maximum(_mean(inside, _WINDOW), 1e-3)
    a, b = (np.asarray(_mean(np.nan_to_num(each), 3) * inside, np.float32) for each in (a, b))
    mean_a, mean_b = _mean(a, _WINDOW) / share, _mean(b, _WINDOW) / share
    var_a = np.maximum(_mean(a * a, _WINDOW) / share - mean_a**2, 0)
    var_b = np.maximum(_mean(b * b, _WINDOW) / share - mean_b**2, 0)
    both = _mean(a * b, _WINDOW) / share - mean_a * mean_b
    seen = share > 0.5
    sure = seen & (var_a * var_b > _FLAT**4)
    found = np.where(sure, both / np.sqrt(np.maximum(var_a * var_b, 1e-6)), 0)
    return found.astype(np.float32), (seen & (np.maximum(var_a, var_b) > _FLAT**2)).astype(np.float32)


def _levelled(cells: Cells, shown: Cells) -> Cells:
    """A live picture at the exposure of its background: by one gain that most cells share, where they share one."""
    light, usual = cells[..., 0] - _BLACK, shown[..., 0] - _BLACK
    known = (np.minimum(light, usual) > 12) & (np.maximum(light, usual) < 210)
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


@frozen(eq=False, slots=False)
class Moment:
    """All that is known of one frame, in cells of each camera's own picture.

    Attributes
    ----------
    live : mapping of str to (rows, columns, 3) float32
        What each camera shows, colours matched.
    level : mapping of str to (rows, columns, 3) float32
        The same at the exposure of its background.
    changed : mapping of str to (rows, columns) float32
        0..1: whether somebody is there.
    behind, rays
        Of every camera.
    """

    live: Mapping[str, Cells]
    level: Mapping[str, Cells]
    changed: Mapping[str, Cells]
    behind: Mapping[str, Background]
    rays: Mapping[str, Rays]

    @classmethod
    def of(cls, live: Mapping[str, Cells], behind: Mapping[str, Background], rays: Mapping[str, Rays]) -> Moment:
        """What the cameras show, against what they show where nobody is."""
        level = {name: _levelled(cells, behind[name].shown) for name, cells in live.items()}
        changed = {name: _ramp(_codes(cells - behind[name].shown), *_CHANGED) for name, cells in level.items()}
        return cls(live, level, changed, behind, rays)

    @kept
    def changed_in_programme(self, camera: str) -> Cells:
        """(rows, columns), 0..1, by cell of the programme; 0 where another camera shows the same now, at the relief.

        So a camera that has come out of a head's shade is not taken for one under it, whatever its colours.
        """
        own = self.rays[camera].own
        luma = taken(self.live[camera][..., 0], own, np.nan)
        same = np.zeros(own.shape, np.float32)
        for name in self.live:
            if name != camera:
                theirs = taken(self.live[name][..., 0], self.rays[name].own, np.nan)
                same = np.maximum(same, _correlation(luma, theirs)[0])
        shared = cv2.morphologyEx((same > _CORRELATED).astype(np.uint8), cv2.MORPH_OPEN, _disc(_GAP))
        shared = cv2.morphologyEx(shared, cv2.MORPH_CLOSE, _disc(_SHARED))
        return np.where(shared > 0, 0, taken(self.changed[camera], own)).astype(np.float32)

    def above(self, camera: str) -> Cells:
        """Where a camera shows something that stands higher than hands.

        Parameters
        ----------
        camera
            One of those with a picture.

        Returns
        -------
        (rows, columns) float32
            By cell of the programme before centering: 1 there, else 0.
        """
        changed = self.changed_in_programme(camera)
        if changed.mean() < _LEAST:
            return np.zeros_like(changed)
        free, through = self._free(camera), self._through(camera)
        if through.mean() < _FREE * _LEAST:
            return np.zeros_like(changed)
        maybe = (changed > 0.5) & (through < 0.5)
        stays = np.zeros_like(changed)
        stays[maybe] = self._stays(camera, free[:, :, maybe], maybe)
        high = (changed * (1 - stays) > 0.5).astype(np.uint8)
        high = cv2.morphologyEx(high, cv2.MORPH_CLOSE, _disc(_GAP))
        found = _regions(np.asarray(cv2.morphologyEx(high, cv2.MORPH_OPEN, _disc(_THIN)), np.uint8), changed, through)
        if not found.any():
            return found.astype(np.float32)
        # What a head leaves open between its parts is its own, but for what may be a hand that comes and goes.
        hidden = taken(self.behind[camera].hidden, self.rays[camera].own)
        found |= _closed(found) & ((changed < 0.5) | (hidden > 0.5) | (stays < 0.5))
        found = _grown(found, (changed > 0.5) & (hidden > 0.5))
        return np.asarray(cv2.dilate(_filled(found), _disc(_RIM)), np.float32)

    @kept
    def _through(self, camera: str) -> Cells:
        """0..1 by cell of the programme: whether free air covers the ray on which the camera sees somebody."""
        return np.asarray(self.changed_in_programme(camera) * self._free(camera).max(axis=0).min(axis=0), np.float32)

    @kept
    def _free(self, camera: str) -> Cells:
        """(others, heights, rows, columns), 0..1: whether each other camera looks through free air there."""
        found = []
        for name, cells in self.rays[camera].along.items():
            if name in self.changed:
                near = np.asarray(cv2.dilate(self.changed[name], np.ones((3, 3), np.uint8)), np.float32)
                found.append(taken((1 - near) * self.behind[name].bare, cells))
        return np.stack(found)

    def _stays(self, camera: str, free: Cells, where: np.ndarray) -> Cells:
        """(N,), 0..1: whether another camera shows the same thing at hand height, and no two look through it."""
        rays = self.rays[camera]
        first, second = np.zeros_like(free[0]), np.zeros_like(free[0])  # (heights, N)
        for each in free:
            first, second = np.maximum(first, each), np.maximum(second, np.minimum(first, each))
        own = taken(_mean(self.level[camera], 3), rays.own[where])
        alike = np.zeros_like(second)
        for name, cells in rays.along.items():
            if name not in self.live:
                continue
            at = cells[:, where]
            apart = _nearest(own, _mean(self.level[name], 3), at)
            somebody = taken(self._trusted(name), at)
            alike = np.maximum(alike, _ramp(apart, *_ALIKE[::-1]) * somebody)
        return (alike * (1 - second)).max(axis=0)

    @kept
    def _trusted(self, name: str) -> Cells:
        """Who moves in a camera's picture, but for who is above for certain or stands in its way all the time."""
        behind = self.behind[name]
        stands = behind.hidden * (1 - _ramp(_codes(self.level[name] - behind.median), *_CHANGED))
        certain = _closed((self._through(name) > 0.5).astype(np.uint8)).astype(np.float32)
        stands = np.maximum(stands, taken(certain, self.rays[name].programme))
        return _dilated(np.asarray(self.changed[name] * (1 - stands), np.float32))


def _regions(high: U8, changed: Cells, through: Cells) -> U8:
    """The regions that are large, changed nearly all over, and crossed by free air."""
    count, labels = cv2.connectedComponents(high)
    found = np.zeros(high.shape, np.uint8)
    for label in range(1, count):
        region = labels == label
        solid = changed[region].mean() >= _SOLID and through[region].mean() >= _FREE
        if region.mean() >= _LEAST and solid:
            found[region] = 1
    return found


def _closed(mask: U8) -> U8:
    """With its bays closed, those at the picture's edge as well."""
    wide = cv2.copyMakeBorder(mask, _BAY, _BAY, _BAY, _BAY, cv2.BORDER_REPLICATE)
    return np.asarray(cv2.morphologyEx(wide, cv2.MORPH_CLOSE, _disc(_BAY)), np.uint8)[_BAY:-_BAY, _BAY:-_BAY]


def _grown(mask: U8, into: NDArray[np.bool_]) -> U8:
    """With what hangs together with it there."""
    where, cross = (into | (mask > 0)).astype(np.uint8), np.ones((3, 3), np.uint8)
    for _ in range(_BAY):
        mask = np.asarray(cv2.dilate(mask, cross), np.uint8) & where
    return mask


def _filled(mask: U8) -> U8:
    """Without holes."""
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    return np.asarray(cv2.drawContours(np.zeros_like(mask), outlines, -1, 1, cv2.FILLED), np.uint8)


def _codes(difference: Cells) -> Cells:
    """The largest of the channels' differences."""
    y, u, v = (np.abs(difference[..., k]) for k in range(3))  # a third of the time of a maximum over the last axis
    return np.maximum(y, np.float32(_CHROMA) * np.maximum(u, v))


def _ramp(values: Cells, zero: float, one: float) -> Cells:
    return np.clip((values - zero) / (one - zero), 0, 1).astype(np.float32)


def _mean(values: Cells, side: int) -> Cells:
    return np.asarray(cv2.blur(values, (side, side), borderType=cv2.BORDER_REPLICATE), np.float32)


def _eroded(values: Cells) -> Cells:
    return np.asarray(cv2.erode(values, np.ones((3, 3), np.uint8)), np.float32)


def _dilated(values: Cells) -> Cells:
    return np.asarray(cv2.dilate(values, np.ones((3, 3), np.uint8)), np.float32)


def _nearest(own: Cells, cells: Cells, at: Index) -> Cells:
    """Codes by which colours (N, 3) differ from the nearest in or about cells (heights, N) of a picture."""
    wide = cv2.copyMakeBorder(cells, 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    rows, columns = cells.shape[:2]
    found = np.full(at.shape, 99.0, np.float32)
    for dy, dx in ((1, 1), (0, 1), (2, 1), (1, 0), (1, 2)):
        near = np.asarray(wide[dy : dy + rows, dx : dx + columns], np.float32)
        found = np.minimum(found, _codes(taken(near, at, 999.0) - own))
    return found


def _disc(side: int) -> np.ndarray:
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
