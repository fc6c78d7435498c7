"""Timecode: what a frame is called, and which frame is meant, at the rates that editors know.

References
----------
SMPTE ST 12-1.
"""

from __future__ import annotations

from fractions import Fraction
from math import ceil

from mcsl_core.errors import UsageError
from mcsl_core.sync.clock_fit import Refusal
from mcsl_core.sync.timecode import DAY_S, Timecode, parse_timecode

MOST_NOMINAL = 240  # frames a second that editors know of


def nominal(rate: Fraction) -> int:
    """The whole number that frames are counted to in a second: 30 at 30000/1001."""
    return ceil(rate)


def is_broadcast(rate: Fraction) -> bool:
    """Whether ``rate`` is a whole number, or 1000/1001 of one as NTSC's are."""
    return nominal(rate) <= MOST_NOMINAL and rate in (nominal(rate), Fraction(nominal(rate) * 1000, 1001))


def is_ntsc(rate: Fraction) -> bool:
    """Whether ``rate`` is 1000/1001 of a whole number."""
    return rate == Fraction(nominal(rate) * 1000, 1001)


def may_drop(rate: Fraction) -> bool:
    """Whether there is drop-frame timecode at ``rate``: at 29.97 and its multiples."""
    return is_ntsc(rate) and nominal(rate) % 30 == 0


def day_s(rate: Fraction, *, drop: bool) -> Fraction:
    """How long timecode takes from one midnight to the next, in seconds."""
    return Timecode(0, nominal(rate), drop).day / rate


def label(count: int, rate: Fraction, *, drop: bool) -> str:
    """What frame ``count`` after midnight is called, ``01:00:00:00``, or ``01:00:00;00`` in drop-frame.

    Examples
    --------
    >>> label(1800, Fraction(30000, 1001), drop=True)
    '00:01:00;02'
    """
    base = nominal(rate)
    if drop:
        dropped = base // 15  # labels left out in every minute but each tenth
        minute, ten = 60 * base - dropped, 600 * base - 9 * dropped
        tens, rest = divmod(count % (144 * ten), ten)
        minutes = 0 if rest < 60 * base else 1 + (rest - 60 * base) // minute
        count = tens * 600 * base + rest + dropped * minutes
    seconds, picture = divmod(count % (DAY_S * base), base)
    return f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}{';' if drop else ':'}{picture:02d}"


def count_of(text: str, rate: Fraction) -> tuple[int, bool]:
    """(frames after midnight, whether drop-frame) of a label; the inverse of `label`.

    Raises
    ------
    UsageError
        Where it is no timecode at ``rate``.
    """
    try:
        code = parse_timecode(text, rate)
    except Refusal as refusal:
        remedy = "Write 01:00:00:00, or 01:00:00;00 for drop-frame at 29.97 and 59.94 frames/s"
        raise UsageError(str(refusal), remedy=remedy) from refusal
    if code.drop and label(code.count, rate, drop=True)[-2:] != text.strip()[-2:]:
        raise UsageError(f"{text} is left out in drop-frame timecode", remedy="Take the label after it")
    return code.count, code.drop
