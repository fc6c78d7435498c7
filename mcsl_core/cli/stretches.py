"""Stretches of the programme as people write them: times on the clock, or frames."""

from __future__ import annotations

from fractions import Fraction
from math import ceil

from mcsl_core.edl import Edl
from mcsl_core.errors import Fault, UsageError
from mcsl_core.timing import FrameRange, format_time, parse_time


def stretch(edl: Edl, start: str | None, stop: str | None) -> FrameRange | None:
    """The frames from the time ``start`` to the time ``stop``; None where neither is given.

    Raises
    ------
    UsageError
        Where one is no time, or no frame lies between.
    """
    if start is None and stop is None:
        return None
    first = 0 if start is None else ceil(seconds_of(start) * edl.rate)
    last = edl.frames if stop is None else min(edl.frames, ceil(seconds_of(stop) * edl.rate))
    try:
        return FrameRange(first, last)
    except Fault:
        length = format_time(edl.frames / edl.rate)
        raise UsageError(
            f"from {start or '0'} to {stop or 'the end'} there is no frame",
            remedy=f"The programme lasts {length}; give --from before --to",
        ) from None


def frames_of(edl: Edl, text: str) -> FrameRange:
    """The frames ``A:B``, from A up to but without B; without A from the first, without B to the last.

    Raises
    ------
    UsageError
        Where it is written otherwise, or is not in the programme.
    """
    first, colon, last = text.partition(":")
    try:
        if not colon:
            raise ValueError(text)
        piece = FrameRange(int(first or 0), int(last or edl.frames))
    except (ValueError, Fault):
        raise UsageError(f"--range {text!r} is no range of frames", remedy="Write --range 900:1800") from None
    if piece.stop > edl.frames:
        raise UsageError(f"--range {text} is not in the programme", remedy=f"Its frames are 0:{edl.frames}")
    return piece


def seconds_of(text: str) -> Fraction:
    """Seconds of ``h:mm:ss.d``, ``m:ss`` or plain seconds; UsageError where it is no time."""
    try:
        return parse_time(text)
    except ValueError as error:
        raise UsageError(str(error), remedy="Write 1:02:03.5, 2:30 or seconds") from None


def piece_of(edl: Edl, frames: str | None, start: str | None, stop: str | None) -> FrameRange | None:
    """What --range, or --from and --to, name; None where nothing is. UsageError where both are given, or wrong."""
    if frames is None:
        return stretch(edl, start, stop)
    if start is not None or stop is not None:
        raise UsageError("--range is given in frames, --from and --to in times", remedy="Give one or the other")
    return frames_of(edl, frames)
