"""Where the surgical field lies, by several voices: what all cameras aim at, the colours that are there and not farther
out, what stays where hands come and go, and the field's hue as one of them. Where they do not agree nothing is claimed.

Pictures and masks are in aligned pixels, small ones (240 columns): (H, W, 3) uint8 BGR, and (H, W).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from mcsl_core.imaging.geometry import transform_points
from mcsl_core.imaging.masks import Mask, close_gaps, convex_hull, hue_mask, main_region

from .aligned_views import AlignedPose, AlignedView, Picture
from .field import modal_picture

Float = NDArray[np.float32]
_REACH = 0.3  # of a picture's width: how fast a camera's aim falls off from its middle
_AIMED = 0.68  # of the highest aim: simulated fields reach down to 0.61 to 0.92 of it with all but a hundredth
_FAR = 0.5  # of the highest aim: what lies below is not the field
_BUSY = 14  # levels of 255 that a pixel is off its own median half of the time: hands at work
_LARGEST = 0.35  # of the picture: drapes of the field's hue
_EDGE = 10  # levels of Lab between the two sides of an outline that is one
_SURE = 0.4  # least agreement at which a field is claimed; those of 25 tuning recordings lie at 0.49 to 0.83, one 0.33
# The field's hue is heard before other colours from this agreement on: where it shows the field it had 0.51 and more,
# where not (near-black skin, a narrow field, brown drapes) 0.37 and less.
_BY_HUE = 0.45
_BUMP, _BAY = 0.2, 0.5  # of the field's size: what of its outline is a finger or a strap's end, or a hand's bite
_NEAR = ((0.7, 1.2), (0.7, 4.0), (0.9, 1.2), (0.9, 4.0))  # from which aim on colours are the field's; blur in lightness
_BINS = 26


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
        The modal picture.
    aim : (H, W) float array
        What all cameras aim at; see `aim_of`.
    busy : (H, W) bool array
        Where hands come and go; see `busy_places`.
    """

    picture: Picture
    aim: Float
    busy: Mask

    @property
    def within(self) -> Mask:
        """Where the cameras aim at most."""
        return self.aim > _AIMED * self.aim.max()


def aim_of(aligned: AlignedPose) -> Float:
    """How much every place is what the cameras aim at: 1 in the middle of all pictures, the mean over the cameras."""
    width, height = aligned.size
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    places = np.stack([x.ravel(), y.ravel()], axis=1).astype(np.float64)
    total = np.zeros(width * height)
    for name in aligned.homographies:
        size = aligned.camera_sizes[name]
        own = transform_points(np.asarray(np.linalg.inv(aligned.warp_of(name, size)), np.float64), places)
        off = np.hypot(own[:, 0] - size[0] / 2, own[:, 1] - size[1] / 2) / size[0]
        total += np.exp(-((off / _REACH) ** 2))
    return (total / max(len(aligned.homographies), 1)).reshape(height, width).astype(np.float32)


def busy_places(samples: Iterable[Sequence[AlignedView]], size: tuple[int, int]) -> Mask:
    """Where hands come and go in most of the cameras, half of the time; ``size``: width and height."""
    pictures: dict[str, list[Picture]] = {}
    inside: dict[str, Mask] = {}
    for views in samples:
        for view in views:
            pictures.setdefault(view.camera, []).append(view.aligned)
            inside[view.camera] = view.inside
    if not pictures:
        return np.zeros((size[1], size[0]), bool)
    off = []
    for name, own in pictures.items():
        stack = np.stack(own).astype(np.int16)
        middle = np.median(stack, axis=0).astype(np.int16)
        off.append(np.where(inside[name], np.median(np.abs(stack - middle).max(axis=3), axis=0), np.inf))
    ranked = np.sort(np.stack(off), axis=0)
    seen = np.isfinite(ranked).sum(axis=0)
    median = np.take_along_axis(ranked, np.maximum(seen - 1, 0)[None] // 2, axis=0)[0]
    return np.isfinite(median) & (median > _BUSY)


def find_field(aligned: AlignedPose, samples: Sequence[Mapping[str, Picture | None]]) -> Mask:
    """Where the surgical field lies in a pose.

    Parameters
    ----------
    aligned : AlignedPose
        How the cameras lie, of some 240 columns; its own field is not used.
    samples : sequence of mapping of str to (h, w, 3) uint8 array or None
        Per sample, camera -> its picture, BGR.

    Returns
    -------
    (H, W) bool array
        Empty where the voices do not agree on one.

    Notes
    -----
    Intersection over union with the true field over 16 recordings, one of them a photograph's, with the true alignment:
    0.80 in the mean, 0.59 at worst (brown drapes); by hue alone 0.60 and 0.15.
    """
    busy = busy_places((aligned.views(pictures) for pictures in samples[:: max(1, len(samples) // 20)]), aligned.size)
    return field_by_voices(Evidence(modal_picture(aligned, samples), aim_of(aligned), busy)).mask


def field_by_voices(evidence: Evidence) -> FoundField:
    """The field that most speaks for; empty where too little does."""
    within = evidence.within
    best = _judged(_at_the_aim(hue_mask(evidence.picture) > 0, evidence) & within, evidence)
    if best.agreement < _BY_HUE:
        for near, blur in _NEAR:
            mask = _at_the_aim(_own_colours(evidence, near, blur), evidence)
            if mask.any():  # hands bite into what their colours leave
                mask = close_gaps(mask | (convex_hull(mask) & evidence.busy), gap=0.02) & within
            best = max(best, _judged(mask, evidence), key=lambda found: found.agreement)
    if best.agreement < _SURE:
        return FoundField(np.zeros(within.shape, bool), best.agreement)
    return FoundField(_rounded(best.mask), best.agreement)


def _rounded(mask: Mask) -> Mask:
    """The mask without bumps, its bays filled."""
    size = float(np.sqrt(mask.sum()))
    bump = max(3, round(_BUMP * size) | 1)
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (bump, bump))
    opened = cv2.morphologyEx(np.pad(mask.astype(np.uint8), bump), cv2.MORPH_OPEN, disk)[bump:-bump, bump:-bump] > 0
    return close_gaps(opened, gap=_BAY * size / mask.shape[1])


def _own_colours(evidence: Evidence, near: float, blur: float) -> Mask:
    """Where the colours are those at the aim, not those farther out. blur: in lightness, as lamps light unevenly."""
    lab = cv2.cvtColor(cv2.GaussianBlur(evidence.picture, (0, 0), 1), cv2.COLOR_BGR2LAB).astype(np.float32)
    steps = np.stack([lab[..., 0] / 10, (lab[..., 1] - 64) / 5, (lab[..., 2] - 64) / 5], axis=2)
    light, a, b = np.moveaxis(np.clip(np.round(steps), 0, _BINS - 1).astype(int), 2, 0)
    bins = (light * _BINS + a) * _BINS + b
    aim = evidence.aim / evidence.aim.max()

    def share(weight: NDArray) -> NDArray[np.float64]:
        counted = np.bincount(bins.ravel(), weight.ravel().astype(float), _BINS**3).reshape(_BINS, _BINS, _BINS)
        smooth = gaussian_filter(counted, (blur, 1.2, 1.2))
        return smooth.ravel() / max(smooth.sum(), 1e-9)

    still = ~evidence.busy
    own = share(np.clip((aim - near) / (1 - near), 0, 1) * still)
    other = share((aim < _FAR) & (evidence.aim > 0.02) & still)
    odds = (own / (own + other + 1e-7))[bins].astype(np.float32)
    return (cv2.GaussianBlur(odds, (0, 0), 1.2) > 0.6) & still


def _at_the_aim(mask: Mask, evidence: Evidence) -> Mask:
    """The region of a mask that most of the aim lies in, its gaps closed."""
    count, labels = cv2.connectedComponents(main_region(mask, least=0.002).astype(np.uint8))
    if count < 2:
        return np.zeros(mask.shape, bool)
    weight = np.clip(evidence.aim / evidence.aim.max() - 0.7, 0, 1)
    best = max(range(1, count), key=lambda label: float(weight[labels == label].sum()))
    return close_gaps(labels == best, gap=0.04)


def _judged(mask: Mask, evidence: Evidence) -> FoundField:
    """How well a mask agrees with the aim, with edges in the picture, and with itself as one region: the product."""
    area = int(mask.sum())
    if not 0 < area <= _LARGEST * mask.size:
        return FoundField(mask, 0.0)
    aim = evidence.aim
    disk = aim >= np.partition(aim.ravel(), -area)[-area]  # as large as the mask, in the middle of the aim
    aimed = (mask & disk).sum() / area
    return FoundField(mask, float(aimed * _edges(mask, evidence) * area / convex_hull(mask).sum()))


def _edges(mask: Mask, evidence: Evidence) -> float:
    """The share of an outline at which the colour changes; nothing is asked where hands work or the aim ends."""
    around = np.ones((3, 3), np.uint8)
    own, within = mask.astype(np.uint8), evidence.within.astype(np.uint8)
    line = cv2.dilate(own, around) != cv2.erode(own, around)
    limit = cv2.dilate((cv2.dilate(within, around) != cv2.erode(within, around)).astype(np.uint8), around, iterations=2)
    lab = cv2.cvtColor(evidence.picture, cv2.COLOR_BGR2LAB).astype(np.float32)
    inner, near_inner = _mean_beside(lab, cv2.erode(own, around, iterations=2))
    outer, near_outer = _mean_beside(lab, 1 - cv2.dilate(own, around, iterations=2))
    free = line & (limit == 0)
    asked = free & near_inner & near_outer & (cv2.dilate(evidence.busy.astype(np.uint8), around) == 0)
    if asked.sum() < 20:
        return 0.0
    natural = min(1.0, free.sum() / line.sum() / 0.35)
    return float(natural * (np.linalg.norm(inner - outer, axis=2)[asked] > _EDGE).mean())


def _mean_beside(lab: Float, side: NDArray) -> tuple[Float, Mask]:
    """The mean colour of ``side`` within five pixels of every pixel, and where there is enough of it."""
    weight = side.astype(np.float32)
    share = cv2.blur(weight, (11, 11))
    mean = cv2.blur(lab * weight[..., None], (11, 11)) / np.maximum(share, 1e-3)[..., None]
    return mean.astype(np.float32), share > 0.02
