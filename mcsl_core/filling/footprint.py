"""The default filler: what the warp leaves empty comes from the other cameras, by the geometry of their footprints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import log2

import attrs
import cv2
import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.imaging.planes import BLACK, Planes
from mcsl_core.imaging.rect import Rect
from mcsl_core.lru_cache import LruCache

from .crossings import Crossing, find_crossings
from .layers import FillPlan, FillRegion, plan_layers
from .occluders import Occluder, Occluders, find_motion, find_occluders
from .protocol import FillContext
from .sources import Source, crossfade, median_frames, missing

_PLANS_BYTES = 200  # of plans, a pixel of the programme: 400 MB at 1080p, for 8 of 50 MB, one a conforming thread

# By source: its picture for all its regions, warped once, and where that lies.
BoxPictures = Mapping[int, tuple[Rect, Planes]]


@frozen(eq=False)
class Others:
    """Who is in the way of a camera, and what crosses the edge towards its picture; by camera."""

    occluders: Occluders = field(factory=dict)
    crossings: Mapping[str, tuple[Crossing, ...]] = field(factory=dict)


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
    version = 6
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
        others = _others_in(context, plan, front)
        boxes = {
            index: (box, _source_picture(context, plan.sources[index], box, others))
            for index, box in plan.boxes.items()
        }
        for region in plan.regions:
            _fill_region(out, context, plan.sources, region, boxes, others)
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
    others: Others,
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
            pictures.append(_source_picture(context, sources[layer.source], region.rect, others))
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


def _others_in(context: FillContext, plan: FillPlan, front: Planes) -> Others:
    """Who is in the way of the camera decoded beside the chosen one, and who crosses the edge between the two."""
    motion = find_motion(context, plan)
    if motion is None or plan.overlap is None:
        return Others()
    occluders, camera = find_occluders(plan.overlap, motion), motion.camera
    if not motion.crosses(plan.overlap):
        return Others(occluders)
    whole = Rect(0, 0, *context.size)
    medians = [
        _source_picture(context, Source(name, median=True), whole, Others()) for name in (context.camera, camera)
    ]
    other = _source_picture(context, Source(camera), whole, Others())
    inside, reach = (context.footprint(name, parallax_corrected=True) for name in (context.camera, camera))
    return Others(occluders, {camera: find_crossings((front, medians[0]), (other, medians[1]), inside, reach)})


def _source_picture(context: FillContext, source: Source, rect: Rect, others: Others) -> Planes:
    """A source's picture in ``rect``, without who is in its way, and with what crosses the edge where it belongs."""
    blur = 0.0 if source.frame is None else _blur_px(abs(context.frame - source.frame) / context.rate, context.size[0])
    found = [
        context.picture(source.camera, rect, frames, blur, parallax_corrected=not source.plane_only)
        for frames in median_frames(context, source)
    ]
    planes = [picture for picture in found if picture is not None]
    picture = planes[0] if len(planes) < 2 else _crossfaded(planes[0], planes[1], crossfade(context))
    if not source.live:
        return picture
    occluder, crossings = others.occluders.get(source.camera), others.crossings.get(source.camera, ())
    parts = [part for one in (occluder, *crossings) if one is not None and (part := one.within(rect)) is not None]
    if not parts:
        return picture
    # Of all of the rectangle, not of the parts alone: it is the same for many frames.
    median = _source_picture(context, attrs.evolve(source, median=True), rect, Others())
    out = Planes(*(plane.copy() for plane in picture))
    if occluder is not None:
        _hide(out, median, occluder, rect)
    for crossing in crossings:
        _move(context, source, out, median, crossing, rect)
    return out


def _hide(out: Planes, median: Planes, occluder: Occluder, rect: Rect) -> None:
    """Put the camera's median where somebody is in its way; ``out`` and ``median`` are of ``rect``."""
    part = occluder.within(rect)
    if part is None:
        return
    inside = part.moved(-rect.x, -rect.y)
    chroma = occluder.weights(part, 2)
    weights = occluder.weights(part, 1), chroma, chroma
    for target, old, weight in zip(inside.of(out), inside.of(median), weights, strict=True):
        target[:] = cv2.blendLinear(old, target, weight, 1 - weight)


def _move(context: FillContext, source: Source, out: Planes, median: Planes, crossing: Crossing, rect: Rect) -> None:
    """Put what crosses the edge where it belongs; ``out`` and ``median`` are of ``rect``."""
    part = crossing.within(rect)
    if part is None:
        return
    corrected = not source.plane_only
    moved = context.picture(source.camera, part, parallax_corrected=corrected, shift=crossing.shift)
    if moved is None:
        return
    inside = part.moved(-rect.x, -rect.y)
    made = crossing.laid(inside.of(out), inside.of(median), moved, part)
    for target, plane in zip(inside.of(out), made, strict=True):
        target[:] = plane


def _crossfaded(a: Planes, b: Planes, weight: float) -> Planes:
    return Planes(*(cv2.addWeighted(p, weight, q, 1 - weight, 0) for p, q in zip(a, b, strict=True)))  # pyright: ignore


def _blur_px(age_s: float, width: int) -> float:
    """Grows with the logarithm of the age, in steps too small to see: at 1920 pixels 0.7 at 10 s, 4 at 10 minutes."""
    return round(4 * 0.7 * log2(1 + age_s / 10)) / 4 * width / 1920
