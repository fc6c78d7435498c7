"""What is known about a media file, and the plain arithmetic on its timestamps. Times are Fractions of a second."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Literal

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from .tracks import AudioTrack

Scan = Literal["unflagged", "flagged", "progressive", "top", "bottom"]
"""Which frames are interlaced: none, as far as is known, or those that say so; none, whatever they say; all, the top or
the bottom field first."""

_COMMON = sorted(
    {Fraction(n) for n in (*range(1, 61), 72, 90, 100, 120, 144, 200, 240)}
    | {Fraction(n * 1000, 1001) for n in (24, 30, 48, 60, 120, 240)}
)


@frozen(kw_only=True)
class MediaFacts:
    """Facts of one media file, from its headers and packets; nothing but its first picture was decoded.

    Attributes
    ----------
    path
        The file.
    size
        Displayed (width, height): upright, square pixels, even.
    coded_size
        (width, height) as coded.
    rotation
        Degrees counter-clockwise by which the coded picture is turned for display: 0, 90, 180, 270.
    sample_aspect
        Width over height of a coded pixel.
    rate
        Nominal frames per second.
    frames
        As many as the headers count; estimated from the duration where they do not count.
    zero_s
        The video timestamp at which the file's own time is 0, see Notes.
    start_s
        The first picture's own time; above 0 for a late start.
    end_s
        The end of the last picture as the headers promise it.
    usable_s
        The end of what is really there; before ``end_s`` in a file cut short.
    tick_s
        Resolution of the timestamps.
    variable_rate
        Whether timestamps stray from even spacing.
    keyframe_interval_s
        Mean time from one keyframe to the next.
    codec, pixel_format
        FFmpeg's names.
    audio_tracks
        The sound tracks in the file's order, with those that cannot be decoded.
    timecode
        SMPTE start timecode as the file writes it; None without.
    truncated
        Whether the file was cut short.
    decoding_order
        Whether its timestamps are in the order of decoding though pictures are shown in another (H.264 in AVI): then
        the n-th picture shown has the n-th smallest of them.
    created
        When it was made as its header says, often when it was closed; empty where it does not say.
    scan
        Which of its frames are interlaced.
    mirrored
        Whether the coded picture is mirrored, left to right, before it is turned.
    colour
        What its colours are where they have to be converted to BT.709, such as "hlg"; else empty.
    stream_aspect
        As ``sample_aspect``, but as the stream itself has it at its first picture; None where it does not say.
    asked_size
        (width, height) of the coded picture that the container asks players to show; None for all of it. It is shown
        whole.
    strict
        Whether a decoder that refuses what breaks its codec's rules takes its first pictures (`decoders`).

    Notes
    -----
    A file's own time 0 is timestamp 0, except where the clock starts anywhere: in transport and programme streams
    (MPEG-TS and the like), in files that begin later than 10 s, and where all streams were shifted by two pictures at
    most, which muxers do for reordered ones. There it is the earliest timestamp of the file.
    """

    path: Path
    size: tuple[int, int]
    coded_size: tuple[int, int]
    rotation: int
    sample_aspect: Fraction
    rate: Fraction
    frames: int
    zero_s: Fraction
    start_s: Fraction
    end_s: Fraction
    usable_s: Fraction
    tick_s: Fraction
    variable_rate: bool
    keyframe_interval_s: float
    codec: str
    pixel_format: str
    audio_tracks: tuple[AudioTrack, ...]
    timecode: str | None
    truncated: bool
    decoding_order: bool = False
    created: str = ""
    scan: Scan = "unflagged"
    mirrored: bool = False
    colour: str = ""
    stream_aspect: Fraction | None = None
    asked_size: tuple[int, int] | None = None
    strict: bool = True

    @property
    def duration_s(self) -> float:
        """Seconds from time 0 to the end of the last picture."""
        return float(self.end_s)

    @property
    def has_audio(self) -> bool:
        """Whether there is an audio track that can be decoded."""
        return any(track.can_be_decoded for track in self.audio_tracks)

    @property
    def conversions(self) -> tuple[str, ...]:
        """What is done to its pictures, beside what is done to all: they are others than without."""
        interlaced = self.scan in ("flagged", "top", "bottom")
        done = {f"deinterlaced {self.scan}": interlaced, "mirrored": self.mirrored, self.colour: bool(self.colour)}
        return tuple(name for name, applies in done.items() if applies)

    @property
    def tolerance_s(self) -> Fraction:
        """How much later than a given time a timestamp may lie and still count as reached.

        Timestamps are rounded to the file's ticks (1 ms in Matroska: 29.97 frames a second lie at 33, 67, 100 ms) and
        offsets are decimal numbers, so exact comparison would drop and double pictures. A quarter of a frame at most.
        """
        return min(max(self.tick_s, Fraction(1, 100_000)), 1 / self.rate / 4)


def displayed_size(coded: tuple[int, int], sample_aspect: Fraction, rotation: int) -> tuple[int, int]:
    """Upright (width, height) in square pixels, even.

    Parameters
    ----------
    coded
        (width, height) as coded; the height is kept.
    sample_aspect
        Width over height of a coded pixel.
    rotation
        Degrees, a multiple of 90.
    """
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
    """Whether timestamps stray from even spacing by more than half a frame.

    Parameters
    ----------
    times
        (N,) seconds, rising.

    Notes
    -----
    Rounding to ticks strays by less, and so does a slow clock, whose mean rate is used.
    """
    if len(times) < 3 or times[-1] <= times[0]:
        return False
    step = (times[-1] - times[0]) / (len(times) - 1)
    even = times[0] + step * np.arange(len(times))
    return bool(np.abs(times - even).max() > 0.5 * step)
