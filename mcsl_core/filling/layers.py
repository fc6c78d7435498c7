"""Which source shows where in a programme frame: worked out once for all frames of one geometry.

Masks and weights are on the grid of the chroma samples, (height / 2, width / 2).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import attrs
import cv2
import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.imaging.masks import feathered
from mcsl_core.imaging.planes import U8
from mcsl_core.imaging.rect import Rect

from .protocol import CELL, FillContext
from .sources import Source, candidates

_SLIVER = 1 / 200  # least share of the frame for which one more camera is decoded all along: 100 x 100 pixels at 1080p
_SPECK = 1 / 20_000  # least share for which median_of are looked at: 100 pixels at 1080p

Weight = NDArray[np.float32]


@frozen(eq=False)
class FillLayer:
    """One source's part in a patch: over what is behind it, at half and at full size, (weight, 1 - weight) each."""

    source: int
    half: tuple[Weight, Weight]
    full: tuple[Weight, Weight]


@frozen(eq=False)
class FillRegion:
    """A piece to make: sources from front to back, the last of them alone (``solid``) or over black."""

    rect: Rect
    layers: tuple[FillLayer, ...]
    solid: bool


@frozen(eq=False)
class FillPlan:
    sources: tuple[Source, ...]  # 0 is the chosen camera
    patches: tuple[FillRegion, ...]
    both: Weight | None = None  # by cell: how much of it the chosen camera and the one decoded beside it both see
    boxes: Mapping[int, Rect] = field(factory=dict)  # sources that are looked at once, for all their patches


def plan_layers(context: FillContext, absent: frozenset[Source], feather_px: float) -> FillPlan:
    """What stands where behind the chosen camera. absent: sources without a picture, as if they were not there."""
    feather = feather_px / 2  # the footprints are half size
    if context.footprint(context.camera).min() == 255:
        return FillPlan((Source(context.camera),), ())
    front = context.footprint(context.camera, parallax_corrected=True)
    sources, masks = [Source(context.camera)], [front]
    shares = [_alpha(front, feather)]
    left = 1 - shares[0]

    def adds(source: Source, least: float) -> bool:
        """Puts ``source`` behind the others, if so much of the picture is seen by it alone."""
        nonlocal left
        mask = context.footprint(source.camera, source.frame, parallax_corrected=not source.plain)
        share = left * _alpha(mask, feather)
        if source in absent or share.mean() < least:
            return False
        sources.append(source)
        masks.append(mask)
        shares.append(share)
        left = left - share
        return True

    live = False
    for source in candidates(context):
        if left.mean() < _SPECK:
            break
        if source.moment and not live:
            live = adds(Source(source.camera), _SLIVER)  # the one that is decoded all along
            if live:
                continue
        adds(source, _SPECK)
    for source, mask in tuple(zip(sources, masks, strict=True)):  # what is bent away from its edge
        if not np.array_equal(mask, context.footprint(source.camera, source.frame)):
            adds(attrs.evolve(source, plain=True), _SPECK)
    edge = _weights(np.maximum.reduce(masks))  # where nobody sees on: as smooth as the footprints are
    seen = np.maximum(1 - left, 1e-4)
    shares = [np.where(left < 0.9999, share / seen, 0) * edge for share in shares]
    patches = tuple(_patches(shares))
    second = next((i for i, source in enumerate(sources) if i and source.live), None)
    both = None if second is None else _cells(context, cv2.min(masks[0], masks[second]))
    return FillPlan(tuple(sources), patches, both, _boxes(patches))


def _patches(shares: Sequence[Weight]) -> Iterator[FillRegion]:
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
        yield FillRegion(rect, tuple(reversed(layers)), solid)


def _boxes(patches: Sequence[FillRegion]) -> dict[int, Rect]:
    """For each source behind the first the rectangle around its patches, where they fill a third of it.

    One look of 1920x1080 pixels takes as long as 40 that together are half as large.
    """
    rects: dict[int, list[Rect]] = {}
    for patch in patches:
        for layer in patch.layers:
            if layer.source:
                rects.setdefault(layer.source, []).append(patch.rect)
    boxes = {}
    for source, own in rects.items():
        x, y = min(r.x for r in own), min(r.y for r in own)
        right, bottom = max(r.x + r.width for r in own), max(r.y + r.height for r in own)
        box = Rect(x, y, right - x, bottom - y)
        if 3 * sum(r.width * r.height for r in own) >= box.width * box.height:
            boxes[source] = box
    return boxes


def _layer(source: int, weight: NDArray) -> FillLayer:
    half = np.ascontiguousarray(weight, np.float32)
    full = np.asarray(
        cv2.resize(half, (2 * half.shape[1], 2 * half.shape[0]), interpolation=cv2.INTER_LINEAR), np.float32
    )
    return FillLayer(source, (half, 1 - half), (full, 1 - full))


def strips(visible: Sequence[NDArray[np.bool_]], rows: int = 96, least: int = 16) -> list[tuple[Rect, tuple[int, ...]]]:
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


def _cells(context: FillContext, mask: NDArray) -> Weight:
    size = (-(-context.size[0] // CELL), -(-context.size[1] // CELL))
    return _weights(np.asarray(cv2.resize(mask, size, interpolation=cv2.INTER_AREA), np.uint8))
