"""Where the colours of a pose's cameras are compared: where both show the same.

Heads stand before cameras for most of a short pose. A match fitted to one camera's head and another's drape turns the
field blue: by medians of what both show steadily 5 of 28 matches of three recordings were off by 7 to 33 units of
chroma (L*a*b*), by what goes up and down alike none.
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence

import cv2
import numpy as np

from mcsl_core.edl import Colour
from mcsl_core.imaging.correlation import Values, correlation, mean
from mcsl_core.imaging.masks import Mask, resize_mask

from .aligned_views import AlignedPose, Picture
from .colour_match import match_colours

Samples = Sequence[Mapping[str, Picture | None]]

_COLUMNS = 160  # of the cells that are held against each other
_ALIKE = 0.9  # correlation of the same thing
_SURROUNDINGS = 17  # cells
LEAST, HARDLY = 0.02, 0.005  # of the picture: sure; below it two of three matches were right, one was 24 units off
_STEADY = 6  # levels of 255 that a pixel may be off its median half of the time: noise and breathing, not hands
_OVERLAP = 0.02  # of the picture


def agreed_colours(aligned: AlignedPose, samples: Samples, least: float = LEAST) -> dict[str, Colour]:
    """Each camera's match to the reference camera, from where both show the same at an instant.

    Parameters
    ----------
    aligned : AlignedPose
        The pose.
    samples : sequence of mapping of str to picture
        Of instants in it, each camera's picture or None.
    least : float
        Share of the picture, in the mean of the samples.

    Returns
    -------
    dict of str to Colour
        Without the cameras that share less with it: heads may be before one of them all the time, or there is nothing
        there that goes up and down.
    """
    shared: dict[str, list[tuple[Picture, Picture, Mask]]] = {}
    for pictures in samples:
        views = {view.camera: view for view in aligned.views(pictures)}
        target = views.pop(aligned.reference, None)
        if target is None:
            continue
        for name, view in views.items():
            both = view.inside & target.inside
            where = both & _alike(view.aligned, target.aligned, both)
            shared.setdefault(name, []).append((view.aligned, target.aligned, where))
    colours = {}
    for name, own in shared.items():
        source, target, where = (np.concatenate(part) for part in zip(*own, strict=True))
        found = match_colours(source, target, where.astype(np.uint8)) if where.mean() >= least else None
        if found is not None:
            colours[name] = found
    return colours


def steady_colours(aligned: AlignedPose, samples: Samples, cameras: Container[str]) -> dict[str, Colour]:
    """The matches of some cameras to the reference camera, from the medians of what both show steadily.

    For want of better: a smooth field has nothing in it that goes up and down, and a head that stays is steady as well.
    """
    shown: dict[str, list[Picture]] = {}
    steady: dict[str, Mask] = {}
    for pictures in samples:
        for view in aligned.views(pictures):
            if view.camera in cameras or view.camera == aligned.reference:
                shown.setdefault(view.camera, []).append(view.aligned)
                steady[view.camera] = view.inside
    medians: dict[str, Picture] = {}
    for name, own in shown.items():
        stack = np.stack(own)
        medians[name] = np.median(stack, axis=0).astype(np.uint8)
        off = np.median(cv2.absdiff(stack, np.broadcast_to(medians[name], stack.shape).copy()), axis=0).max(axis=2)
        steady[name] = steady[name] & (off <= _STEADY)
    if aligned.reference not in medians:
        return {}
    target = medians.pop(aligned.reference)
    colours = {}
    for name, median in medians.items():
        overlap = steady[name] & steady[aligned.reference]
        if overlap.mean() > _OVERLAP:
            found = match_colours(median, target, overlap.astype(np.uint8))
            if found is not None:
                colours[name] = found
    return colours


def _alike(a: Picture, b: Picture, both: Mask) -> Mask:
    """Where two pictures that lie over each other go up and down alike."""
    height, width = both.shape
    size = (_COLUMNS, max(1, round(_COLUMNS * height / width)))
    outside = cv2.resize(both.astype(np.float32), size, interpolation=cv2.INTER_AREA) < 0.99
    lumas = []
    for picture in (a, b):
        luma = cv2.resize(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), size, interpolation=cv2.INTER_AREA)
        lumas.append(np.where(outside, np.nan, luma - _about(luma.astype(np.float32), ~outside)).astype(np.float32))
    return resize_mask(correlation(*lumas)[0] > _ALIKE, (width, height))


def _about(luma: Values, inside: Mask) -> Values:
    """The mean of the surroundings: one smooth slope, as light that falls off, is like any other."""
    known = inside.astype(np.float32)
    return np.asarray(mean(luma * known, _SURROUNDINGS) / np.maximum(mean(known, _SURROUNDINGS), 1e-3), np.float32)
