"""Clocks from what the cameras' microphones heard together.

First coarse, by the loudness of three bands every 10 ms, over twenty minutes or all; then fine, by the
phase of the waveform in short windows over the whole length, through which a line is laid: its height is the offset,
its slope the drift. What is weak or ambiguous (a monitor's beep fits at every second) is refused, not guessed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, signal

from mcsl_core.edl import Clock
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage

from .clock_fit import MOST_DRIFT, Found, Refusal, length_s, robust_line

Floats = NDArray[np.float64]

RATE = 8000  # samples per second: speech and instruments, a sixth of the work of 48 kHz
HOP = 80  # samples: 10 ms of loudness
BANDS_HZ = ((150, 700), (700, 1800), (1800, 3600))
FIRST_LOOK_S = 1200.0
WINDOW_S = 40.0  # coarse
FINE_S = 8.0
CLEAR_PEAK = 7.0  # in deviations: the highest of a million random values is 5
LEAST_LEAD = 1.25  # the best explanation must beat the next by this


def find(footage: Footage, reference: str, wanted: Sequence[str], progress: Progress) -> Found:
    """The clocks of the cameras ``wanted`` against ``reference``, each found by its sound or refused."""
    listener = _Listener(footage)
    found: dict[str, Clock | Refusal] = {}
    progress.stage("Listening to the cameras", len(wanted), "cameras")
    for number, camera in enumerate(wanted):
        try:
            found[camera] = listener.match(reference, camera)
        except Refusal as refusal:
            found[camera] = refusal
        progress.advance(number + 1)
    return found


class _Listener:
    """The cameras' sounds, each on its own clock; loudness is worked out once."""

    def __init__(self, footage: Footage) -> None:
        self._footage = footage
        self._loudness: dict[tuple[str, float], Floats] = {}
        self._windows: dict[tuple[str, float], NDArray[np.float32]] = {}

    def hears(self, camera: str) -> bool:
        return any(part.facts.has_audio for part in self._footage.parts(camera))

    def length_s(self, camera: str) -> float:
        return length_s(self._footage, camera)

    def loudness(self, camera: str, limit_s: float) -> Floats:
        """(3, n) of the first ``limit_s`` seconds, see `loudness_of`."""
        key = (camera, min(limit_s, self.length_s(camera)))
        if key not in self._loudness:
            self._loudness[key] = loudness_of(self._footage.audio_blocks(camera, 0.0, key[1], RATE))
        return self._loudness[key]

    def match(self, reference: str, camera: str) -> Clock:
        """The clock of ``camera`` against ``reference``; Refusal where it is not certain."""
        for name in (reference, camera):
            if not self.hears(name):
                raise Refusal(f"{name} has no sound")
        longest = max(self.length_s(reference), self.length_s(camera))
        try:
            lag, lead = coarse_lag(self.loudness(reference, FIRST_LOOK_S), self.loudness(camera, FIRST_LOOK_S))
        except Refusal:
            if longest <= FIRST_LOOK_S:
                raise
            lag, lead = coarse_lag(self.loudness(reference, longest), self.loudness(camera, longest))
        clock, agreeing = self._refine(reference, camera, Clock(offset_s=lag))
        confidence = min(1.0, agreeing * min(1.0, lead / 2))
        return attrs.evolve(clock, method="audio", confidence=round(confidence, 3))

    def _refine(self, reference: str, camera: str, clock: Clock) -> tuple[Clock, float]:
        """(clock, share of the windows that agree): the line through the windows' lags, three times over.

        Each time the sound is read through the clock found before, so that in the end nothing is smeared by drift. The
        first search is as wide as drift may have led astray, the last 20 ms.
        """
        overlap_start = max(0.0, clock.offset_s)
        overlap_stop = min(self.length_s(reference), clock.offset_s + self.length_s(camera))
        span = overlap_stop - overlap_start
        if span < 3 * FINE_S:
            raise Refusal(f"they have only {max(0.0, span):.0f} s of sound in common")
        count = int(np.clip(span / FINE_S / 1.5, 3, 20))
        starts = np.linspace(overlap_start, overlap_stop - FINE_S, count)
        middle = (overlap_start + min(overlap_stop, overlap_start + FIRST_LOOK_S)) / 2
        share = 0.0
        for reach_s in (0.1, 0.05, 0.02):
            through = attrs.evolve(self._footage.camera(camera), clock=clock)
            pair = [self._footage.camera(reference), through]
            both = Footage(pair, rate=Fraction(1), frames=1, base=self._footage.base)
            found: list[tuple[float, float]] = []
            heard = 0
            # From where the coarse lag was found outward: each window starts from the line through those before it.
            for start in sorted(starts, key=lambda s: abs(s - middle)):
                expected = _along(found, start) if reach_s == 0.1 else 0.0
                lag = self._window_lag(both, reference, camera, float(start), expected, reach_s)
                if lag is not None:
                    heard += 1
                    if not np.isnan(lag):
                        found.append((float(start) + FINE_S / 2, lag))
            if heard == 0:
                raise Refusal("they are silent where they overlap")
            level, slope, share = robust_line(found, heard, 2e-3)
            clock = Clock(
                offset_s=(clock.offset_s - level) / (1 + slope),
                drift_ppm=((1 + slope) * (1 + clock.drift_ppm * 1e-6) - 1) * 1e6,
            )
        return clock, share

    def _window_lag(
        self, both: Footage, reference: str, camera: str, start: float, expected: float, reach_s: float
    ) -> float | None:
        """Seconds by which ``camera`` is late at programme time ``start``; NaN if unclear, None without sound."""
        a = self._windows.get((reference, start))
        if a is None:
            a = self._windows[reference, start] = both.audio(reference, start, start + FINE_S, RATE)
        b = both.audio(camera, start + expected, start + expected + FINE_S, RATE)
        if min(a.std(), b.std()) < 1e-5:
            return None
        lag, height = phase_lag(a, b, reach_s)
        return expected + lag if height >= CLEAR_PEAK else float("nan")


def _along(found: Sequence[tuple[float, float]], start: float) -> float:
    """The lag to expect at ``start`` from the lags found so far."""
    if not found:
        return 0.0
    at = start + FINE_S / 2
    nearest = sorted(found, key=lambda f: abs(f[0] - at))[:3]
    return float(np.median([lag for _, lag in nearest]))


def loudness_of(blocks: Iterable[NDArray]) -> Floats:
    """(3, n): log energy of three bands every 10 ms, less its mean over two seconds; 0 where there is no sound."""
    filters: list[Any] = [signal.butter(4, band, "bandpass", fs=RATE, output="sos") for band in BANDS_HZ]
    states = [np.zeros((len(sos), 2)) for sos in filters]
    rows: list[Floats] = []
    left: Floats = np.zeros(0)
    for block in blocks:
        joined = np.concatenate([left, np.asarray(block, np.float64)])
        whole = len(joined) // HOP * HOP
        sound, left = joined[:whole], joined[whole:]
        energies = []
        for index, sos in enumerate(filters):
            filtered: Any = signal.sosfilt(sos, sound, zi=states[index])
            states[index] = filtered[1]
            energies.append((filtered[0].reshape(-1, HOP) ** 2).mean(axis=1))
        rows.append(np.array(energies))
    if not rows:
        return np.zeros((len(BANDS_HZ), 0))
    energy = np.concatenate(rows, axis=1)
    floor = max(1e-10, float(np.median(energy)) * 1e-2)
    level = np.log(energy + floor)
    smooth = ndimage.uniform_filter1d(level, 200, axis=1, mode="nearest")
    return np.clip(level - smooth, -3, 3)


def coarse_lag(reference: Floats, other: Floats) -> tuple[float, float]:
    """(programme time in s at which ``other`` begins, lead over the next-best answer) from two loudness tracks.

    Windows of ``reference`` are looked up in all of ``other``; each offers its five best places. The answer is what
    most of them agree on within 0.1 s, allowing for drift. Refusal where that is too little or nearly as much agree
    on something else.
    """
    size = int(WINDOW_S * RATE / HOP)
    length = reference.shape[1]
    size = min(size, max(300, length // 3))
    if min(length, other.shape[1]) < 300:
        raise Refusal("their sound is shorter than 3 s")
    if min(reference.std(), other.std()) < 1e-3:
        raise Refusal("one of them is silent")
    starts = np.unique(
        np.linspace(0, max(0, length - size), min(24, 1 + 2 * max(0, length - size) // size)).astype(int)
    )
    offers: list[tuple[float, float, float]] = []  # window's middle in s, lag in s, height in deviations
    hop_s = HOP / RATE
    for start in starts:
        window = reference[:, start : start + size]
        if window.std() < 1e-3:
            continue
        for lag, height in _places(window, other):
            offers.append(((start + size / 2) * hop_s, (start - lag) * hop_s, height))
    if not offers:
        raise Refusal("one of them is silent")
    table = np.array(offers)
    scores = np.array([_support(table, row) for row in table])
    best = int(scores.argmax())
    if scores[best] < CLEAR_PEAK:
        raise Refusal("nothing in their sound fits together")
    rivals = scores[np.abs(table[:, 1] - table[best, 1]) > 0.3 + MOST_DRIFT * length * hop_s]
    lead = float(scores[best] / rivals.max()) if len(rivals) and rivals.max() > 0 else 10.0
    if lead < LEAST_LEAD:
        raise Refusal("their sound fits together in several ways")
    return float(table[best, 1]), lead


def _places(window: Floats, other: Floats) -> list[tuple[int, float]]:
    """The five best places (index into ``other`` where the window begins, may be negative) and their heights."""
    total = sum(signal.correlate(o, w, "full", method="fft") for w, o in zip(window, other, strict=True))
    size = window.shape[1]
    power = np.convolve((other**2).sum(axis=0), np.ones(size), "full")
    # A place where little of the window overlaps must not win by chance.
    like = total / np.sqrt(np.maximum(power, 0.25 * power.max()) * (window**2).sum() + 1e-9)
    spread = 1.4826 * float(np.median(np.abs(like - np.median(like)))) + 1e-9
    found = []
    like = like - np.median(like)
    for _ in range(5):
        at = int(like.argmax())
        found.append((at - size + 1, float(like[at] / spread)))
        like[max(0, at - 25) : at + 26] = -np.inf
    return found


def _support(table: Floats, row: Floats) -> float:
    """How much all windows together speak for ``row``'s lag: the root of the summed squares of one vote a window."""
    allowed = 0.1 + MOST_DRIFT * np.abs(table[:, 0] - row[0])
    near = np.abs(table[:, 1] - row[1]) <= allowed
    votes = {}
    for middle, _, height in table[near & (table[:, 2] > 3.5)]:
        votes[middle] = max(votes.get(middle, 0.0), height)
    return float(np.sqrt(sum(v * v for v in votes.values())))


def phase_lag(reference: NDArray, other: NDArray, reach_s: float) -> tuple[float, float]:
    """(seconds by which ``other`` is late, height of that peak in deviations), from equally long sounds at 8 kHz.

    Generalised cross-correlation with phase transform: every frequency of speech has one vote, so a loud hum cannot
    decide. Between samples by a parabola.
    """
    size = 2 * len(reference)
    taper = np.hanning(len(reference))
    cross = np.conj(np.fft.rfft(reference * taper, size)) * np.fft.rfft(other * taper, size)
    hertz = np.fft.rfftfreq(size, 1 / RATE)
    band = (hertz >= BANDS_HZ[0][0]) & (hertz <= BANDS_HZ[-1][1])
    phases = np.where(band, cross / (np.abs(cross) + 1e-12), 0)
    peaks = np.roll(np.fft.irfft(phases, size), size // 2)
    middle, reach = size // 2, int(reach_s * RATE)
    near = peaks[middle - reach : middle + reach + 1]
    at = int(near.argmax())
    spread = float(peaks.std()) + 1e-12
    shift = 0.0
    if 0 < at < len(near) - 1:
        left, top, right = near[at - 1 : at + 2]
        shift = 0.5 * (left - right) / (left - 2 * top + right)
    return (at - reach + float(shift)) / RATE, float(near[at] / spread)
