"""A file's sound from any time on, its holes kept where its timestamps have them."""

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
from .opening import open_file, stamp_of, zero_of

log = logging.getLogger(__name__)


def read_sound(facts: MediaFacts, from_s: Fraction, rate: int) -> Iterator[tuple[Fraction, NDArray[np.float32]]]:
    """(time in seconds, mono float32 samples at ``rate``) of a file's first sound track from about ``from_s`` on.

    The first block begins at or before ``from_s`` where there is sound. Blocks are in order; what lies between the
    end of one and the start of the next is silence. Begun inside a file, the sound lies as exactly as the file's ticks
    (half a millisecond in Matroska); after that samples are counted, so it does not jitter.
    """
    with open_file(facts.path) as container:
        stream = container.streams.audio[0]
        zero, tick = zero_of(container), stream.time_base
        if from_s > Fraction(1, 2):
            # The decoder needs some frames before the first that is right: overlapped transforms, bit reservoirs.
            container.seek(int((from_s - Fraction(1, 4) + zero) / tick), stream=stream)
        grace = float(max(3 * tick, Fraction(1, 500)))  # timestamps are rounded; a hole is more than that
        run: _Run | None = None
        for frame in _sound_frames(container, stream, facts.path.name):
            stamp, ticks = stamp_of(frame), frame.time_base
            if run is None or (stamp is not None and abs(stamp * float(ticks) - float(zero) - run.end_s) > grace):
                if run is not None:
                    yield from run.blocks(None)
                run = _Run((stamp or 0) * ticks - zero, rate)
            yield from run.blocks(frame)
        if run is not None:
            yield from run.blocks(None)


def _sound_frames(container: Any, stream: Any, name: str) -> Iterator[Any]:
    packets = container.demux(stream)
    while True:
        try:
            packet = next(packets, None)
            frames = packet.decode() if packet is not None else []
        except FFmpegError as error:
            log.warning("%s: damaged sound is left out (%s)", name, error.strerror)
            continue
        if packet is None:
            return
        yield from frames


class _Run:
    """A stretch of sound without a hole, resampled; counts samples so that rounded timestamps cannot jitter it.

    Handed out by the half second: Python's share of a block is ten times the decoding of one AAC frame.
    """

    def __init__(self, start_s: Fraction, rate: int) -> None:
        self.end_s = float(start_s)
        self._start_s, self._rate, self._given, self._taken = start_s, rate, 0, 0
        self._resampler = av.AudioResampler(format="flt", layout="mono", rate=rate, frame_size=rate // 2)

    def blocks(self, frame: Any) -> Iterator[tuple[Fraction, NDArray[np.float32]]]:
        """What comes out for ``frame``, or at the end for None."""
        if frame is not None:
            frame.pts = None
            self._taken += frame.samples
            self.end_s = float(self._start_s) + self._taken / frame.sample_rate
        for piece in self._resampler.resample(frame):
            samples = piece.to_ndarray().reshape(-1).astype(np.float32, copy=False)
            yield self._start_s + Fraction(self._given, self._rate), samples
            self._given += piece.samples
