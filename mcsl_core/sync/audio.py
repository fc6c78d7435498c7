"""Clocks from audio: cross-correlation of what the cameras' microphones heard together.

First coarse, by the loudness of three bands every 10 ms, over twenty minutes or all; then fine, by generalised
cross-correlation with phase transform (GCC-PHAT) in short windows over the whole length. A line is fitted to the lags
of the windows: its level is the offset, its slope the drift. What is weak or ambiguous (a monitor's beep fits at every
second) is refused, not guessed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any

import attrs
import numpy as np
import scipy
from numpy.typing import NDArray

from mcsl_core.edl import Clock
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage

from .clock_fit import MAX_DRIFT, ClockResults, Refusal, length_s, robust_line

Array = NDArray[np.float64]

RATE = 8000  # samples per second: speech and instruments, a sixth of the work of 48 kHz
HOP = 80  # samples: 10 ms of loudness
BANDS_HZ = ((150, 700), (700, 1800), (1800, 3600))
COARSE_SPAN_S = 1200.0  # the coarse lag is searched in so much first, then in all
COARSE_WINDOW_S = 40.0
FINE_WINDOW_S = 8.0
LEAST_WINDOW_S = 3.0
CLEAR_PEAK = 7.0  # in standard deviations: the highest of a million random values is 5
LEAST_LEAD = 1.25  # the best lag's support over that of the next-best


def clocks_from_audio(footage: Footage, reference: str, wanted: Sequence[str], progress: Progress) -> ClockResults:
    """The clocks of the cameras ``wanted`` against ``reference``, each found by its audio or refused.

    Parameters
    ----------
    footage
        The cameras with default clocks.
    reference
        The camera whose clock is the programme's.
    wanted
        The cameras to be found.
    progress
        Told of each camera.

    Returns
    -------
    ClockResults
        Camera -> its clock, or why there is none.
    """
    matcher = _AudioMatcher(footage)
    found: dict[str, Clock | Refusal] = {}
    progress.stage("Listening to the cameras", len(wanted), "cameras")
    for done, camera in enumerate(wanted, 1):
        try:
            found[camera] = matcher.match(reference, camera)
        except Refusal as refusal:
            found[camera] = refusal
        progress.advance(done)
    return found


class _AudioMatcher:
    """The cameras' audio, each on its own clock; loudness is worked out once."""

    def __init__(self, footage: Footage) -> None:
        self._footage = footage
        self._loudness: dict[tuple[str, float], Array] = {}
        self._windows: dict[tuple[str, float, float], NDArray[np.float32]] = {}

    def loudness(self, camera: str, limit_s: float) -> Array:
        """(3, n): `band_loudness` of the first ``limit_s`` seconds."""
        key = (camera, min(limit_s, length_s(self._footage, camera)))
        if key not in self._loudness:
            self._loudness[key] = band_loudness(self._footage.audio_blocks(camera, 0.0, key[1], RATE))
        return self._loudness[key]

    def match(self, reference: str, camera: str) -> Clock:
        """The clock of ``camera`` against ``reference``; Refusal where it is not certain."""
        for name in (reference, camera):
            if not self._footage.has_sound(name):
                raise Refusal(f"{name} has no sound")
        longest = max(length_s(self._footage, reference), length_s(self._footage, camera))
        try:
            lag, lead = coarse_lag(self.loudness(reference, COARSE_SPAN_S), self.loudness(camera, COARSE_SPAN_S))
        except Refusal:
            if longest <= COARSE_SPAN_S:
                raise
            lag, lead = coarse_lag(self.loudness(reference, longest), self.loudness(camera, longest))
        clock, share = self._refine(reference, camera, Clock(offset_s=lag))
        confidence = min(1.0, share * min(1.0, lead / 2))
        return attrs.evolve(clock, method="audio", confidence=round(confidence, 3))

    def _refine(self, reference: str, camera: str, clock: Clock) -> tuple[Clock, float]:
        """(clock, share of the windows that agree): a line fitted to the windows' lags, three times over.

        Each time the audio is read through the clock found before, so that in the end drift smears no window. The first
        search is as wide as drift may have led astray, the last 20 ms.
        """
        overlap_start = max(0.0, clock.offset_s)
        overlap_stop = min(length_s(self._footage, reference), clock.offset_s + length_s(self._footage, camera))
        span = overlap_stop - overlap_start
        # Of long recordings so much at least, of short ones half: two of 24 s begin some tenths apart.
        shorter = min(length_s(self._footage, reference), length_s(self._footage, camera))
        if span < min(3 * FINE_WINDOW_S, max(3 * LEAST_WINDOW_S, shorter / 2)):
            raise Refusal(f"they have only {max(0.0, span):.0f} s of sound in common")
        window_s = min(FINE_WINDOW_S, int(10 * span / 3) / 10)  # whole samples
        count = int(np.clip(span / FINE_WINDOW_S / 1.5, 3, 20))
        starts = np.linspace(overlap_start, overlap_stop - window_s, count)
        middle = (overlap_start + min(overlap_stop, overlap_start + COARSE_SPAN_S)) / 2
        share = 0.0
        for reach_s in (0.1, 0.05, 0.02):
            through = attrs.evolve(self._footage.camera(camera), clock=clock)
            pair = [self._footage.camera(reference), through]
            both = Footage(pair, rate=Fraction(1), frames=1, base=self._footage.base)
            found: list[tuple[float, float]] = []
            heard = 0
            # From where the coarse lag was found outward: each window is searched about the lags found before it.
            for start in sorted(starts, key=lambda s: abs(s - middle)):
                expected = _expected_lag(found, start + window_s / 2) if reach_s == 0.1 else 0.0
                within = (float(start), float(start) + window_s)
                lag = self._window_lag(both, reference, camera, within, expected, reach_s)
                if lag is not None:
                    heard += 1
                    if not np.isnan(lag):
                        found.append((float(start) + window_s / 2, lag))
            if heard == 0:
                raise Refusal("they are silent where they overlap")
            level, slope, share = robust_line(found, heard, 2e-3)
            clock = Clock(
                offset_s=(clock.offset_s - level) / (1 + slope),
                drift_ppm=((1 + slope) * (1 + clock.drift_ppm * 1e-6) - 1) * 1e6,
            )
        return clock, share

    def _window_lag(
        self, both: Footage, reference: str, camera: str, within: tuple[float, float], expected: float, reach_s: float
    ) -> float | None:
        """Seconds by which ``camera`` is late in a window of programme time; NaN if unclear, None without sound."""
        start, stop = within
        a = self._windows.get((reference, start, stop))
        if a is None:
            a = self._windows[reference, start, stop] = both.audio(reference, start, stop, RATE)
        b = both.audio(camera, start + expected, stop + expected, RATE)
        if min(a.std(), b.std()) < 1e-5:
            return None
        lag, height = gcc_phat_lag(a, b, reach_s)
        return expected + lag if height >= CLEAR_PEAK else float("nan")


def _expected_lag(found: Sequence[tuple[float, float]], at: float) -> float:
    """The lag to expect in the window about ``at``: the median of the three nearest found so far."""
    if not found:
        return 0.0
    nearest = sorted(found, key=lambda f: abs(f[0] - at))[:3]
    return float(np.median([lag for _, lag in nearest]))


def band_loudness(blocks: Iterable[NDArray]) -> Array:
    """Log energy of three bands every 10 ms, less its moving average over two seconds.

    Parameters
    ----------
    blocks
        Consecutive (n,) blocks of audio at `RATE`.

    Returns
    -------
    Array
        (3, n), natural logarithms clipped to -3..3; 0 where there is no sound.
    """
    filters: list[Any] = [scipy.signal.butter(4, band, "bandpass", fs=RATE, output="sos") for band in BANDS_HZ]
    states = [np.zeros((len(sos), 2)) for sos in filters]
    rows: list[Array] = []
    left: Array = np.zeros(0)
    for block in blocks:
        joined = np.concatenate([left, np.asarray(block, np.float64)])
        whole = len(joined) // HOP * HOP
        sound, left = joined[:whole], joined[whole:]
        if not whole:  # a last block of under 10 ms
            continue
        energies = []
        for index, sos in enumerate(filters):
            filtered: Any = scipy.signal.sosfilt(sos, sound, zi=states[index])
            states[index] = filtered[1]
            energies.append((filtered[0].reshape(-1, HOP) ** 2).mean(axis=1))
        rows.append(np.array(energies))
    if not rows:
        return np.zeros((len(BANDS_HZ), 0))
    energy = np.concatenate(rows, axis=1)
    floor = max(1e-10, float(np.median(energy)) * 1e-2)
    level = np.log(energy + floor)
    smooth = scipy.ndimage.uniform_filter1d(level, 200, axis=1, mode="nearest")
    return np.clip(level - smooth, -3, 3)


def coarse_lag(reference: Array, other: Array) -> tuple[float, float]:
    """The lag between two loudness tracks, by voting.

    Parameters
    ----------
    reference, other
        (3, n), as `band_loudness` makes them.

    Returns
    -------
    lag_s, lead
        Programme time at which ``other`` begins, and its support over that of the next-best lag.

    Raises
    ------
    Refusal
        Where the support is too small, or nearly as much supports another lag.

    Notes
    -----
    Windows of ``reference`` are cross-correlated with all of ``other``; each has its five best lags as candidates. The
    answer is the lag that most of them agree on within 0.1 s, allowing for drift.
    """
    size = int(COARSE_WINDOW_S * RATE / HOP)
    length = reference.shape[1]
    size = min(size, max(300, length // 3))
    if min(length, other.shape[1]) < 300:
        raise Refusal("their sound is shorter than 3 s")
    if min(reference.std(), other.std()) < 1e-3:
        raise Refusal("one of them is silent")
    starts = np.unique(
        np.linspace(0, max(0, length - size), min(24, 1 + 2 * max(0, length - size) // size)).astype(int)
    )
    candidates: list[tuple[float, float, float]] = []  # window's middle in s, lag in s, height in deviations
    hop_s = HOP / RATE
    for start in starts:
        window = reference[:, start : start + size]
        if window.std() < 1e-3:
            continue
        for lag, height in _candidate_lags(window, other):
            candidates.append(((start + size / 2) * hop_s, (start - lag) * hop_s, height))
    if not candidates:
        raise Refusal("one of them is silent")
    table = np.array(candidates)
    scores = np.array([_support(table, row) for row in table])
    best = int(scores.argmax())
    if scores[best] < CLEAR_PEAK:
        raise Refusal("nothing in their sound fits together")
    rivals = scores[np.abs(table[:, 1] - table[best, 1]) > 0.3 + MAX_DRIFT * length * hop_s]
    lead = float(scores[best] / rivals.max()) if len(rivals) and rivals.max() > 0 else 10.0
    if lead < LEAST_LEAD:
        raise Refusal("their sound fits together in several ways")
    return float(table[best, 1]), lead


def _candidate_lags(window: Array, other: Array) -> list[tuple[int, float]]:
    """The five best (index into ``other`` where the window begins, may be negative; peak in standard deviations)."""
    total = sum(scipy.signal.correlate(o, w, "full", method="fft") for w, o in zip(window, other, strict=True))
    size = window.shape[1]
    power = np.convolve((other**2).sum(axis=0), np.ones(size), "full")
    # A lag at which little of the window overlaps must not win by chance.
    correlation = total / np.sqrt(np.maximum(power, 0.25 * power.max()) * (window**2).sum() + 1e-9)
    spread = 1.4826 * float(np.median(np.abs(correlation - np.median(correlation)))) + 1e-9
    found = []
    correlation = correlation - np.median(correlation)
    for _ in range(5):
        at = int(correlation.argmax())
        found.append((at - size + 1, float(correlation[at] / spread)))
        correlation[max(0, at - 25) : at + 26] = -np.inf
    return found


def _support(table: Array, row: Array) -> float:
    """How much all windows together speak for ``row``'s lag: the root of the summed squares of one vote a window."""
    allowed = 0.1 + MAX_DRIFT * np.abs(table[:, 0] - row[0])
    near = np.abs(table[:, 1] - row[1]) <= allowed
    votes = {}
    for middle, _, height in table[near & (table[:, 2] > 3.5)]:
        votes[middle] = max(votes.get(middle, 0.0), height)
    return float(np.sqrt(sum(v * v for v in votes.values())))


def gcc_phat_lag(reference: NDArray, other: NDArray, reach_s: float) -> tuple[float, float]:
    """The lag of two waveforms by generalised cross-correlation with phase transform.

    Parameters
    ----------
    reference, other
        (n,) of equal length, at `RATE`.
    reach_s
        The largest lag that is searched.

    Returns
    -------
    lag_s, height
        Seconds by which ``other`` is late, between samples by a parabola; height of that peak in standard deviations.

    Notes
    -----
    Every frequency of speech has one vote, so a loud hum cannot decide.

    References
    ----------
    Knapp and Carter, "The generalized correlation method for estimation of time delay", IEEE Trans. ASSP 24, 1976.
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
