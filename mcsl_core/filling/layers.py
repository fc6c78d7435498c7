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
_SPECK = 1 / 20_000  # least share for which a median is made: 100 pixels at 1080p
_BAND = 96  # half-size rows in which regions are found
_NARROWEST = 16  # half-size columns of a region

Weight = NDArray[np.float32]


@frozen(eq=False)
class FillLayer:
    """One source's part in a region, over what is behind it.

    Attributes
    ----------
    source : int
        Index into `FillPlan.sources`.
    half, full : pair of float32 arrays
        (weight, 1 - weight) by chroma sample and by luma sample of the region.
    """

    source: int
    half: tuple[Weight, Weight]
    full: tuple[Weight, Weight]


@frozen(eq=False)
class FillRegion:
    """A rectangle of the programme to fill.

    Attributes
    ----------
    rect : Rect
        In programme pixels.
    layers : tuple of FillLayer
        From front to back.
    solid : bool
        Whether the last layer fills all of it; else there is black behind.
    """

    rect: Rect
    layers: tuple[FillLayer, ...]
    solid: bool


@frozen(eq=False)
class FillPlan:
    """What is to be filled, and from where.

    Attributes
    ----------
    sources : tuple of Source
        The chosen camera, then those behind it.
    regions : tuple of FillRegion
        All that is not the chosen camera's picture alone; they do not overlap.
    overlap : (ceil(height / 16), ceil(width / 16)) float32, optional
        How much of each cell the chosen camera and the one decoded beside it both show.
    boxes : mapping of int to Rect
        Sources that are warped once for all their regions, and around what.
    """

    sources: tuple[Source, ...]
    regions: tuple[FillRegion, ...]
    overlap: Weight | None = None
    boxes: Mapping[int, Rect] = field(factory=dict)


def plan_layers(context: FillContext, absent: frozenset[Source], feather_px: float) -> FillPlan:
    """What stands where behind the chosen camera.

    Parameters
    ----------
    context : FillContext
        Any programme frame of the geometry.
    absent : frozenset of Source
        Sources without a picture, as if they did not exist.
    feather_px : float
        Width of the soft edge between two sources, in programme pixels.

    Returns
    -------
    FillPlan
        Without regions where the chosen camera's picture fills the programme.
    """
    if context.footprint(context.camera).min() == 255:
        return FillPlan((Source(context.camera),), ())
    stack = _Stack(context, absent, feather_px / 2)  # the footprints are half size
    live = False
    for source in candidates(context):
        if stack.left.mean() < _SPECK:
            break
        if source.median and not live:
            live = stack.add(Source(source.camera), _SLIVER)  # the one that is decoded all along
            if live:
                continue
        if not (source.median and context.followed):
            stack.add(source, _SPECK)
    stack.add_plane_only()
    sources = tuple(stack.sources)
    regions = tuple(_regions(stack.visible_shares()))
    second = next((i for i, source in enumerate(sources) if i and source.live), None)
    overlap = None if second is None else _by_cell(context, cv2.min(stack.masks[0], stack.masks[second]))
    return FillPlan(sources, regions, overlap, _boxes(regions))


class _Stack:
    """Sources from front to back, each with its footprint and its share of every pixel; ``left`` is nobody's yet."""

    def __init__(self, context: FillContext, absent: frozenset[Source], feather: float) -> None:
        self._context, self._absent, self._feather = context, absent, feather
        front = context.footprint(context.camera, parallax_corrected=True)
        self.sources, self.masks = [Source(context.camera)], [front]
        self.shares = [_alpha(front, feather)]
        self.left = 1 - self.shares[0]

    def add(self, source: Source, least: float) -> bool:
        """Put ``source`` behind the others if it alone fills as much of the frame as ``least``."""
        mask = self._context.footprint(source.camera, source.frame, parallax_corrected=not source.plane_only)
        share = self.left * _alpha(mask, self._feather)
        if source in self._absent or share.mean() < least:
            return False
        self.sources.append(source)
        self.masks.append(mask)
        self.shares.append(share)
        self.left = self.left - share
        return True

    def add_plane_only(self) -> None:
        """Behind all, the pictures that the parallax correction moves away from their edge, uncorrected."""
        for source, mask in tuple(zip(self.sources, self.masks, strict=True)):
            if not np.array_equal(mask, self._context.footprint(source.camera, source.frame)):
                self.add(attrs.evolve(source, plane_only=True), _SPECK)

    def visible_shares(self) -> list[Weight]:
        """The shares, made to fill all that anybody shows; where nobody does, as smooth as the footprints' edges."""
        edge = _weights(np.maximum.reduce(self.masks))
        total = np.maximum(1 - self.left, 1e-4)
        return [np.where(self.left < 0.9999, share / total, 0) * edge for share in self.shares]


def _regions(shares: Sequence[Weight]) -> Iterator[FillRegion]:
    """Rectangles that hold all that is not the front alone, each with the sources that show in it."""
    black = 1 - np.sum(shares, axis=0)
    visible = [share > 1 / 512 for share in (*shares, black)]
    for rect, members in mask_rects(visible):
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


def _layer(source: int, weight: NDArray) -> FillLayer:
    half = np.ascontiguousarray(weight, np.float32)
    full = np.asarray(
        cv2.resize(half, (2 * half.shape[1], 2 * half.shape[0]), interpolation=cv2.INTER_LINEAR), np.float32
    )
    return FillLayer(source, (half, 1 - half), (full, 1 - full))


def _boxes(regions: Sequence[FillRegion]) -> dict[int, Rect]:
    """For each source behind the first the rectangle around its regions, where they fill a third of it.

    Warping 1920x1080 pixels takes as long as 40 regions that together are half as large.
    """
    rects: dict[int, list[Rect]] = {}
    for region in regions:
        for layer in region.layers:
            if layer.source:
                rects.setdefault(layer.source, []).append(region.rect)
    boxes = {}
    for source, own in rects.items():
        x, y = min(r.x for r in own), min(r.y for r in own)
        right, bottom = max(r.x + r.width for r in own), max(r.y + r.height for r in own)
        box = Rect(x, y, right - x, bottom - y)
        if 3 * sum(r.width * r.height for r in own) >= box.width * box.height:
            boxes[source] = box
    return boxes


def mask_rects(
    visible: Sequence[NDArray[np.bool_]], rows: int = _BAND, least: int = _NARROWEST
) -> list[tuple[Rect, tuple[int, ...]]]:
    """Rectangles that together hold all but where the first mask alone is true.

    Parameters
    ----------
    visible : sequence of (h, w) bool
        Masks of one shape, each with half the programme's rows and columns.
    rows : int
        Height of the bands that are cut where the set of masks changes.
    least : int
        Pieces narrower than so many columns go to a neighbour.

    Returns
    -------
    list of (Rect, tuple of int)
        Each rectangle, twice as fine as the masks, and the masks that are true somewhere in it; equal ones above each
        other are one.
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
    """A camera's weight against what is behind it; a trace of it to its very edge, which counts where no other is."""
    return np.maximum(
        _weights(feathered(np.where(mask > 127, 255, 0).astype(np.uint8), feather)), 1e-3 * _weights(mask)
    )


def _weights(alpha: U8) -> Weight:
    return alpha.astype(np.float32) / np.float32(255)


def _by_cell(context: FillContext, mask: NDArray) -> Weight:
    size = (-(-context.size[0] // CELL), -(-context.size[1] // CELL))
    return _weights(np.asarray(cv2.resize(mask, size, interpolation=cv2.INTER_AREA), np.uint8))
