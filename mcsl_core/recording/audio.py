"""The audio of a camera on the programme clock: mono float32 in -1..1, offset and drift applied by resampling."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cache

import numpy as np
from numpy.typing import NDArray

from mcsl_core.edl import Camera
from mcsl_core.media.audio import read_audio

from .decoder import Part, exact_camera_time
from .sound_track import sound_track

Audio = NDArray[np.float32]
_TAPS, _PHASES = 16, 512


def camera_audio(
    camera: Camera,
    parts: Sequence[Part],
    start_s: float | Fraction,
    stop_s: float | Fraction,
    rate: int,
    block_s: float,
) -> Iterator[Audio]:
    """Mono audio of one camera in consecutive blocks; see `Footage.audio_blocks`.

    Parameters
    ----------
    camera
        Its clock is applied.
    parts
        Its files.
    start_s, stop_s
        Programme time.
    rate
        Samples per second.
    block_s
        Length of a block; the last may be shorter.

    Yields
    ------
    Audio
        (n,), in -1..1.
    """
    first = round(Fraction(start_s) * rate)
    total = round(Fraction(stop_s) * rate) - first
    pace = 1 + camera.clock.drift_ppm * 1e-6
    begin = exact_camera_time(camera, Fraction(first, rate)) * rate
    buffer = _AudioBuffer(parts, int(begin) - _TAPS, rate)
    block = max(1, round(block_s * rate))
    for done in range(0, total, block):
        count = min(block, total - done)
        origin = exact_camera_time(camera, Fraction(first + done, rate)) * rate
        if pace == 1.0:  # whole samples: at most 10 microseconds off at 48 kHz, and not touched at all
            at = round(origin)
            yield buffer.take(at, at + count)
            continue
        whole = origin.numerator // origin.denominator
        position = float(origin - whole) + np.arange(count) * pace
        low = np.floor(position).astype(np.int64)
        phase = np.round((position - low) * _PHASES).astype(np.int64)
        reach = _TAPS // 2
        source = buffer.take(whole - reach + 1, whole + int(low[-1]) + reach + 1)
        windows = np.lib.stride_tricks.sliding_window_view(source, _TAPS)
        yield np.einsum("ij,ij->i", windows[low], _filters()[phase], dtype=np.float32)


class _AudioBuffer:
    """A camera's audio in its own time, sample 0 at time 0; read forward in blocks, silence where there is none."""

    def __init__(self, parts: Sequence[Part], start: int, rate: int) -> None:
        self._blocks = _blocks(parts, start, rate)
        self._waiting: list[tuple[int, Audio]] = []
        self._more = True

    def take(self, start: int, stop: int) -> Audio:
        """Samples [start, stop); ``start`` must not fall below that of the call before."""
        while self._more and (not self._waiting or self._waiting[-1][0] + len(self._waiting[-1][1]) < stop):
            block = next(self._blocks, None)
            if block is None:
                self._more = False
            else:
                self._waiting.append(block)
        self._waiting = [b for b in self._waiting if b[0] + len(b[1]) > start]
        out = np.zeros(stop - start, np.float32)
        for at, block in self._waiting:
            first, last = max(at, start), min(at + len(block), stop)
            if first < last:
                out[first - start : last - start] = block[first - at : last - at]
        return out


def _blocks(parts: Sequence[Part], start: int, rate: int) -> Iterator[tuple[int, Audio]]:
    heard = sound_track([part.facts for part in parts])
    for index, part in enumerate(parts):
        track = heard.of(part.facts)
        if track is None or part.end_s * rate < start:
            continue
        # A file's sound may run on past its last picture; the next file's takes over where that begins.
        end = int(parts[index + 1].begin_s * rate) if index + 1 < len(parts) else None
        from_s = max(Fraction(0), Fraction(start, rate) - part.begin_s)
        for time_s, channels in read_audio(part.facts, track, from_s, rate):
            at, samples = round((part.begin_s + time_s) * rate), heard.mixed(channels)
            if end is not None and at + len(samples) > end:
                samples = samples[: max(0, end - at)]
            if len(samples):
                yield at, samples


@cache
def _filters() -> Audio:
    """(phases + 1, taps): windowed-sinc filters; row p interpolates at p / phases of a sample after tap taps/2 - 1.

    16 taps under a Kaiser window hold 12 kHz to 0.1 dB at 48 kHz; 512 phases put the rounding at -60 dB there.
    """
    at = np.arange(_TAPS) - (_TAPS // 2 - 1)
    x = at[None, :] - np.arange(_PHASES + 1)[:, None] / _PHASES
    edge = np.clip(1 - (x / (_TAPS / 2)) ** 2, 0, None)
    taps = np.sinc(x) * np.i0(6.0 * np.sqrt(edge)) / np.i0(6.0)
    return (taps / taps.sum(axis=1, keepdims=True)).astype(np.float32)
