"""What is in the way, by agreement: what differs from how a place mostly looks, in that view and in the others.

Each camera stands still in a pose, so its own past shows the field behind hands and heads without any parallax; the
other views tell whether that past was the field at all, or a head that stayed. No colour is known beforehand.
Works on cut-outs around the field, at half the scene's size, in 8-bit Lab (all three channels 0..255).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.alignment.aligned_views import AlignedPose, AlignedView, Picture
from mcsl_core.imaging.masks import Mask

Lab = NDArray[np.uint8]
Float = NDArray[np.float32]
APPEARANCES = 3  # of a pixel in one view that are told apart: the field, and what covers it for long


@frozen(eq=False)
class Appearance:
    """lab: (h, w, 3). share: (h, w), the share of the time that a pixel is seen so, 0..1."""

    lab: Lab
    share: Float


@frozen
class Consensus:
    """The share of the field's pixels that look as their background does.

    moments: so many moments, spread over those handed in, make the background. candidates: so many of them are tried as
    the commonest look of a pixel. tolerance: largest difference, of 255 levels of Lab in any channel, between two looks
    of one place in one view. foreign: that between views, on top of what lies within ``reach`` pixels (relief shifts
    places by up to 4 scene pixels). different: from here on a pixel is in the way.
    """

    moments: int = field(default=60)
    candidates: int = field(default=20)
    tolerance: int = field(default=9)
    foreign: int = field(default=14)
    reach: int = field(default=2)
    different: int = field(default=13)
    name = "consensus"

    def scorer(self, scene: AlignedPose, moments: Sequence[Sequence[AlignedView]]) -> ConsensusScorer:
        """A scorer for the stretch of a pose that ``moments`` were taken from."""
        cut = Cut.around(scene.field)
        seen: dict[str, list[Lab]] = {}
        inside: dict[str, Mask] = {}
        for position in np.unique(np.linspace(0, len(moments) - 1, min(self.moments, len(moments))).astype(int)):
            for view in moments[position]:
                seen.setdefault(view.camera, []).append(_lab(cut.picture(view.aligned)))
                inside[view.camera] = cut.mask(view.inside)
        looks = {name: self._looks(np.stack(pictures)) for name, pictures in seen.items()}
        return ConsensusScorer(scene.field, cut, self._agreed(looks, inside), self.different)

    def _looks(self, pictures: Lab) -> list[Appearance]:
        """The commonest looks of every pixel over (T, h, w, 3), and the share of the time that each is seen."""
        count, height, width = pictures.shape[:3]
        planes = np.ascontiguousarray(pictures.transpose(3, 0, 1, 2))
        tried = np.unique(np.linspace(0, count - 1, min(self.candidates, count)).astype(int))
        share = np.stack([self._near(planes, planes[:, k]).mean(axis=0, dtype=np.float32) for k in tried])
        # What covers a place covers its neighbours too.
        share = np.stack([cv2.blur(one, (3, 3)) for one in share])
        grid = np.ogrid[:height, :width]
        looks = []
        for _ in range(APPEARANCES):
            best = share.argmax(axis=0)
            look = pictures[tried[best], grid[0], grid[1]]
            near = self._near(planes, np.ascontiguousarray(look.transpose(2, 0, 1)))
            total = np.stack([np.einsum("thw,thw->hw", plane, near, dtype=np.float32) for plane in planes], axis=2)
            mean = total / np.maximum(near.sum(axis=0), 1)[..., None]
            looks.append(Appearance(np.rint(mean).astype(np.uint8), share[best, grid[0], grid[1]]))
            # The next look must be another one, not this one with some noise.
            share = np.where(_apart(planes[:, tried], look.transpose(2, 0, 1)) <= 2 * self.tolerance, 0, share)
        return looks

    def _near(self, planes: Lab, look: Lab) -> NDArray[np.bool_]:
        return _apart(planes, look) <= self.tolerance

    def _agreed(self, looks: Mapping[str, Sequence[Appearance]], inside: Mapping[str, Mask]) -> dict[str, Lab]:
        """camera -> (h, w, 3): of its looks the one that it and the others see most.

        Where the others outvote all of them, theirs: a head that stays does not become its view's background.
        """
        if not looks:
            return {}
        gains = self._gains(looks, inside)
        evened = {n: [_recoloured(look.lab, gains[n]) for look in its] for n, its in looks.items()}
        ranges = {n: [self._range(lab) for lab in its] for n, its in evened.items()}
        chosen: dict[str, Lab] = {}
        votes: dict[str, Float] = {}
        for name, its in looks.items():
            heard = []
            for look, lab in zip(its, evened[name], strict=True):
                vote = look.share.copy()
                for other in looks.keys() - {name}:
                    agreeing = [
                        np.where(_within(lab, *span) & inside[other], seen.share, 0)
                        for span, seen in zip(ranges[other], looks[other], strict=True)
                    ]
                    vote += np.max(agreeing, axis=0)
                heard.append(cv2.blur(np.where(inside[name], vote, 0).astype(np.float32), (5, 5)))
            best = np.argmax(heard, axis=0)
            chosen[name] = np.choose(best[..., None], [look.lab for look in its])
            votes[name] = np.max(heard, axis=0)
        if len(chosen) < 3:  # of two that differ nobody knows which is right: each keeps to its own past
            return chosen
        return self._outvoted(chosen, votes, gains)

    def _outvoted(
        self, chosen: Mapping[str, Lab], votes: Mapping[str, Float], gains: Mapping[str, Float]
    ) -> dict[str, Lab]:
        """``chosen``, but what most others see, in the view's own colours, where a view stands alone."""
        most = np.stack(list(votes.values()))
        winner, best = most.argmax(axis=0), most.max(axis=0)
        common = np.choose(winner[..., None], [_recoloured(chosen[name], gains[name]) for name in votes])
        span = self._range(common)
        disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (5, 5))
        agreed = {}
        for name, lab in chosen.items():
            alone = (votes[name] < 0.5 * best) & ~_within(_recoloured(lab, gains[name]), *span)
            # Only whole regions: on edges of the relief the view's own past is better than what others see.
            whole = cv2.morphologyEx(alone.astype(np.uint8), cv2.MORPH_OPEN, disk) > 0
            agreed[name] = np.where(whole[..., None], _recoloured(common, np.reciprocal(gains[name])), lab)
        return agreed

    def _gains(self, looks: Mapping[str, Sequence[Appearance]], inside: Mapping[str, Mask]) -> dict[str, Float]:
        """camera -> (3,) factors on B, G, R that make its colours those of the middle camera.

        By vote: the factor that fits the most pixels. Heads give many different ones, the field one.
        """
        bgr = {
            n: [cv2.cvtColor(look.lab, cv2.COLOR_LAB2BGR).astype(np.float32) for look in its]
            for n, its in looks.items()
        }
        middle = np.median([its[0] for its in bgr.values()], axis=0)
        gains = {}
        for name, its in bgr.items():
            ratio = np.concatenate([((middle + 8) / (picture + 8))[inside[name]] for picture in its])
            weight = np.concatenate([look.share[inside[name]] for look in looks[name]])
            ratio, weight = (part[:: max(1, len(ratio) // 3000)] for part in (ratio, weight))
            possible = (ratio > 0.7).all(axis=1) & (ratio < 1.4).all(axis=1)
            if possible.sum() < 20:
                gains[name] = np.ones(3, np.float32)
                continue
            ratio, weight = ratio[possible], weight[possible]
            tried = ratio[:: max(1, len(ratio) // 200)]
            near = np.all(np.abs(tried[:, None] - ratio) < 0.05, axis=2)
            fits = np.asarray(near)[int(np.argmax(near @ weight))]
            gains[name] = np.average(ratio[fits], axis=0, weights=weight[fits] + 1e-6).astype(np.float32)
        return gains

    def _range(self, look: Lab) -> tuple[Lab, Lab]:
        """Lowest and highest values within reach of every pixel, with what views may differ by."""
        around = np.ones((2 * self.reach + 1, 2 * self.reach + 1), np.uint8)
        spare = np.full_like(look, self.foreign)
        low = cv2.subtract(cv2.erode(look, around), spare)
        high = cv2.add(cv2.dilate(look, around), spare)
        return low, high  # pyright: ignore[reportReturnType]


@frozen(eq=False)
class ConsensusScorer:
    """Scores moments of one stretch of a pose. background: camera -> how the field looks with nothing before it."""

    field: Mask
    cut: Cut
    background: Mapping[str, Lab]
    different: int

    def score(self, views: Sequence[AlignedView]) -> Mapping[str, float]:
        """camera -> visible share of the field, 0..1."""
        place = self.cut.mask(self.field)
        area = max(int(place.sum()), 1)
        return {view.camera: float(np.count_nonzero(place & self.visible(view))) / area for view in views}

    def visible(self, view: AlignedView) -> Mask:
        """(h, w) bool in the cut-out: where the view shows the background."""
        inside = self.cut.mask(view.inside)
        if view.camera not in self.background:  # never seen in this stretch: nothing is known to be in the way
            return inside
        now = _lab(self.cut.picture(view.aligned))
        behind = self.background[view.camera]
        # A pixel of play either way: breathing, and what warping leaves of the pixel grid.
        around = np.ones((3, 3), np.uint8)
        over = cv2.subtract(now, cv2.dilate(behind, around)).max(axis=2)
        under = cv2.subtract(cv2.erode(behind, around), now).max(axis=2)
        hidden = (np.maximum(over, under) > self.different).astype(np.uint8)
        return inside & (_solid(hidden) == 0)


def _solid(hidden: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Specks taken away, and holes in hands and heads filled that happen to have the colour behind them."""
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (9, 9))
    return cv2.morphologyEx(cv2.medianBlur(hidden, 3), cv2.MORPH_CLOSE, disk)  # pyright: ignore[reportReturnType]


@frozen
class Cut:
    """The part of the scene around the field, halved: rows [top, bottom) and columns [left, right) of scene pixels."""

    top: int
    bottom: int
    left: int
    right: int

    @classmethod
    def around(cls, mask: Mask, margin: int = 8) -> Cut:
        """Around a mask (H, W); all of it where the mask is empty."""
        rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
        if not len(rows):
            return cls(0, mask.shape[0], 0, mask.shape[1])
        (top, bottom), (left, right) = (
            (max(0, int(at[0]) - margin), min(size, int(at[-1]) + margin + 1))
            for at, size in ((rows, mask.shape[0]), (columns, mask.shape[1]))
        )
        return cls(top, bottom, left, right)

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) of a cut-out."""
        return max(1, (self.right - self.left) // 2), max(1, (self.bottom - self.top) // 2)

    def picture(self, scene_picture: Picture) -> Picture:
        part = scene_picture[self.top : self.bottom, self.left : self.right]
        return cv2.resize(part, self.size, interpolation=cv2.INTER_AREA)  # pyright: ignore[reportReturnType]

    def mask(self, scene_mask: Mask) -> Mask:
        part = scene_mask[self.top : self.bottom, self.left : self.right].astype(np.uint8)
        return cv2.resize(part * 255, self.size, interpolation=cv2.INTER_AREA) > 127


def _lab(picture: Picture) -> Lab:
    return cv2.cvtColor(cv2.GaussianBlur(picture, (0, 0), 0.8), cv2.COLOR_BGR2LAB)  # pyright: ignore[reportReturnType]


def _recoloured(lab: Lab, gain: Float) -> Lab:
    """``lab`` with its blue, green and red times ``gain``."""
    bgr = cv2.cvtColor(lab, cv2.COLOR_LAB2BGR) * gain
    return cv2.cvtColor(cv2.convertScaleAbs(bgr), cv2.COLOR_BGR2LAB)  # pyright: ignore[reportReturnType]


def _apart(planes: Lab, look: Lab) -> NDArray[np.uint8]:
    """(T, h, w): the largest difference of the three channels between (3, T, h, w) and (3, h, w)."""
    return np.maximum.reduce(
        [np.maximum(plane, its) - np.minimum(plane, its) for plane, its in zip(planes, look, strict=True)]
    )


def _within(look: Lab, low: Lab, high: Lab) -> Mask:
    return cv2.inRange(look, low, high) > 0  # pyright: ignore[reportReturnType]
