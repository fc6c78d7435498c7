"""A programme in pieces, each with what was laid over it last; several such beside each other."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import TypeVar

from mcsl_core.timing import FrameRange, cut_points, merge_equal

T = TypeVar("T")
Painted = list[tuple[FrameRange, T | None]]


def paint(frames: int, laid: Iterable[tuple[FrameRange, T]]) -> Painted[T]:
    """[0, frames) in pieces, each with the last that was laid over it, or None."""
    laid = list(laid)
    points = cut_points(frames, [piece for piece, _ in laid])
    index = {point: n for n, point in enumerate(points)}
    values: list[T | None] = [None] * (len(points) - 1)
    for piece, value in laid:
        first, last = min(piece.start, frames), min(piece.stop, frames)
        for n in range(index[first], index[last]):
            values[n] = value
    return merge_equal(list(zip(_pieces(points), values, strict=True)))


def beside(frames: int, *painted: Sequence[tuple[FrameRange, T]]) -> Iterator[tuple[FrameRange, tuple[T, ...]]]:
    """The pieces of [0, frames) in which nothing changes in any of what is painted, and the value of each there."""
    points = cut_points(frames, [piece for one in painted for piece, _ in one])
    return zip(_pieces(points), zip(*(_each(one, points) for one in painted), strict=True), strict=True)


def _pieces(points: Sequence[int]) -> list[FrameRange]:
    return [FrameRange(a, b) for a, b in pairwise(points)]


def _each(painted: Sequence[tuple[FrameRange, T]], points: Sequence[int]) -> Iterator[T]:
    """The value in each of the pieces between ``points``, which hold all ends of what is painted."""
    pieces = iter(painted)
    span, value = next(pieces)
    for start in points[:-1]:
        while start >= span.stop:
            span, value = next(pieces)
        yield value
