"""Exact time: rates are fractions, ranges are half-open [start, stop) frame ranges, frame n stands at n / rate."""

from __future__ import annotations

import re
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from operator import attrgetter, index
from typing import TypeVar

from attrs import field, frozen

from mcsl_core.errors import Fault

T = TypeVar("T")

LEAST_RATE, MOST_RATE = Fraction(1, 100), 1000  # frames per second: a picture each 100 s, a high-speed camera
RATE_PATTERN = r"[0-9]{1,9}(/[0-9]{1,9}|\.[0-9]{1,9})?"

# A float that a program writes has up to 17 decimals, and more where it is small.
TIME_PATTERN = r"([0-9]{1,9}:){0,2}([0-9]{1,15}([.,][0-9]{0,30})?|[.,][0-9]{1,30})"


def parse_rate(text: str) -> Fraction:
    """Frames per second from ``"30000/1001"``, ``"25"`` or ``"29.97"``; ValueError when not a positive rate.

    The usual decimal spellings of NTSC rates (23.976, 29.97, 59.94) become their exact fractions.
    """
    ntsc = {"23.976": 24, "23.98": 24, "29.97": 30, "47.95": 48, "59.94": 60, "119.88": 120}
    text = text.strip()
    try:
        if not re.fullmatch(RATE_PATTERN, text):  # Fraction itself also takes "1e999999999" and never comes back
            raise ValueError(text)
        rate = Fraction(ntsc[text] * 1000, 1001) if text in ntsc else Fraction(text)
    except (ValueError, ZeroDivisionError):
        raise ValueError(f"expected a rate such as '30000/1001' or '25', got {text!r}") from None
    if rate <= 0:
        raise ValueError(f"a rate must be positive, got {text!r}")
    check_rate(rate)
    return rate


def check_rate(rate: Fraction) -> None:
    """`Fault` unless ``rate`` is one that a camera or a programme may have."""
    if not LEAST_RATE <= rate <= MOST_RATE:
        raise Fault(f"a rate must lie in {float(LEAST_RATE):g} to {MOST_RATE} frames/s, got {rate}")


def format_rate(rate: Fraction) -> str:
    """The canonical spelling: lowest terms, ``"25"`` rather than ``"25/1"``."""
    return str(rate)


def parse_time(text: str) -> Fraction:
    """Seconds of ``"1:02:03.5"``, ``"2:30"`` or ``"150"``, also with a decimal comma; ValueError of anything else."""
    if not re.fullmatch(TIME_PATTERN, text.strip()):  # Fraction itself also takes "1e999999999" and never comes back
        raise ValueError(f"{text[:40]!r} is no time")
    seconds = Fraction(0)
    for part in text.replace(",", ".").split(":"):
        seconds = seconds * 60 + Fraction(part.strip())
    return seconds


def format_time(time_s: float | Fraction) -> str:
    """``h:mm:ss.d`` for people."""
    tenths = round(float(time_s) * 10)
    sign, tenths = ("-", -tenths) if tenths < 0 else ("", tenths)
    return f"{sign}{tenths // 36000}:{tenths // 600 % 60:02d}:{tenths // 10 % 60:02d}.{tenths % 10}"


_SPAN = attrgetter("start", "stop")  # sorted by it in a fifth of the time that the ranges themselves take


@frozen(order=True)
class FrameRange:
    """Frames start, start + 1, ..., stop - 1; never empty."""

    start: int = field(converter=index)  # also takes numpy's integers, but no float
    stop: int = field(converter=index)

    def __attrs_post_init__(self) -> None:
        if self.start < 0:
            raise Fault(f"a range starts at 0 or later, got [{self.start}, {self.stop}]")
        if self.stop <= self.start:
            raise Fault(f"a range ends after it starts, got [{self.start}, {self.stop}]")

    def __len__(self) -> int:
        return self.stop - self.start

    def __contains__(self, frame: int) -> bool:
        return self.start <= frame < self.stop

    def __iter__(self) -> Iterator[int]:
        return iter(range(self.start, self.stop))

    def __str__(self) -> str:
        return f"[{self.start}, {self.stop})"

    def intersection(self, other: FrameRange) -> FrameRange | None:
        """The frames in both, or None."""
        start, stop = max(self.start, other.start), min(self.stop, other.stop)
        return FrameRange(start, stop) if start < stop else None


def check_tiles(ranges: Iterable[FrameRange], frames: int, what: str) -> None:
    """`Fault` (a ValueError) unless ``ranges`` cover [0, frames) in order without gap or overlap."""
    at = 0
    for number, piece in enumerate(ranges):
        if piece.start != at:
            fault = "gap" if piece.start > at else "overlap"
            raise Fault(f"{what} must tile [0, {frames}): {fault} at frame {at}, this is {piece}", f".{what}[{number}]")
        at = piece.stop
    if at != frames:
        raise Fault(f"{what} must tile [0, {frames}): they end at frame {at}", f".{what}")


def cut_points(frames: int, ranges: Iterable[FrameRange]) -> list[int]:
    """0, ``frames`` and every range end inside, sorted: between two neighbours no range begins or ends."""
    points = {0, frames}
    for piece in ranges:
        points.update(p for p in (piece.start, piece.stop) if 0 < p < frames)
    return sorted(points)


def ranges_of(frames: Iterable[int]) -> list[FrameRange]:
    """Frames in any order as ranges, in order, those that meet joined."""
    ranges: list[FrameRange] = []
    for frame in sorted(set(frames)):
        if ranges and ranges[-1].stop == frame:
            ranges[-1] = FrameRange(ranges[-1].start, frame + 1)
        else:
            ranges.append(FrameRange(frame, frame + 1))
    return ranges


def joined(pieces: Iterable[FrameRange]) -> list[FrameRange]:
    """The same frames in as few ranges as can be, in order."""
    ranges: list[FrameRange] = []
    for piece in sorted(pieces, key=_SPAN):
        if ranges and piece.start <= ranges[-1].stop:
            ranges[-1] = FrameRange(ranges[-1].start, max(ranges[-1].stop, piece.stop))
        else:
            ranges.append(piece)
    return ranges


def merge_equal(pieces: Sequence[tuple[FrameRange, T]]) -> list[tuple[FrameRange, T]]:
    """Neighbouring pieces with equal values joined into one."""
    merged: list[tuple[FrameRange, T]] = []
    for piece, value in pieces:
        if merged and merged[-1][1] == value and merged[-1][0].stop == piece.start:
            merged[-1] = (FrameRange(merged[-1][0].start, piece.stop), value)
        else:
            merged.append((piece, value))
    return merged


def without(pieces: Iterable[FrameRange], holes: Iterable[FrameRange]) -> tuple[FrameRange, ...]:
    """The frames of ``pieces`` that no hole has, in as few ranges as can be."""
    result: list[FrameRange] = []
    gaps = joined(holes)
    for piece in joined(pieces):
        at = piece.start
        for gap in touching(gaps, piece.start, piece.stop):
            if gap.start > at:
                result.append(FrameRange(at, gap.start))
            at = gap.stop
        if at < piece.stop:
            result.append(FrameRange(at, piece.stop))
    return tuple(result)


def ranges_of_spans(spans: Iterable[tuple[int, int]]) -> tuple[FrameRange, ...]:
    """Spans of frames, which may reach before the programme, as its ranges, joined and in order."""
    found: list[list[int]] = []
    for start, stop in sorted((max(a, 0), b) for a, b in spans if b > max(a, 0)):
        if found and start <= found[-1][1]:
            found[-1][1] = max(found[-1][1], stop)
        else:
            found.append([start, stop])
    return tuple(FrameRange(start, stop) for start, stop in found)


def touching(ordered: Sequence[FrameRange], start: int, stop: int) -> Sequence[FrameRange]:
    """Those of ``ordered`` (ranges in order that do not overlap) that share frames with [start, stop)."""
    first = bisect_right(ordered, start, key=lambda other: other.stop)
    return ordered[first : bisect_left(ordered, stop, key=lambda other: other.start)]
