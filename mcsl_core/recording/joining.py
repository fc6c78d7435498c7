"""How a camera's files join: by their clock where it goes on from file to file, else each begins where the last ended.

Splitters and recorders that cut a running recording into parts keep one clock (MPEG-TS always, FFmpeg's segments,
many cameras): its timestamps say exactly how parts join, real gaps and overlaps as well. A clock that begins anew says
nothing; then a part's first picture follows the last of the part before, wherever sound leads in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from mcsl_core.media.facts import MediaFacts
from mcsl_core.timing import format_time

from .decoder import Part

_WRAP_S = Fraction(1 << 33, 90_000)  # MPEG's clock has 33 bits: 26.5 hours
_WRAPPING = Fraction(1, 90_000)  # its tick
_LONGEST_PAUSE_S = 3600  # a clock that is further on is another clock: recorders that start one anywhere exist
_LONGEST_LEAD_S = 1  # sound that leads by more is no lead: the picture starts late
_TOLD_S = Fraction(1, 2)  # gaps and overlaps from here on are told


def joined(files: Sequence[MediaFacts]) -> tuple[Part, ...]:
    """The files of a camera in order, and where each begins in the camera's own time."""
    if not files:
        return ()
    goes_on = [_clock_ahead(before, after) for before, after in zip(files, files[1:], strict=False)]
    first = files[0]
    # A clock that goes on may have begun before the first part: the camera's own time is 0 at its first picture.
    late = first.zero_s == 0 and first.start_s > 2 / first.rate and any(ahead is not None for ahead in goes_on)
    parts = [Part(first, -first.start_s if late else Fraction(0))]
    for facts, ahead in zip(files[1:], goes_on, strict=True):
        before = parts[-1]
        if ahead is not None:
            begin = before.begin_s + ahead
        else:
            leads = facts.has_audio and 0 < facts.start_s <= _LONGEST_LEAD_S
            begin = before.end_s - (facts.start_s if leads else 0)
        parts.append(Part(facts, begin))
    return tuple(parts)


def _clock_ahead(before: MediaFacts, after: MediaFacts) -> Fraction | None:
    """By how much the file's own time 0 of ``after`` is ahead of ``before``'s on a clock that both share, else None."""
    ahead = after.zero_s - before.zero_s
    if ahead < 0 and after.tick_s == before.tick_s == _WRAPPING:
        ahead += _WRAP_S
    frame = 1 / min(before.rate, after.rate)
    pause = ahead + after.start_s - before.end_s
    length = before.end_s - before.start_s
    # An overlap is less than half of what it overlaps, or the clock did not go on but began anew.
    if -length / 2 < pause <= max(2 * frame, _LONGEST_PAUSE_S) and ahead + after.start_s > before.start_s + frame:
        return ahead
    return None


def describe_joins(camera: str, parts: Sequence[Part]) -> list[str]:
    """What a person should know of how the files of ``camera`` join: pauses and overlaps, in words."""
    notes = []
    for before, after in zip(parts, parts[1:], strict=False):
        pause = after.begin_s + after.facts.start_s - before.end_s
        names = f"{before.facts.path.name} and {after.facts.path.name}"
        if pause >= _TOLD_S:
            at = format_time(before.end_s)
            notes.append(f"{camera}: no picture for {float(pause):.1f} s from {at} on, between {names}")
        elif pause <= -_TOLD_S:
            notes.append(f"{camera}: {names} overlap by {-float(pause):.1f} s; the later one is shown")
    return notes
