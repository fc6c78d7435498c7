"""The default filler: what the warp leaves empty comes from the other cameras, by the geometry of their footprints.

Masks and alphas are on the grid of the chroma samples, (height / 2, width / 2).
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from math import log2

import cv2
import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from ..images import BLACK, U8, Planes, feathered
from ..timing import FrameRange
from .view import Rect, View

_SLIVER = 1 / 200  # least share of the frame for which one more camera is decoded all along: 100 x 100 pixels at 1080p
_SPECK = 1 / 20_000  # least share for which moments are looked at: 100 pixels at 1080p
_MOMENT_S = 10.0  # a new look every so many seconds: 150 ms of CPU at 1080p, where decoding on would take two seconds
_LOOKS = 5  # of which the median is taken, so that a hand or a head in one or two of them is not kept
_FADE_S = 1.0  # from one median to the next
_KEPT_PLANS = 8

Weight = NDArray[np.float32]


@frozen
class _Source:
    """Pictures of a camera: as it is now, or (``moment``) as it was last looked at, or at one frame of another pose."""

    camera: str
    moment: bool = False
    frame: int | None = None


@frozen(eq=False)
class _Layer:
    """One source's part in a patch: over what is behind it, at half and at full size, (weight, 1 - weight) each."""

    source: int
    half: tuple[Weight, Weight]
    full: tuple[Weight, Weight]


@frozen(eq=False)
class _Patch:
    """A piece to make: sources from front to back, the last of them alone (``solid``) or over black."""

    rect: Rect
    layers: tuple[_Layer, ...]
    solid: bool


@frozen(eq=False)
class _Plan:
    sources: tuple[_Source, ...]  # 0 is the chosen camera
    patches: tuple[_Patch, ...]
    boxes: Mapping[int, Rect] = field(factory=dict)  # sources that are looked at once, for all their patches


class FootprintFiller:
    """Fills outside the camera's geometric footprint, softly over its edge, with what other cameras see there.

    The footprint follows from the warp alone, so dark pixels are no holes and nothing flickers. Behind the chosen
    camera stands one other, decoded all along: the reference, or the closest viewpoint that adds something. What both
    leave empty comes from the other cameras, looked at anew every ten seconds; what no camera sees now from other poses
    of the same perspective, earlier before later, the more blurred the further away in time. What nobody ever saw stays
    black.
    """

    name = "footprint"
    version = 4
    remembers = False

    def __init__(self, feather_px: float = 24.0) -> None:
        self.feather_px = feather_px
        self._plans: dict[Hashable, _Plan] = {}

    def fill(self, view: View) -> Planes:
        absent: frozenset[_Source] = frozenset()
        while True:
            plan = self._planned(view, absent)
            gone = {source for source in plan.sources[1:] if _missing(view, source)}
            if not gone:
                break
            absent |= gone  # a gap in a camera's pictures: as if it were not there
        if not plan.patches:
            return view.front
        out = Planes(*(plane.copy() for plane in view.front))
        wide = {source: (box, view.look(plan.sources[source].camera, box)) for source, box in plan.boxes.items()}
        for patch in plan.patches:
            _make(out, view, plan.sources, patch, wide)
        return out

    def _planned(self, view: View, absent: frozenset[_Source]) -> _Plan:
        key = (view.geometry, absent)
        plan = self._plans.get(key)
        if plan is None:
            plan = self._plan(view, absent)
            while len(self._plans) >= _KEPT_PLANS:
                self._plans.pop(next(iter(self._plans)), None)
            self._plans[key] = plan
        return plan

    def _plan(self, view: View, absent: frozenset[_Source]) -> _Plan:
        feather = self.feather_px / 2  # the footprints are half size
        front = view.footprint(view.camera)
        if front.min() == 255:
            return _Plan((_Source(view.camera),), ())
        sources, masks = [_Source(view.camera)], [front]
        shares = [_alpha(front, feather)]
        left = 1 - shares[0]
        live = False
        for candidate in _candidates(view):
            if left.mean() < _SPECK:
                break
            source = candidate
            if source.frame is None and not live and _Source(source.camera) not in absent:
                source = _Source(source.camera)  # perhaps the one that is decoded all along
            elif source in absent:
                continue
            mask = view.footprint(source.camera, source.frame)
            share = left * _alpha(mask, feather)
            gain = float(share.mean())
            if not source.moment and source.frame is None and gain < _SLIVER:
                source = candidate
                if source in absent:
                    continue
            if gain < _SPECK:
                continue
            live = live or not (source.moment or source.frame is not None)
            sources.append(source)
            masks.append(mask)
            shares.append(share)
            left = left - share
        edge = _weights(np.maximum.reduce(masks))  # where nobody sees on: as smooth as the footprints are
        seen = np.maximum(1 - left, 1e-4)
        shares = [np.where(left < 0.9999, share / seen, 0) * edge for share in shares]
        patches = tuple(_patches(shares))
        return _Plan(tuple(sources), patches, _boxes(sources, patches))


def _candidates(view: View) -> Iterator[_Source]:
    """Who may stand behind, the best first."""
    for camera in view.others:
        yield _Source(camera, moment=True)
    for still in view.elsewhere:
        frame = still.stop - 1 if still.start < view.still.start else still.start  # the nearest in time
        for camera in (view.camera, *view.others):
            yield _Source(camera, frame=frame)


def _steps(view: View) -> int:
    return max(1, round(_MOMENT_S * view.rate))


def _sets(view: View, source: _Source) -> tuple[tuple[int, ...], ...]:
    """The sets of moments at which a source is looked at, the latest first; an empty set is now."""
    step = _steps(view)
    if source.frame is not None:
        last = source.frame // step
        still = next(piece for piece in view.elsewhere if source.frame in piece)
        return (_moments(last if source.frame > still.start else last + _LOOKS - 1, step, still),)
    if not source.moment:
        return ((),)
    last = view.frame // step
    now, before = _moments(last, step, view.still), _moments(last - 1, step, view.still)
    return (now,) if now == before or _faded(view) >= 1 else (now, before)


def _moments(last: int, step: int, still: FrameRange) -> tuple[int, ...]:
    """The latest looks of the grid up to number ``last``, within ``still``; the first ones of it near its start."""
    first = -(-still.start // step)
    last = min(max(last, first + _LOOKS - 1), (still.stop - 1) // step)
    inside = tuple(n * step for n in range(max(first, last - _LOOKS + 1), last + 1))
    return inside or ((still.start + still.stop) // 2,)


def _faded(view: View) -> float:
    """How much of the latest looks has come, 0..1."""
    return min(1.0, (view.frame % _steps(view) + 1) / max(1.0, _FADE_S * view.rate))


def _missing(view: View, source: _Source) -> bool:
    speck = Rect(0, 0, 2, 2)
    return any(view.look(source.camera, speck, moments) is None for moments in _sets(view, source))


# ------------------------------------------------------------------------------------------------------- planning


def _patches(shares: Sequence[Weight]) -> Iterator[_Patch]:
    """Rectangles that cover all that is not the front alone, each with the sources that show in it."""
    black = 1 - np.sum(shares, axis=0)
    visible = [share > 1 / 512 for share in (*shares, black)]
    for rect, members in strips(visible):
        part = (slice(rect.y // 2, (rect.y + rect.height) // 2), slice(rect.x // 2, (rect.x + rect.width) // 2))
        solid = len(shares) not in members
        names = [m for m in members if m < len(shares)]
        behind = np.zeros((rect.height // 2, rect.width // 2), np.float32) if solid else np.maximum(black[part], 0)
        layers = []
        for name in reversed(names):
            share = np.maximum(shares[name][part], 0)
            behind = behind + share
            layers.append(_layer(name, np.where(behind > 1e-4, share / np.maximum(behind, 1e-4), 0)))
        yield _Patch(rect, tuple(reversed(layers)), solid)


def _boxes(sources: Sequence[_Source], patches: Sequence[_Patch]) -> dict[int, Rect]:
    """Of each camera that is decoded all along the rectangle around its patches, where they fill a third of it.

    One look of 1920x1080 pixels takes as long as 40 that together are half as large.
    """
    boxes = {}
    for index, source in enumerate(sources):
        if index == 0 or source.moment or source.frame is not None:
            continue
        rects = [patch.rect for patch in patches if any(layer.source == index for layer in patch.layers)]
        if not rects:
            continue
        x, y = min(r.x for r in rects), min(r.y for r in rects)
        right, bottom = max(r.x + r.width for r in rects), max(r.y + r.height for r in rects)
        box = Rect(x, y, right - x, bottom - y)
        if 3 * sum(r.width * r.height for r in rects) >= box.width * box.height:
            boxes[index] = box
    return boxes


def _layer(source: int, weight: NDArray) -> _Layer:
    half = np.ascontiguousarray(weight, np.float32)
    full = np.asarray(
        cv2.resize(half, (2 * half.shape[1], 2 * half.shape[0]), interpolation=cv2.INTER_LINEAR), np.float32
    )
    return _Layer(source, (half, 1 - half), (full, 1 - full))


def strips(visible: Sequence[NDArray[np.bool_]], rows: int = 32, least: int = 16) -> list[tuple[Rect, tuple[int, ...]]]:
    """Rectangles (in pixels twice as fine as the masks) and the masks that are true somewhere in each.

    Together they cover all but where the first mask alone is true. Bands of ``rows`` half-size rows are cut where the
    set of masks changes; pieces narrower than ``least`` columns go to a neighbour; equal ones above each other join.
    """
    height, width = visible[0].shape
    found: list[tuple[Rect, int]] = []
    open_: dict[tuple[int, int, int], int] = {}
    for top in range(0, height, rows):
        bits = np.zeros(width, np.int64)
        for index, mask in enumerate(visible):
            bits |= mask[top : top + rows].any(axis=0).astype(np.int64) << index
        tall = min(rows, height - top)
        going: dict[tuple[int, int, int], int] = {}
        for start, stop, signature in _runs(bits, least):
            if signature == 1:
                continue
            key = (start, stop, signature)
            rect = Rect(2 * start, 2 * top, 2 * (stop - start), 2 * tall)
            at = open_.get(key)
            if at is None:
                at = len(found)
                found.append((rect, signature))
            else:
                above = found[at][0]
                found[at] = (Rect(above.x, above.y, above.width, above.height + rect.height), signature)
            going[key] = at
        open_ = going
    return [(rect, tuple(i for i in range(len(visible)) if signature >> i & 1)) for rect, signature in found]


def _runs(bits: NDArray[np.int64], least: int) -> list[tuple[int, int, int]]:
    """(start, stop, value) of equal neighbours; short ones joined with the one before, their bits together."""
    cuts = [0, *(np.flatnonzero(np.diff(bits)) + 1).tolist(), len(bits)]
    runs: list[tuple[int, int, int]] = []
    for start, stop in zip(cuts, cuts[1:], strict=False):
        value = int(bits[start])
        if runs and (stop - start < least or runs[-1][1] - runs[-1][0] < least):
            begin, _, before = runs.pop()
            value |= before
            start = begin
        runs.append((start, stop, value))
    return runs


def _alpha(mask: U8, feather: float) -> Weight:
    """A camera's weight against what is behind it; a trace of it to its very edge, which counts where nobody is."""
    return np.maximum(
        _weights(feathered(np.where(mask > 127, 255, 0).astype(np.uint8), feather)), 1e-3 * _weights(mask)
    )


def _weights(alpha: U8) -> Weight:
    return alpha.astype(np.float32) / np.float32(255)


# --------------------------------------------------------------------------------------------------------- making


# By source: what was looked at once for all its patches, and where that lies.
Wide = Mapping[int, tuple[Rect, Planes | None]]


def _make(out: Planes, view: View, sources: Sequence[_Source], patch: _Patch, wide: Wide) -> None:
    target = patch.rect.of(out)
    pictures = []
    for layer in patch.layers:
        box, seen = wide.get(layer.source, (patch.rect, None))
        if layer.source == 0:
            pictures.append(target)
        elif seen is not None:
            inside = Rect(patch.rect.x - box.x, patch.rect.y - box.y, patch.rect.width, patch.rect.height)
            pictures.append(inside.of(seen))
        else:
            pictures.append(_picture(view, sources[layer.source], patch.rect))
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


def _picture(view: View, source: _Source, rect: Rect) -> Planes:
    blur = 0.0 if source.frame is None else _blur_px(abs(view.frame - source.frame) / view.rate, view.size[0])
    found = [view.look(source.camera, rect, moments, blur) for moments in _sets(view, source)]
    planes = [picture for picture in found if picture is not None]
    if len(planes) < 2:
        return planes[0]
    share = _faded(view)
    return Planes(*(cv2.addWeighted(a, share, b, 1 - share, 0) for a, b in zip(*planes, strict=True)))  # pyright: ignore


def _blur_px(age_s: float, width: int) -> float:
    """Grows with the logarithm of the age, in steps too small to see: at 1920 pixels 0.7 at 10 s, 4 at 10 minutes."""
    return round(4 * 0.7 * log2(1 + age_s / 10)) / 4 * width / 1920
