"""What is in the way, by agreement: background subtraction in each view, with a vote across the views.

Each camera stands still in a pose, so its own past shows the field behind hands and heads without any parallax; the
other views tell whether that past was the field at all, or a head that stayed. No colour is known beforehand.
Works on cut-outs around the field, at half the size of the aligned picture, in 8-bit Lab (all three channels 0..255).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.alignment.aligned_views import AlignedPose, AlignedView, Picture
from mcsl_core.imaging.exposure import Exposure, changed, levelled, small
from mcsl_core.imaging.masks import Mask

from .appearances import Appearance, appearances_of
from .palette import ForeignBackground, SeenView, foreign_background

Lab = NDArray[np.uint8]
Float = NDArray[np.float32]
_UNCHANGED = 0.02  # gains nearer to 1 are left: what they would mend is below `tolerance`


@frozen(eq=False)
class _Shown:
    """What the cameras show in the cut-out.

    pictures: camera -> (n, h, w, 3). alike: the same in colours like the others'. gains: see `ConsensusScorer`. inside:
    camera -> (h, w), what it covers. field: (h, w).
    """

    pictures: Mapping[str, Lab]
    alike: Mapping[str, Sequence[Lab]]
    gains: Mapping[str, Float]
    inside: Mapping[str, Mask]
    field: Mask


@frozen
class Consensus:
    """The share of the field's pixels that look as their background does.

    Attributes
    ----------
    samples : int
        So many samples, spread over those handed in, make the background.
    candidates : int
        So many of them are tried as the commonest appearance of a pixel.
    tolerance : int
        Largest difference, of 255 levels of Lab in any channel, between two appearances of one pixel in one view that
        count as the same.
    foreign : int
        The same between views, on top of what lies within ``reach``.
    reach : int
        Pixels of the cut-out: relief shifts what views show by up to 4 aligned pixels.
    different : int
        From this difference to its background on, of 255 levels, something is in the way of a pixel.
    rounds : int
        How often the background is chosen anew by what is known of the field's colours from the one before.

    Notes
    -----
    The appearances of a pixel are found as in background subtraction with several modes, only by counting how often
    each is seen; among them the one that the camera and the others see most is the background. Where hands work most
    of the time that is a hand. So it is chosen again, with every appearance counting as many times more as its colour
    is likelier the field's than of what comes and goes: mean absolute error of the scores, 12 recordings of the
    families, 0.089 without that and 0.072 after two rounds.
    """

    samples: int = field(default=60)
    candidates: int = field(default=20)
    tolerance: int = field(default=9)
    foreign: int = field(default=14)
    reach: int = field(default=2)
    different: int = field(default=13)
    rounds: int = field(default=2)
    name = "consensus"

    def scorer(self, aligned: AlignedPose, samples: Sequence[Sequence[AlignedView]]) -> ConsensusScorer:
        """Makes a scorer from the backgrounds that ``samples`` show; see `OcclusionDetector.scorer`."""
        cut = Cut.around(aligned.field)
        seen: dict[str, list[tuple[Float, Picture]]] = {}  # small, and cut out
        inside: dict[str, Mask] = {}
        for position in np.unique(np.linspace(0, len(samples) - 1, min(self.samples, len(samples))).astype(int)):
            for view in samples[position]:
                seen.setdefault(view.camera, []).append((small(view.aligned), cut.picture(view.aligned)))
                inside[view.camera] = view.inside
        exposure, pictures = {}, {}
        for name, own in seen.items():
            level = exposure[name] = Exposure.of([whole for whole, _ in own], inside[name])
            even = [_lab(levelled(part, changed(level.gain(whole), _UNCHANGED))) for whole, part in own]
            pictures[name] = np.stack(even)
        inside = {name: cut.mask(mask) for name, mask in inside.items()}
        appearances = {n: appearances_of(p, self.candidates, self.tolerance) for n, p in pictures.items()}
        gains = self._gains(appearances, inside) if appearances else {}
        alike = {n: [_recoloured(picture, gains[n]) for picture in own] for n, own in pictures.items()}
        shown = _Shown(pictures, alike, gains, inside, cut.mask(aligned.field))
        background, foreign = self._background(appearances, shown)
        for _ in range(self.rounds):
            likely = {n: np.stack([foreign.likely(picture) for picture in own]) for n, own in alike.items()}
            appearances = {
                n: appearances_of(p, self.candidates, self.tolerance, likely[n]) for n, p in pictures.items()
            }
            background, foreign = self._background(appearances, shown)
        hands = {name: cut.mask(mask) for name, mask in aligned.hands.items()}
        return ConsensusScorer(aligned.field, cut, background, exposure, self.different, gains, foreign, hands)

    def _background(
        self, appearances: Mapping[str, Sequence[Appearance]], shown: _Shown
    ) -> tuple[dict[str, Lab], ForeignBackground]:
        """Every camera's background, and where that is a hand or a head that stays."""
        background = self._agreed(appearances, shown.inside, shown.gains)
        views = {
            name: SeenView(
                _recoloured(behind, shown.gains[name]),
                shown.alike[name],
                [_solid(_differs(picture, behind, self.different)) > 0 for picture in shown.pictures[name]],
                shown.inside[name],
            )
            for name, behind in background.items()
        }
        return background, foreign_background(views, shown.field)

    def _agreed(
        self,
        appearances: Mapping[str, Sequence[Appearance]],
        inside: Mapping[str, Mask],
        gains: Mapping[str, Float],
    ) -> dict[str, Lab]:
        """camera -> (h, w, 3): of its appearances the one that it and the others see most.

        Where the others outvote all of them, theirs: a head that stays does not become its view's background.
        """
        evened = {n: [_recoloured(one.lab, gains[n]) for one in own] for n, own in appearances.items()}
        ranges = {n: [self._range(lab) for lab in own] for n, own in evened.items()}
        chosen: dict[str, Lab] = {}
        votes: dict[str, Float] = {}
        for name, own in appearances.items():
            heard = []
            for appearance, lab in zip(own, evened[name], strict=True):
                vote = appearance.share.copy()
                for other in appearances:
                    if other == name:
                        continue
                    agreeing = [
                        np.where(_within(lab, low, high) & inside[other], seen.share, 0)
                        for (low, high), seen in zip(ranges[other], appearances[other], strict=True)
                    ]
                    vote += np.max(agreeing, axis=0)
                heard.append(cv2.blur(np.where(inside[name], vote, 0).astype(np.float32), (5, 5)))
            best = np.argmax(heard, axis=0)
            chosen[name] = np.choose(best[..., None], [one.lab for one in own])
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
        low, high = self._range(common)
        disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (5, 5))
        agreed = {}
        for name, lab in chosen.items():
            alone = (votes[name] < 0.5 * best) & ~_within(_recoloured(lab, gains[name]), low, high)
            # Only whole regions: on edges of the relief the view's own past is better than what others see.
            whole = cv2.morphologyEx(alone.astype(np.uint8), cv2.MORPH_OPEN, disk) > 0
            agreed[name] = np.where(whole[..., None], _recoloured(common, np.reciprocal(gains[name])), lab)
        return agreed

    def _gains(self, appearances: Mapping[str, Sequence[Appearance]], inside: Mapping[str, Mask]) -> dict[str, Float]:
        """camera -> (3,) factors on B, G, R that make its colours those of the middle camera.

        By vote: the factor that fits the most pixels. Heads give many different ones, the field one.
        """
        bgr = {
            name: [cv2.cvtColor(one.lab, cv2.COLOR_LAB2BGR).astype(np.float32) for one in own]
            for name, own in appearances.items()
        }
        middle = np.median([own[0] for own in bgr.values()], axis=0)
        gains = {}
        for name, own in bgr.items():
            ratio = np.concatenate([((middle + 8) / (picture + 8))[inside[name]] for picture in own])
            weight = np.concatenate([one.share[inside[name]] for one in appearances[name]])
            step = max(1, len(ratio) // 3000)
            ratio, weight = ratio[::step], weight[::step]
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

    def _range(self, lab: Lab) -> tuple[Lab, Lab]:
        """Lowest and highest values within reach of every pixel, with what views may differ by."""
        around = np.ones((2 * self.reach + 1, 2 * self.reach + 1), np.uint8)
        spare = np.full_like(lab, self.foreign)
        low = cv2.subtract(cv2.erode(lab, around), spare)
        high = cv2.add(cv2.dilate(lab, around), spare)
        return low, high  # pyright: ignore[reportReturnType]


@frozen(eq=False)
class ConsensusScorer:
    """Scores the views of one scoring segment against their backgrounds.

    Attributes
    ----------
    field : (H, W) bool array
        The surgical field in aligned pixels.
    cut : Cut
        The part of the picture that is compared.
    background : mapping of str to (h, w, 3) uint8 array
        Camera -> how the field looks with nothing before it, in Lab.
    exposure : mapping of str to Exposure
        Camera -> its usual one.
    different : int
        See `Consensus`.
    gains : mapping of str to (3,) array
        Camera -> factors on B, G, R that make its colours like the others'.
    foreign : ForeignBackground
        Where a background is a hand or a head that stays.
    hands : mapping of str to (h, w) bool array
        Camera -> where a hand rests before it in the cut-out, told by its height; see `AlignedPose`.
    """

    field: Mask
    cut: Cut
    background: Mapping[str, Lab]
    exposure: Mapping[str, Exposure]
    different: int
    gains: Mapping[str, Float]
    foreign: ForeignBackground
    hands: Mapping[str, Mask]

    def score(self, views: Sequence[AlignedView]) -> Mapping[str, float]:
        """Scores the views of one frame; see `OcclusionScorer.score`."""
        field = self.cut.mask(self.field)
        area = max(int(field.sum()), 1)
        return {view.camera: float(np.count_nonzero(field & self.visible(view))) / area for view in views}

    def visible(self, view: AlignedView) -> Mask:
        """Where a view shows its background.

        Parameters
        ----------
        view : AlignedView
            Of any frame of the segment.

        Returns
        -------
        (h, w) bool array
            In the cut-out. All that the camera covers where it never had a picture in the segment: nothing is known
            to be in its way.
        """
        inside = self.cut.mask(view.inside)
        inside &= ~self.hands.get(view.camera, np.zeros_like(inside))
        if view.camera not in self.background:
            return inside
        gain = changed(self.exposure[view.camera].gain(small(view.aligned)), _UNCHANGED)
        now = _lab(levelled(self.cut.picture(view.aligned), gain))
        differs = _differs(now, self.background[view.camera], self.different)
        alike = _recoloured(now, self.gains[view.camera])
        hidden = _solid(self.foreign.hidden(view.camera, alike, differs)) > 0
        return inside & ~hidden


@frozen
class Cut:
    """The part of the aligned picture around the field, to be halved.

    Attributes
    ----------
    top, bottom : int
        Its rows [top, bottom) in aligned pixels.
    left, right : int
        Its columns [left, right).
    """

    top: int
    bottom: int
    left: int
    right: int

    @classmethod
    def around(cls, mask: Mask, margin: int = 8) -> Cut:
        """The bounding box of a mask with a margin.

        Parameters
        ----------
        mask : (H, W) bool array
            In aligned pixels.
        margin : int, optional
            Pixels on every side, as far as there are any.

        Returns
        -------
        Cut
            All of the picture where the mask is empty.
        """
        height, width = mask.shape
        rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
        if not len(rows):
            return cls(0, height, 0, width)
        return cls(
            top=max(0, int(rows[0]) - margin),
            bottom=min(height, int(rows[-1]) + margin + 1),
            left=max(0, int(columns[0]) - margin),
            right=min(width, int(columns[-1]) + margin + 1),
        )

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) of a cut-out, 1 at least."""
        return max(1, (self.right - self.left) // 2), max(1, (self.bottom - self.top) // 2)

    def picture(self, aligned: Picture) -> Picture:
        """The cut-out of a picture: (H, W, 3) in aligned pixels -> (h, w, 3)."""
        part = aligned[self.top : self.bottom, self.left : self.right]
        return cv2.resize(part, self.size, interpolation=cv2.INTER_AREA)  # pyright: ignore[reportReturnType]

    def mask(self, mask: Mask) -> Mask:
        """The cut-out of a mask: (H, W) bool in aligned pixels -> (h, w) bool, where most of a pixel is set."""
        part = mask[self.top : self.bottom, self.left : self.right].astype(np.uint8)
        return cv2.resize(part * 255, self.size, interpolation=cv2.INTER_AREA) > 127


def _differs(now: Lab, behind: Lab, different: int) -> Mask:
    """Where two pictures of a view differ, a pixel of play either way: breathing, what warping leaves of the grid."""
    around = np.ones((3, 3), np.uint8)
    over = cv2.subtract(now, cv2.dilate(behind, around)).max(axis=2)
    under = cv2.subtract(cv2.erode(behind, around), now).max(axis=2)
    return np.maximum(over, under) > different


def _solid(hidden: Mask) -> NDArray[np.uint8]:
    """Specks taken away, and holes in hands and heads filled that happen to have the colour behind them."""
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (9, 9))
    return cv2.morphologyEx(cv2.medianBlur(hidden.astype(np.uint8), 3), cv2.MORPH_CLOSE, disk)  # pyright: ignore[reportReturnType]


def _lab(picture: Picture) -> Lab:
    return cv2.cvtColor(cv2.GaussianBlur(picture, (0, 0), 0.8), cv2.COLOR_BGR2LAB)  # pyright: ignore[reportReturnType]


def _recoloured(lab: Lab, gain: Float) -> Lab:
    """``lab`` with its blue, green and red times ``gain``."""
    bgr = cv2.cvtColor(lab, cv2.COLOR_LAB2BGR) * gain
    return cv2.cvtColor(cv2.convertScaleAbs(bgr), cv2.COLOR_BGR2LAB)  # pyright: ignore[reportReturnType]


def _within(lab: Lab, low: Lab, high: Lab) -> Mask:
    return cv2.inRange(lab, low, high) > 0  # pyright: ignore[reportReturnType]
