"""The default filler: what the warp leaves empty comes from the other cameras, by the geometry of their footprints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import log2

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.imaging.planes import BLACK, Planes
from mcsl_core.imaging.rect import Rect
from mcsl_core.lru_cache import LruCache

from .layers import FillPlan, FillRegion, plan_layers
from .occluders import Occluders, find_occluders
from .protocol import FillContext
from .sources import Source, crossfade, median_frames, missing

_PLANS_BYTES = 200  # of plans, a pixel of the programme: 400 MB at 1080p, for 8 of 50 MB, one a conforming thread

# By source: its picture for all its regions, warped once, and where that lies.
BoxPictures = Mapping[int, tuple[Rect, Planes]]


class FootprintFiller:
    """Fills outside the camera's geometric footprint, softly over its edge, with what other cameras see there.

    The footprint follows from geometry alone, so dark pixels are no holes and nothing flickers. Behind the chosen
    camera stands one other, decoded all along: the reference, or the nearest viewpoint that adds something. What both
    leave empty comes from the other cameras' medians, made anew every ten seconds; what no camera shows now from other
    poses of the same perspective, earlier before later, the more blurred the further away in time. What no camera ever
    showed stays black.

    Parameters
    ----------
    feather_px : float
        Width of the soft edge between two cameras, in programme pixels.
    """

    name = "footprint"
    version = 5
    remembers = False

    def __init__(self, feather_px: float = 24.0) -> None:
        self.feather_px = feather_px
        self._plans: LruCache[FillPlan] | None = None

    def fill(self, context: FillContext) -> Planes:
        """Fill one programme frame; see `Filler`."""
        absent: frozenset[Source] = frozenset()
        while True:
            plan = self._planned(context, absent)
            gone = {source for source in plan.sources[1:] if missing(context, source)}
            if not gone:
                break
            absent |= gone  # a gap in a camera's pictures: as if it were not there
        if not plan.regions:
            return context.front
        # The chosen camera's picture bends over into the others', so that what lies across its edge goes on there.
        front = context.picture(context.camera, Rect(0, 0, *context.size), parallax_corrected=True) or context.front
        out = Planes(*(plane.copy() for plane in front))
        occluders = find_occluders(context, plan)
        boxes = {
            index: (box, _source_picture(context, plan.sources[index], box, occluders))
            for index, box in plan.boxes.items()
        }
        for region in plan.regions:
            _fill_region(out, context, plan.sources, region, boxes, occluders)
        return out

    def _planned(self, context: FillContext, absent: frozenset[Source]) -> FillPlan:
        if self._plans is None:
            self._plans = LruCache(_PLANS_BYTES * context.size[0] * context.size[1])
        return self._plans.get((context.geometry, absent), lambda: plan_layers(context, absent, self.feather_px))


def _fill_region(
    out: Planes,
    context: FillContext,
    sources: Sequence[Source],
    region: FillRegion,
    boxes: BoxPictures,
    occluders: Occluders,
) -> None:
    """Blend the region's layers from back to front into ``out``."""
    target = region.rect.of(out)
    pictures = []
    for layer in region.layers:
        if layer.source == 0:
            pictures.append(target)
        elif layer.source in boxes:
            box, picture = boxes[layer.source]
            inside = Rect(region.rect.x - box.x, region.rect.y - box.y, region.rect.width, region.rect.height)
            pictures.append(inside.of(picture))
        else:
            pictures.append(_source_picture(context, sources[layer.source], region.rect, occluders))
    for index, plane in enumerate(target):
        result: NDArray = tuple(pictures[-1])[index] if pictures else np.full(plane.shape, BLACK[index], np.uint8)
        behind = list(zip(pictures, region.layers, strict=True))
        if region.solid:
            behind.pop()
        else:
            result = np.full(plane.shape, BLACK[index], np.uint8)
        for picture, layer in reversed(behind):
            weight, rest = layer.half if index else layer.full
            result = cv2.blendLinear(tuple(picture)[index], result, weight, rest)
        plane[:] = result


def _source_picture(context: FillContext, source: Source, rect: Rect, occluders: Occluders) -> Planes:
    """A source's picture in ``rect``; where somebody is in the way, that camera's median in its place."""
    blur = 0.0 if source.frame is None else _blur_px(abs(context.frame - source.frame) / context.rate, context.size[0])
    found = [
        context.picture(source.camera, rect, frames, blur, parallax_corrected=not source.plane_only)
        for frames in median_frames(context, source)
    ]
    planes = [picture for picture in found if picture is not None]
    picture = planes[0] if len(planes) < 2 else _crossfaded(planes[0], planes[1], crossfade(context))
    if not source.live or source.camera not in occluders:
        return picture
    occluder = occluders[source.camera]
    part = occluder.within(rect)
    if part is None:
        return picture
    # Of all of the rectangle, not of the part alone: it is the same for many frames.
    median = _source_picture(context, attrs.evolve(source, median=True), rect, {})
    out = Planes(*(plane.copy() for plane in picture))
    inside = Rect(part.x - rect.x, part.y - rect.y, part.width, part.height)
    chroma = occluder.weights(part, 2)
    weights = occluder.weights(part, 1), chroma, chroma
    for target, old, new, weight in zip(inside.of(out), inside.of(median), inside.of(picture), weights, strict=True):
        target[:] = cv2.blendLinear(old, new, weight, 1 - weight)
    return out


def _crossfaded(a: Planes, b: Planes, weight: float) -> Planes:
    return Planes(*(cv2.addWeighted(p, weight, q, 1 - weight, 0) for p, q in zip(a, b, strict=True)))  # pyright: ignore


def _blur_px(age_s: float, width: int) -> float:
    """Grows with the logarithm of the age, in steps too small to see: at 1920 pixels 0.7 at 10 s, 4 at 10 minutes."""
    return round(4 * 0.7 * log2(1 + age_s / 10)) / 4 * width / 1920
