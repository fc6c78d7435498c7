"""Which part of a camera's picture shows a head, a shoulder or an arm above the field: by geometry, never by colour.

All on cells of 4 pixels of 640, of live pictures and of the medians of every camera, laid by the relief, colours
matched.

1. **What is verified.** Where two cameras' medians show the same at the relief, both show the field there. Where others
   agree and a camera's median does not, something stands in its way all the time (a head that stays through the whole
   median): there the others' medians take the place of its own.
2. **What is changed.** Where a live picture differs from that, somebody is there: hand, instrument or head.
3. **What is above.** A camera that shows verified field, unchanged, looks through free air down to it; so do two that
   show the same there now. Where free air of other cameras covers a ray from the relief to hand height, what is seen
   along it stands higher. Where another camera shows, somewhere along the ray up to there, something changed of the
   same colour, it may be a hand, and stays.
4. **What is large.** A head is: regions of such cells that are small, narrow or hardly crossed by free air stay.
"""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.imaging.correlation import correlation, mean
from mcsl_core.imaging.planes import U8
from mcsl_core.lru_cache import kept

from .agreement import (
    CORRELATED,
    Contradicted,
    agreement,
    closed_agreement,
    codes,
    contradicted,
    levelled,
    ramp,
)
from .visual_hull import Cells, Index, Rays, taken

VERSION = 4  # rises when the same frames come out differently: conformed chunks are then made again
_SHARED = 15  # cells: gaps that are closed of what two cameras show now
_CHANGED = (8.0, 20.0)  # codes: noise, somebody
_ALIKE = (12.0, 26.0)  # codes between two cameras' live pictures: the same thing, another one
_THIN, _GAP, _BAY = 7, 5, 21  # cells: a region narrower than that is no head; gaps and bays that are closed
_LEAST = 0.025  # of the picture: a smaller region is no head; what was cut of a resting hand was 0.016
_SOLID = 0.75  # of a region that changed: 0.81 to 1 of heads, 0.67 of a hand that had moved a little
# Of a region that free air crosses for certain: so much of 67 of 74 heads on the tuning seeds, of hands nothing.
_FREE = 0.01
_SEAM = 9  # cells: gaps that are closed between the field and hands over it
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
    exact = agreement(laid)
    about = closed_agreement(exact, laid)
    against = contradicted(laid, exact, about) if len(laid) > 2 else {}
    found = {}
    for name, median in medians.items():
        back = rays[name].programme
        verified = taken(about[name], back)
        bare = taken(np.minimum(about[name], exact[name]), back)
        if name not in against:
            found[name] = Background(median, verified, bare, np.zeros_like(verified), median)
            continue
        stands, theirs = against[name]
        hidden = taken(stands, back)
        shown = median + hidden[..., None] * (taken(theirs, back) - median)
        found[name] = Background(shown.astype(np.float32), verified, bare, hidden, median)
    return found


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
        level = {name: levelled(cells, behind[name].shown) for name, cells in live.items()}
        changed = {name: ramp(codes(cells - behind[name].shown), *_CHANGED) for name, cells in level.items()}
        return cls(live, level, changed, behind, rays)

    @kept
    def changed_in_programme(self, camera: str) -> Cells:
        """(rows, columns), 0..1, by cell of the programme: `changed`, but by what the others show now.

        0 where another camera shows the same: so a camera that has come out of a head's shade is not taken for one
        under it, whatever its colours. 1 where two others agree and it shows another thing: so one whose medians show
        nothing but a head is not taken for free.
        """
        own = self.rays[camera].own
        luma = taken(self.live[camera][..., 0], own, np.nan)
        same = self._agreed()[camera] > 0.5
        for name in self.live:
            if name != camera:
                theirs = taken(self.live[name][..., 0], self.rays[name].own, np.nan)
                same |= correlation(luma, theirs)[0] > CORRELATED
        shared = cv2.morphologyEx(same.astype(np.uint8), cv2.MORPH_OPEN, _disc(_GAP))
        shared = cv2.morphologyEx(shared, cv2.MORPH_CLOSE, _disc(_SHARED))
        changed = np.where(shared > 0, 0, taken(self.changed[camera], own)).astype(np.float32)
        return np.maximum(changed, self._contradicted()[camera][0])

    def clear(self, camera: str) -> Cells:
        """(rows, columns), 0..1, by cell of the programme: whether a camera shows the field.

        It shows what another one shows as well, now or most of the time.
        """
        usually = taken(self.behind[camera].verified, self.rays[camera].own)
        return np.maximum(usually, self._agreed_about()[camera])

    @kept
    def clear_or_hands(self, camera: str) -> Cells:
        """(rows, columns), 0..1, by cell of the programme: `clear`, or whether it shows hands at work on the field.

        Another camera shows the same then, at a height of hands; heads are higher. At the relief they do not agree, and
        they may have been there in all medians.
        """
        own, found = self._laid()[camera], self.clear(camera)
        for name, heights in self.rays[camera].along.items():
            if name in self.level:
                for at in heights[1::2]:  # what lies a cell beside agrees as well
                    theirs = taken(self.level[name], at, np.nan)
                    found = np.maximum(found, agreement({camera: own, name: theirs})[camera])
        closed = np.asarray(cv2.morphologyEx(found, cv2.MORPH_CLOSE, np.ones((_SEAM, _SEAM), np.uint8)), np.float32)
        return np.where(np.isnan(own[..., 0]), 0, closed).astype(np.float32)

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
    def _laid(self) -> Mapping[str, Cells]:
        return {name: taken(cells, self.rays[name].own, np.nan) for name, cells in self.level.items()}

    @kept
    def _agreed(self) -> Mapping[str, Cells]:
        """By camera: where another one shows the same now. Heads may stand in all medians of a short pose."""
        return agreement(self._laid())

    @kept
    def _agreed_about(self) -> Mapping[str, Cells]:
        return closed_agreement(self._agreed(), self._laid())

    @kept
    def _contradicted(self) -> Contradicted:
        return contradicted(self._laid(), self._agreed(), self._agreed_about())

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
                now = taken(self._agreed()[name], self.rays[name].programme)
                found.append(taken(np.maximum((1 - near) * self.behind[name].bare, now), cells))
        return np.stack(found)

    def _stays(self, camera: str, free: Cells, where: np.ndarray) -> Cells:
        """(N,), 0..1: whether another camera shows the same thing at hand height, and no two look through it."""
        rays = self.rays[camera]
        first, second = np.zeros_like(free[0]), np.zeros_like(free[0])  # (heights, N)
        for each in free:
            first, second = np.maximum(first, each), np.maximum(second, np.minimum(first, each))
        own = taken(mean(self.level[camera], 3), rays.own[where])
        alike = np.zeros_like(second)
        for name, cells in rays.along.items():
            if name not in self.live:
                continue
            at = cells[:, where]
            apart = _nearest(own, mean(self.level[name], 3), at)
            somebody = taken(self._trusted(name), at)
            alike = np.maximum(alike, ramp(apart, *_ALIKE[::-1]) * somebody)
        return (alike * (1 - second)).max(axis=0)

    @kept
    def _trusted(self, name: str) -> Cells:
        """Who moves in a camera's picture, but for who is above for certain or stands in its way all the time."""
        behind = self.behind[name]
        stands = behind.hidden * (1 - ramp(codes(self.level[name] - behind.median), *_CHANGED))
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


def _dilated(values: Cells) -> Cells:
    return np.asarray(cv2.dilate(values, np.ones((3, 3), np.uint8)), np.float32)


def _nearest(own: Cells, cells: Cells, at: Index) -> Cells:
    """Codes by which colours (N, 3) differ from the nearest in or about cells (heights, N) of a picture."""
    wide = cv2.copyMakeBorder(cells, 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    rows, columns = cells.shape[:2]
    found = np.full(at.shape, 99.0, np.float32)
    for dy, dx in ((1, 1), (0, 1), (2, 1), (1, 0), (1, 2)):
        near = np.asarray(wide[dy : dy + rows, dx : dx + columns], np.float32)
        found = np.minimum(found, codes(taken(near, at, 999.0) - own))
    return found


def _disc(side: int) -> np.ndarray:
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
