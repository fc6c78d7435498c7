"""What is known about a media file, and the plain arithmetic on its timestamps. Times are Fractions of a second."""

from __future__ import annotations

import hashlib
from fractions import Fraction
from pathlib import Path

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.errors import InputError

_BLOCK = 1 << 20
_COMMON = sorted(
    {Fraction(n) for n in (*range(1, 61), 72, 90, 100, 120, 144, 200, 240)}
    | {Fraction(n * 1000, 1001) for n in (24, 30, 48, 60, 120, 240)}
)


@frozen(kw_only=True)
class MediaFacts:
    """Facts of one media file, from its headers and packets; nothing but its first picture was decoded.

    A file's own time 0 is timestamp 0, except in transport and programme streams (MPEG-TS and the like), whose clocks
    start anywhere: there it is the earliest timestamp of the file. ``start_s`` is the first picture's time on that
    clock and ``end_s`` the end of the last picture as the headers promise it; ``usable_s`` is the end of what is
    really there and smaller in a file cut short (``truncated``).
    """

    path: Path
    size: tuple[int, int]  # displayed width and height: upright, square pixels, even
    coded_size: tuple[int, int]
    rotation: int  # degrees counter-clockwise that a player turns the coded picture: 0, 90, 180, 270
    sample_aspect: Fraction
    rate: Fraction  # nominal frames per second
    frames: int  # counted by the headers; estimated from the duration where they do not count
    zero_s: Fraction  # the video timestamp at which its own time is 0
    start_s: Fraction
    end_s: Fraction
    usable_s: Fraction
    tick_s: Fraction  # the resolution of its timestamps
    variable_rate: bool
    keyframe_interval_s: float  # mean
    codec: str
    pixel_format: str
    audio_rate: int | None  # samples per second; None without sound
    audio_channels: int
    timecode: str | None
    truncated: bool

    @property
    def duration_s(self) -> float:
        """Seconds from time 0 to the end of the last picture."""
        return float(self.end_s)

    @property
    def first_timestamp_s(self) -> float:
        """The first picture's time in seconds; above 0 for a late start."""
        return float(self.start_s)

    @property
    def has_audio(self) -> bool:
        return self.audio_rate is not None

    @property
    def tolerance_s(self) -> Fraction:
        """How much later than a moment a timestamp may lie and still have come.

        Timestamps are rounded to the file's ticks (1 ms in Matroska: 29.97 frames a second lie at 33, 67, 100 ms) and
        offsets are decimal numbers, so exact comparison would drop and double pictures. A quarter of a frame at most.
        """
        return min(max(self.tick_s, Fraction(1, 100_000)), 1 / self.rate / 4)


def displayed_size(coded: tuple[int, int], sample_aspect: Fraction, rotation: int) -> tuple[int, int]:
    """Upright width and height in square pixels, even: the height is kept, the width stretched."""
    width, height = float(coded[0] * sample_aspect), float(coded[1])
    if rotation % 180:
        width, height = height, width
    return max(2, 2 * round(width / 2)), max(2, 2 * round(height / 2))


def nominal_rate(measured: Fraction) -> Fraction:
    """The common rate that ``measured`` is within 0.02 %, which keeps 29.97 and 30 (0.1 %) apart; else itself."""
    nearest = min(_COMMON, key=lambda rate: abs(rate - measured))
    if abs(nearest - measured) <= nearest / 5000:
        return nearest
    return measured.limit_denominator(1001)


def is_variable(times: NDArray[np.float64]) -> bool:
    """Whether rising timestamps (seconds) stray from even spacing by more than half a frame.

    Rounding to ticks strays by less, and so does a slow clock, whose mean rate is used.
    """
    if len(times) < 3 or times[-1] <= times[0]:
        return False
    step = (times[-1] - times[0]) / (len(times) - 1)
    even = times[0] + step * np.arange(len(times))
    return bool(np.abs(times - even).max() > 0.5 * step)


def fingerprint(path: str | Path) -> str:
    """A content key that changes when the file does: its size and the hashes of its head, middle and tail (1 MiB each).

    Takes milliseconds however large the file is. InputError where it cannot be read.
    """
    path = Path(path)
    try:
        size = path.stat().st_size
        digest = hashlib.sha256(str(size).encode())
        with path.open("rb") as stream:
            for start in sorted({0, max(0, (size - _BLOCK) // 2), max(0, size - _BLOCK)}):
                stream.seek(start)
                digest.update(stream.read(_BLOCK))
    except OSError as error:
        raise InputError(
            f"cannot be read ({error.strerror})", where=str(path), remedy="Check the path and its permissions"
        ) from error
    return digest.hexdigest()[:32]
