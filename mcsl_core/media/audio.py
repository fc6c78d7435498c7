"""Decoding a file's audio from any time on, its gaps kept where its timestamps have them."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import av
import numpy as np
from av.error import FFmpegError
from numpy.typing import NDArray

from .facts import MediaFacts
from .opening import open_file, time_origin_of, timestamp_of
from .packets import packets_of
from .tracks import AudioTrack, decoder_of

log = logging.getLogger(__name__)


def read_audio(
    facts: MediaFacts, track: AudioTrack, from_s: Fraction, rate: int
) -> Iterator[tuple[Fraction, NDArray[np.float32]]]:
    """Decodes one sound track of a file, its channels as they are.

    Parameters
    ----------
    facts
        The file, as `probe` describes it.
    track
        One of the file's ``audio_tracks`` that can be decoded.
    from_s
        Where to begin, seconds of the file's own time. The first block begins at or before it where there is sound.
    rate
        Samples per second to resample to.

    Yields
    ------
    time_s, samples
        Time of a block's first sample, and (channels, n) float32 in -1..1. Blocks are in order; what lies between the
        end of one and the start of the next is silence. The number of channels may change on the way.

    Notes
    -----
    Begun inside a file, the position is as exact as the file's ticks (half a millisecond in Matroska); after that
    samples are counted, so it does not jitter.
    """
    with open_file(facts.path) as container:
        stream = container.streams.audio[track.position]
        origin, tick = time_origin_of(container), stream.time_base
        if from_s > Fraction(1, 2):
            # The decoder needs some frames before the first that is right: overlapped transforms, bit reservoirs.
            container.seek(int((from_s - Fraction(1, 4) + origin) / tick), stream=stream)
        grace = float(max(3 * tick, Fraction(1, 500)))  # timestamps are rounded; a gap is more than that
        run: _ContinuousAudio | None = None
        for frame in _audio_frames(container, stream, track, facts.path.name):
            stamp, ticks = timestamp_of(frame), frame.time_base
            own_s = None if stamp is None else stamp * float(ticks) - float(origin)
            joins = run is not None and (own_s is None or abs(own_s - run.end_s) <= grace)
            if run is None or not joins or not run.takes(frame):
                if run is not None:
                    yield from run.blocks(None)
                start_s = Fraction(run.end_s) if run is not None and joins else (stamp or 0) * ticks - origin
                run = _ContinuousAudio(start_s, rate)
            yield from run.blocks(frame)
        if run is not None:
            yield from run.blocks(None)


def _audio_frames(container: Any, stream: Any, track: AudioTrack, name: str) -> Iterator[Any]:
    decoder = decoder_of(stream, track)
    damaged = False
    for packet in packets_of(container, stream):
        try:
            frames = decoder.decode(packet)
        except FFmpegError as error:
            if not damaged:
                log.warning("%s: damaged sound is left out (%s)", name, error.strerror)
            damaged = True
            continue
        yield from frames


class _ContinuousAudio:
    """Audio without a gap or another form, resampled; counts samples so that rounded timestamps cannot jitter it.

    Handed out in blocks of half a second: Python's share of a block is ten times the decoding of one AAC frame.
    """

    def __init__(self, start_s: Fraction, rate: int) -> None:
        self.end_s = float(start_s)
        self._start_s, self._rate, self._given, self._taken = start_s, rate, 0, 0
        # Packed: PyAV reads the planes of eight and more channels beyond the end of their list.
        self._resampler = av.AudioResampler(format="flt", rate=rate, frame_size=rate // 2)
        self._form: tuple[Any, ...] | None = None

    def takes(self, frame: Any) -> bool:
        """Whether ``frame`` has the form of those before it."""
        return self._form in (None, _form(frame))

    def blocks(self, frame: Any) -> Iterator[tuple[Fraction, NDArray[np.float32]]]:
        """The blocks that ``frame`` completes; with None what is left at the end."""
        if frame is not None:
            self._form = _form(frame)
            frame.pts = None
            self._taken += frame.samples
            self.end_s = float(self._start_s) + self._taken / frame.sample_rate
        for piece in self._resampler.resample(frame):
            packed = piece.to_ndarray().reshape(piece.samples, -1)
            yield self._start_s + Fraction(self._given, self._rate), np.ascontiguousarray(packed.T, np.float32)
            self._given += piece.samples


def _form(frame: Any) -> tuple[Any, ...]:
    return frame.sample_rate, frame.format.name, frame.layout.name
