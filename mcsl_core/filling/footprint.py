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
from .sources import Source, faded, missing, sets_of

_PLANS_BYTES = 200  # of plans, a pixel of the programme: 400 MB at 1080p, for 8 of 50 MB, one a conforming thread


class FootprintFiller:
    """Fills outside the camera's geometric footprint, softly over its edge, with what other cameras see there.

    The footprint follows from geometry alone, so dark pixels are no holes and nothing flickers. Behind the chosen
    camera stands one other, decoded all along: the reference, or the closest viewpoint that adds something. What both
    leave empty comes from the other cameras, looked at anew every ten seconds; what no camera sees now from other poses
    of the same perspective, earlier before later, the more blurred the further away in time. What nobody ever saw stays
    black.
    """

    name = "footprint"
    version = 5
    remembers = False

    def __init__(self, feather_px: float = 24.0) -> None:
        self.feather_px = feather_px
        self._plans: LruCache[FillPlan] | None = None

    def fill(self, context: FillContext) -> Planes:
        absent: frozenset[Source] = frozenset()
        while True:
            made = self._planned(context, absent)
            gone = {source for source in made.sources[1:] if missing(context, source)}
            if not gone:
                break
            absent |= gone  # a gap in a camera's pictures: as if it were not there
        if not made.patches:
            return context.front
        # The chosen camera's picture bends over into the others', so that what lies across its edge goes on there.
        front = context.picture(context.camera, Rect(0, 0, *context.size), parallax_corrected=True) or context.front
        out = Planes(*(plane.copy() for plane in front))
        hidden = find_occluders(context, made)
        wide = {index: (box, _picture(context, made.sources[index], box, hidden)) for index, box in made.boxes.items()}
        for patch in made.patches:
            _make(out, context, made.sources, patch, wide, hidden)
        return out

    def _planned(self, context: FillContext, absent: frozenset[Source]) -> FillPlan:
        if self._plans is None:
            self._plans = LruCache(_PLANS_BYTES * context.size[0] * context.size[1])
        return self._plans.get((context.geometry, absent), lambda: plan_layers(context, absent, self.feather_px))


# By source: what was looked at once for all its patches, and where that lies.
Wide = Mapping[int, tuple[Rect, Planes]]


def _make(
    out: Planes, context: FillContext, sources: Sequence[Source], patch: FillRegion, wide: Wide, hidden: Occluders
) -> None:
    target = patch.rect.of(out)
    pictures = []
    for layer in patch.layers:
        if layer.source == 0:
            pictures.append(target)
        elif layer.source in wide:
            box, seen = wide[layer.source]
            inside = Rect(patch.rect.x - box.x, patch.rect.y - box.y, patch.rect.width, patch.rect.height)
            pictures.append(inside.of(seen))
        else:
            pictures.append(_picture(context, sources[layer.source], patch.rect, hidden))
    for index, plane in enumerate(target):
        result: NDArray = tuple(pictures[-1])[index] if pictures else np.full(plane.shape, BLACK[index], np.uint8)
        behind = list(zip(pictures, patch.layers, strict=True))
        if patch.solid:
            behind.pop()
        else:
            result = np.full(plane.shape, BLACK[index], np.uint8)
        for picture, layer in reversed(behind):
            weight, rest = layer.half if index else layer.full
            result = cv2.blendLinear(tuple(picture)[index], result, weight, rest)
        plane[:] = result


def _picture(context: FillContext, source: Source, rect: Rect, hidden: Occluders) -> Planes:
    blur = 0.0 if source.frame is None else _blur_px(abs(context.frame - source.frame) / context.rate, context.size[0])
    found = [
        context.picture(source.camera, rect, median_of, blur, parallax_corrected=not source.plain)
        for median_of in sets_of(context, source)
    ]
    planes = [picture for picture in found if picture is not None]
    picture = planes[0] if len(planes) < 2 else _mixed(planes[0], planes[1], faded(context))
    if not source.live or source.camera not in hidden:
        return picture
    cover = hidden[source.camera]
    part = cover.within(rect)
    if part is None:
        return picture
    before = _picture(context, attrs.evolve(source, moment=True), rect, {})  # of all of it: the same for many frames
    out = Planes(*(plane.copy() for plane in picture))
    inside = Rect(part.x - rect.x, part.y - rect.y, part.width, part.height)
    weights = cover.over(part, 1), cover.over(part, 2), cover.over(part, 2)
    for target, old, new, weight in zip(inside.of(out), inside.of(before), inside.of(picture), weights, strict=True):
        target[:] = cv2.blendLinear(old, new, weight, 1 - weight)
    return out


def _mixed(a: Planes, b: Planes, share: float) -> Planes:
    return Planes(*(cv2.addWeighted(p, share, q, 1 - share, 0) for p, q in zip(a, b, strict=True)))  # pyright: ignore


def _blur_px(age_s: float, width: int) -> float:
    """Grows with the logarithm of the age, in steps too small to see: at 1920 pixels 0.7 at 10 s, 4 at 10 minutes."""
    return round(4 * 0.7 * log2(1 + age_s / 10)) / 4 * width / 1920
