"""Where the surgical field lies, by several voices: what all cameras aim at, the colours that are there and not beside
it or farther out, what comes and goes above it, and that drapes leave a convex opening. Where they do not agree nothing
is claimed.

Pictures and masks are in aligned pixels, small ones (240 columns): (H, W, 3) Lab as OpenCV scales it, and (H, W).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
import scipy
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.imaging.convex import convex_region
from mcsl_core.imaging.masks import Mask, close_gaps, convex_hull, hue_mask, main_region
from mcsl_core.parallel import by_threads

from .aligned_views import AlignedPose, AlignedView, Picture
from .field import aim_of, modal_picture

Float = NDArray[np.float32]
_FAR = 0.5  # of the highest aim: the colours below are not the field's
_AIMED = 0.67  # of the highest aim: what lies below is not the field; simulated ones hold a hundredth of it there
_MIDDLE, _BY_AIM = 0.75, 0.4  # of the highest aim: what lies above is rather the field, by that much log odds
_SEEDS = (0.97, 0.9)  # of the highest aim: the colours above it are the field's at first; a narrow field ends there
_ROUNDS = 5  # of colours and region, each by the other; more changed nothing
_SETTLED = 0.985  # overlap of a region with that of the round before
_BESIDE = 16.0  # how much a pixel beside the field counts against one far out: lamps light the drapes there alike
_ROOM = 0.35  # of the field's size: how far what is beside it reaches
_CERTAIN = 3.0  # log odds of a colour at most
_OFF = (32, 16)  # levels of lightness and of colour between a passer-by and what is usually seen there
_A_HAND, _LEAST_SAID = 0.55, 0.2  # the share of passers-by from which on a colour is a hand's; what it still says
_LARGEST = 0.35  # of the picture: drapes that are taken for the field
_EDGE = 10  # levels of Lab between the two sides of an outline that is one
_SURE = 0.4  # least agreement at which a field is claimed by its hue
# Below this agreement colours hardly part the field from what is beside it, and its hue alone is heard: right fields of
# tuning scenes have 0.73 to 0.91, a photograph's pale skin over drapes in shade 0.64 and 0.67, drapes alone 0.67.
_CLEAR = 0.7
# What begins in the narrow middle may end at the wound's rim (under bare hands it had 0.80, the field 0.77), what
# begins in the wide one beyond a narrow field: 0.58 to 0.73 on five scenes.
_WHOLE = 0.74
# Below, the larger of two is the field if a pixel that it has more tells such a share of what one of the smaller does
# (see `_told`): 0.33 to 0.98 of a field about its wound or incision, 0.15 at most of drapes about a narrow field.
_TELLING = 0.22
_BUMP, _BAY = 0.2, 0.5  # of the size of a field by hue: what of its outline is a strap's end, or a hand's bite
_BINS = 26  # a side of the colour cube


@frozen(eq=False)
class FoundField:
    """A field, and how well the voices agree on it, 0..1; empty where none is claimed."""

    mask: Mask
    agreement: float


@frozen(eq=False)
class Evidence:
    """What the voices judge by.

    Attributes
    ----------
    picture : (H, W, 3) uint8 array
        What is usually seen, coarsely: BGR.
    lab : (H, W, 3) float array
        The same, finely.
    aim : (H, W) float array
        What all cameras aim at; see `aim_of`.
    hands : (_BINS**3,) float array
        Of every colour, how much of it comes and goes, 0..1; see `_bins`.
    """

    picture: Picture
    lab: Float
    aim: Float
    hands: NDArray[np.float64]
    bins: NDArray[np.int64] = field(init=False)
    said: Float = field(init=False)
    """How much every pixel's colour says, 0..1: little where it is a hand's, which rests there or has worked there."""

    def __attrs_post_init__(self) -> None:
        bins = _bins(cv2.GaussianBlur(self.lab, (0, 0), 0.7))
        said = np.clip((_A_HAND - self.hands[bins]) / 0.2, _LEAST_SAID, 1).astype(np.float32)
        object.__setattr__(self, "bins", bins)
        object.__setattr__(self, "said", said)

    @property
    def share(self) -> Float:
        """The aim over its highest."""
        return self.aim / max(float(self.aim.max()), 1e-6)


def gather(aligned: AlignedPose, samples: Sequence[Mapping[str, Picture | None]]) -> Evidence:
    """What is usually seen, and of every colour how much of it passes by.

    Parameters
    ----------
    aligned : AlignedPose
        How the cameras lie.
    samples : sequence of mapping of str to (h, w, 3) uint8 array or None
        Per sample, camera -> its picture, BGR.

    Returns
    -------
    Evidence
        A glove that rests somewhere all the time has the colour of those that work.
    """
    picture = modal_picture(aligned, samples)
    usual = cv2.cvtColor(picture, cv2.COLOR_BGR2LAB).astype(np.int16)
    total, count = np.zeros(usual.shape, np.float32), np.zeros(usual.shape[:2], np.float32)
    passing, staying = np.zeros(_BINS**3), np.zeros(_BINS**3)

    def told(view: AlignedView) -> tuple[NDArray, NDArray, NDArray, Mask]:
        lab = cv2.cvtColor(cv2.GaussianBlur(view.aligned, (0, 0), 0.7), cv2.COLOR_BGR2LAB).astype(np.int16)
        apart = np.abs(lab - usual)
        light, colour = apart[..., 0], apart[..., 1:].max(axis=2)
        off = (light > _OFF[0]) | (colour > _OFF[1])
        near = view.inside & (light <= 0.75 * _OFF[0]) & (colour <= 0.75 * _OFF[1])
        bins = _bins(lab)
        passes, stays = (
            np.bincount(bins[where], minlength=_BINS**3) for where in (view.inside & off, view.inside & ~off)
        )
        return passes, stays, lab, near

    for pictures in samples[:: max(1, len(samples) // 20)]:
        for passes, stays, lab, near in by_threads(told, aligned.views(pictures)):
            passing += passes
            staying += stays
            total += lab * near[..., None]
            count += near
    mean = np.where(count[..., None] > 0, total / np.maximum(count, 1)[..., None], usual).astype(np.float32)
    passing, staying = _smooth(passing, 1.5), _smooth(staying, 1.5)
    return Evidence(picture, mean, aim_of(aligned).astype(np.float32), passing / (passing + staying + 1e-9))


def find_field(
    aligned: AlignedPose, samples: Sequence[Mapping[str, Picture | None]], before: Mask | None = None
) -> Mask:
    """Where the surgical field lies in a pose.

    Parameters
    ----------
    aligned : AlignedPose
        How the cameras lie, of some 240 columns; its own field is not used.
    samples : sequence of mapping of str to (h, w, 3) uint8 array or None
        Per sample, camera -> its picture, BGR.
    before : (H, W) bool array, optional
        What was found by how the cameras lay before; it stays where it tells more of the colours that are seen now.

    Returns
    -------
    (H, W) bool array
        Convex, unless the hue alone shows it; empty where the voices do not agree on one.
    """
    evidence = gather(aligned, samples)
    found = field_by_voices(evidence).mask
    if before is None or not before.any() or not found.any():
        return found
    return _more_telling(before, found, evidence)


def field_by_voices(evidence: Evidence) -> FoundField:
    """The field that most speaks for; empty where too little does."""
    narrow, wide = (_judged(_region(evidence, seed), evidence) for seed in _SEEDS)
    best = max(narrow, wide, key=lambda found: found.agreement)
    if min(narrow.agreement, wide.agreement) > 0:  # else one is nothing, or more than a field can be
        best = wide
        if wide.agreement < _WHOLE:
            best = _judged(_more_telling(narrow.mask, wide.mask, evidence), evidence)
    if best.agreement >= _CLEAR:
        return best
    hue = _judged(_by_hue(evidence), evidence)
    if hue.agreement < _SURE:
        return FoundField(np.zeros_like(best.mask), hue.agreement)
    return _judged(_more_telling(best.mask, hue.mask, evidence), evidence) if best.agreement else hue


def _more_telling(one: Mask, other: Mask, evidence: Evidence) -> Mask:
    """Of two masks the larger, if what it has more is told by its colours as well."""
    small, large = sorted((one, other), key=np.count_nonzero)
    told, more = _told(small, evidence), large.sum() / max(small.sum(), 1) - 1
    return large if _told(large, evidence) - told >= _TELLING * more * told else small


def _told(mask: Mask, evidence: Evidence) -> float:
    """How much the colours about the aim tell of a mask: the mutual information of both, in nats, times pixels."""
    weight = evidence.said * (evidence.share > _FAR)
    inside, outside = (
        _smooth(np.bincount(evidence.bins.ravel(), (weight * side).ravel(), _BINS**3), 1.0, 0.5)
        for side in (mask, ~mask)
    )
    both = inside + outside
    parts = ((side, both * side.sum() / max(both.sum(), 1e-9)) for side in (inside, outside))
    return float(sum(scipy.special.rel_entr(side, expected).sum() for side, expected in parts))


def _by_hue(evidence: Evidence) -> Mask:
    """The region of the field's hue that most of the aim lies in, without bumps, its gaps and bays filled."""
    aim = evidence.share
    hue = hue_mask(evidence.picture) > 0
    count, labels = cv2.connectedComponents(main_region(hue, least=0.002).astype(np.uint8))
    weight = np.bincount(labels.ravel(), np.clip(aim - 0.7, 0, 1).ravel(), count)
    weight[0] = 0
    if not weight.any():
        return np.zeros(aim.shape, bool)
    mask = close_gaps(labels == weight.argmax(), gap=0.04) & (aim > _AIMED)
    size = float(np.sqrt(mask.sum()))
    bump = max(3, round(_BUMP * size) | 1)
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (bump, bump))
    opened = cv2.morphologyEx(np.pad(mask.astype(np.uint8), bump), cv2.MORPH_OPEN, disk)[bump:-bump, bump:-bump] > 0
    return close_gaps(opened, gap=_BAY * size / mask.shape[1])


def _region(evidence: Evidence, seed: float) -> Mask:
    """The field, begun by the colours at an aim above ``seed``: colours and region by turns, each by the other."""
    aim, said = evidence.share, evidence.said
    far = (aim < _FAR) & (evidence.aim > 0.02)
    prior = _BY_AIM * np.clip((aim - _MIDDLE) / 0.15, -1, 1) - _CERTAIN * (aim < _AIMED)
    own, other = np.clip((aim - seed) / (1 - seed), 0, 1), far.astype(np.float32)
    region = np.zeros(aim.shape, bool)
    for _ in range(_ROUNDS):
        odds = _log_odds(evidence.bins, own * said, other * said) * said
        worth = np.asarray(cv2.GaussianBlur((odds + prior).astype(np.float32), (0, 0), 0.8), np.float32)
        before, region = region, convex_region(worth, _outermost(worth, aim))
        if (before & region).sum() > _SETTLED * (before | region).sum():
            break
        own = cv2.erode(region.astype(np.uint8), np.ones((3, 3), np.uint8)).astype(np.float32)
        other = far + _BESIDE * _beside(region)
    return region


def _outermost(worth: Float, aim: Float) -> Mask:
    """The hull of what is worth something about the aim: no part of the field lies outside, straps and hands inside."""
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (5, 5))
    count, labels = cv2.connectedComponents(cv2.morphologyEx((worth > 0.3).astype(np.uint8), cv2.MORPH_OPEN, disk))
    weight = np.bincount(labels.ravel(), np.clip(aim - 0.7, 0, 1).ravel(), count)
    weight[0] = 0
    return convex_hull(np.isin(labels, np.flatnonzero(weight > 0.25 * weight.max()))) if weight.any() else aim > 0.9


def _beside(region: Mask) -> Float:
    """1 near a region, but for its very edge."""
    reach = max(3, int(_ROOM * np.sqrt(region.sum())))
    own = region.astype(np.uint8)
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    return (cv2.dilate(own, disk) - cv2.dilate(own, np.ones((3, 3), np.uint8))).astype(np.float32)


def _log_odds(bins: NDArray[np.int64], own: Float, other: Float) -> Float:
    """How much every pixel's colour is rather one of ``own`` than of ``other``."""

    def share(weight: Float) -> NDArray[np.float64]:
        counted = _smooth(np.bincount(bins.ravel(), weight.ravel().astype(np.float64), _BINS**3), 2.0)
        return counted / max(counted.sum(), 1e-9)

    odds = np.log((share(own) + 1e-5) / (share(other) + 1e-5))
    return np.clip(odds, -_CERTAIN, _CERTAIN)[bins].astype(np.float32)


def _bins(lab: NDArray) -> NDArray[np.int64]:
    """Lightness in steps of 10, a and b in steps of 5 about grey."""
    steps = np.round((lab - np.array([0, 64, 64], np.float32)) / np.array([10, 5, 5], np.float32))
    light, a, b = np.moveaxis(np.clip(steps, 0, _BINS - 1).astype(np.int64), 2, 0)
    return (light * _BINS + a) * _BINS + b


def _smooth(counts: NDArray, light: float, colour: float = 1.0) -> NDArray[np.float64]:
    """Counts of colours, blurred; in lightness by ``light`` steps, as lamps light unevenly."""
    return scipy.ndimage.gaussian_filter(counts.reshape(_BINS, _BINS, _BINS), (light, colour, colour)).ravel()


def _judged(mask: Mask, evidence: Evidence) -> FoundField:
    """How well a mask agrees with the aim and with edges in the picture: the product."""
    area = int(mask.sum())
    if not 0 < area <= _LARGEST * mask.size:
        return FoundField(mask, 0.0)
    aim = evidence.aim
    disk = aim >= np.partition(aim.ravel(), -area)[-area]  # as large as the mask, in the middle of the aim
    return FoundField(mask, float((mask & disk).sum() / area * _edges(mask, evidence.lab)))


def _edges(mask: Mask, lab: Float) -> float:
    """The share of an outline at which the colour changes."""
    around = np.ones((3, 3), np.uint8)
    own = mask.astype(np.uint8)
    line = cv2.dilate(own, around) != cv2.erode(own, around)
    inner, near_inner = _mean_beside(lab, cv2.erode(own, around, iterations=2))
    outer, near_outer = _mean_beside(lab, 1 - cv2.dilate(own, around, iterations=2))
    asked = line & near_inner & near_outer
    if asked.sum() < 20:
        return 0.0
    return float((np.linalg.norm(inner - outer, axis=2)[asked] > _EDGE).mean())


def _mean_beside(lab: Float, side: NDArray) -> tuple[Float, Mask]:
    """The mean colour of ``side`` within five pixels of every pixel, and where there is enough of it."""
    weight = side.astype(np.float32)
    share = cv2.blur(weight, (11, 11))
    mean = cv2.blur(lab * weight[..., None], (11, 11)) / np.maximum(share, 1e-3)[..., None]
    return mean.astype(np.float32), share > 0.02
