"""Clocks from motion energy: all cameras see the same hands, heads and lamp movements, each from its side.

Of every picture, downscaled to 64 columns, the share of pixels that changed since the picture before, against its
moving average over eight seconds. The tracks of two cameras are cross-correlated; the lags of all pairs are solved
together, so that a camera before which a head stands is tied in through the others. Segments of two minutes are
decoded: one at the beginning (longer, where that is not sure), then one in the middle and one at the end; a line is
fitted to the lags of their windows.

Simulated recordings of 2 to 10 minutes at 8 to 25 pictures a second came out within 27 ms over their whole length, half
of the cameras within 12 ms. Drift is known to 30 ppm at best, so a usual crystal's counts for little.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np
import scipy
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.edl import Clock
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage

from .clock_fit import ClockResults, Refusal, length_s, robust_line
from .motion_energy import MotionTrack, motion_tracks

Array = NDArray[np.float64]

LEAST_RATE = 5  # pictures a second: below, a hand's strokes are not told apart
MOST_RATE = 30
SEGMENT_S = 120.0
FIRST_SEGMENT_LENGTHS = (1, 2, 4)  # times SEGMENT_S, decoded from the beginning until all cameras are found
WINDOW_S = 20.0
SEARCH_S = 0.5
CRYSTAL_DRIFT = 30e-6  # how far two cameras' clocks commonly drift apart
LEAST_S = 30.0  # of a track; the line through its windows asks for a minute in common
CLEAR_PEAK = 6.0  # in standard deviations. Of 2,600 pairs of unrelated simulated tracks of 60 to 240 s none reached
LEAST_LEAD = 1.5  # both; of pairs of one recording 60 %, 85 % and all did at 60, 120 and 240 s


@frozen
class Peak:
    """The peak of the cross-correlation of two tracks.

    Attributes
    ----------
    lag_s
        Own time of the first less that of the second.
    height
        In standard deviations.
    lead
        Height over that of the next-best peak, 0.3 s and more away.
    """

    lag_s: float
    height: float
    lead: float

    @property
    def clear(self) -> bool:
        """Whether it is high and unambiguous enough to be taken."""
        return self.height >= CLEAR_PEAK and self.lead >= LEAST_LEAD


def clocks_from_motion(footage: Footage, reference: str, wanted: Sequence[str], progress: Progress) -> ClockResults:
    """The clocks of the cameras ``wanted`` against ``reference``, each by its motion or refused.

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
    # All cameras help, those that are found already too: any pair may be the one that sees the same hands.
    cameras = [camera.name for camera in footage.cameras]
    slow = {n for n in cameras if min(part.facts.rate for part in footage.parts(n)) < LEAST_RATE}
    found: dict[str, Clock | Refusal] = {
        name: Refusal(f"{LEAST_RATE} pictures a second are too few")
        for name in wanted
        if name in slow or reference in slow
    }
    usable = [n for n in cameras if n not in slow]
    if set(wanted) <= found.keys():
        return found
    rate = min(MOST_RATE, *(float(part.facts.rate) for n in usable for part in footage.parts(n)))
    longest = max(length_s(footage, n) for n in usable)
    offsets: dict[str, float] = {}
    tracks: dict[str, MotionTrack] = {}
    peaks: dict[tuple[str, str], Peak] = {}
    for length in FIRST_SEGMENT_LENGTHS:
        tracks = motion_tracks(footage, {n: (0.0, length * SEGMENT_S) for n in usable}, rate, progress)
        peaks = {(a, b): best_lag(tracks[a], tracks[b]) for a, b in combinations(usable, 2)}
        offsets = solve_offsets(peaks, reference)
        if set(wanted) <= offsets.keys() | slow or length * SEGMENT_S >= longest:
            break
    segments = [tracks]
    end = min(length_s(footage, n) + offsets[n] for n in offsets)
    seen = max(t.start_s + t.values.shape[1] / rate for t in tracks.values())
    for middle in (0.5 * (seen + end), end - SEGMENT_S / 2) if end - seen > SEGMENT_S else ():
        pieces = {n: (middle - SEGMENT_S / 2 - o, middle + SEGMENT_S / 2 - o) for n, o in offsets.items()}
        segments.append(motion_tracks(footage, pieces, rate, progress))
    window_lags = _window_lags(segments, offsets, peaks, reference)
    for name in wanted:
        if name in found:
            continue
        if name not in offsets:
            found[name] = Refusal(_diagnosis(name, peaks))
            continue
        try:
            found[name] = _clock(window_lags[name], offsets[name])
        except Refusal as refusal:
            found[name] = refusal
    return found


# ---------------------------------------------------------------------------------------------------- pairwise lags


def _cross_correlation(a: Array, b: Array) -> tuple[Array, Array]:
    """(lags in values, correlation at each) of two tracks, so normalised that a short overlap cannot win by chance."""
    total = np.sum(
        [scipy.signal.correlate(x - x.mean(), y - y.mean(), "full", method="fft") for x, y in zip(a, b, strict=True)],
        axis=0,
    )
    lags = np.arange(-(b.shape[1] - 1), a.shape[1])
    overlap = np.minimum(a.shape[1], lags + b.shape[1]) - np.maximum(0, lags)
    return lags, total / np.sqrt(np.maximum(overlap, 0.25 * min(a.shape[1], b.shape[1])))


def best_lag(a: MotionTrack, b: MotionTrack) -> Peak:
    """The highest peak of the cross-correlation of ``a`` and ``b``, between values by a parabola.

    Of height 0 where a track is shorter than `LEAST_S` or does not move.
    """
    if min(a.values.shape[1], b.values.shape[1]) < LEAST_S * a.rate or min(a.values.std(), b.values.std()) < 1e-3:
        return Peak(0.0, 0.0, 0.0)
    lags, correlation = _cross_correlation(a.values, b.values)
    spread = 1.4826 * float(np.median(np.abs(correlation - np.median(correlation)))) + 1e-12
    at = int(correlation.argmax())
    rest = correlation.copy()
    near = max(2, round(0.3 * a.rate))
    rest[max(0, at - near) : at + near + 1] = -np.inf
    # Where motion goes on, a peak has broad shoulders: its neighbours count as rivals only once it has fallen off.
    lead = float(correlation[at] / max(rest.max(), spread))
    lag = (lags[at] + _subsample_shift(correlation, at)) / a.rate
    return Peak(lag + a.start_s - b.start_s, float(correlation[at] / spread), lead)


def _subsample_shift(correlation: Array, at: int) -> float:
    """The peak's position between values by a parabola, -0.5 to 0.5 of one."""
    if not 0 < at < len(correlation) - 1:
        return 0.0
    left, top, right = correlation[at - 1 : at + 2]
    bend = left - 2 * top + right
    return 0.0 if bend >= 0 else float(np.clip(0.5 * (left - right) / bend, -0.5, 0.5))


def solve_offsets(peaks: Mapping[tuple[str, str], Peak], reference: str) -> dict[str, float]:
    """The offsets of all cameras from their pairwise lags.

    Parameters
    ----------
    peaks
        (first camera, second camera) -> the peak of their cross-correlation.
    reference
        The camera with offset 0.

    Returns
    -------
    dict
        Camera -> programme time of its own 0, of those that clear pairs tie to the reference.

    Notes
    -----
    The maximum spanning tree of the peaks' heights (Prim), then all clear pairs that agree with it to 0.1 s together,
    by least squares.
    """
    clear = {pair: peak for pair, peak in peaks.items() if peak.clear}
    offsets = {reference: 0.0}
    while True:
        open_pairs = [
            (peak.height, pair) for pair, peak in clear.items() if (pair[0] in offsets) != (pair[1] in offsets)
        ]
        if not open_pairs:
            break
        a, b = max(open_pairs)[1]
        lag = clear[a, b].lag_s
        if a in offsets:
            offsets[b] = offsets[a] + lag
        else:
            offsets[a] = offsets[b] - lag
    agreeing = {(a, b): peak.lag_s for (a, b), peak in clear.items() if a in offsets and b in offsets}
    agreeing = {(a, b): lag for (a, b), lag in agreeing.items() if abs(offsets[b] - offsets[a] - lag) < 0.1}
    return _least_squares_offsets(agreeing, {pair: clear[pair].height for pair in agreeing}, reference)


def _least_squares_offsets(
    lags: Mapping[tuple[str, str], float], weights: Mapping[tuple[str, str], float], reference: str
) -> dict[str, float]:
    """The offsets that the lags of all pairs (a, b), offset of b less that of a, agree on best.

    Of the reference (0) and those that a chain of pairs ties to it; the others are not in it.
    """
    tied = {reference}
    while more := {name for pair in lags if tied & set(pair) for name in pair} - tied:
        tied |= more
    lags = {pair: lag for pair, lag in lags.items() if pair[0] in tied}
    names = sorted(tied - {reference})
    if not names:
        return {reference: 0.0}
    rows, right = np.zeros((len(lags), len(names))), np.zeros(len(lags))
    for row, ((a, b), lag) in enumerate(lags.items()):
        for name, sign in ((a, -1.0), (b, 1.0)):
            if name != reference:
                rows[row, names.index(name)] = sign * weights[a, b]
        right[row] = lag * weights[a, b]
    solved = np.linalg.lstsq(rows, right, rcond=None)[0]
    return {reference: 0.0, **{name: float(value) for name, value in zip(names, solved, strict=True)}}


# -------------------------------------------------------------------------------------------------- offset and drift


@frozen(eq=False)
class _WindowLags:
    """One camera's (programme time, residual lag) by windows; what lies ``within_s`` of a line agrees with it."""

    found: Sequence[tuple[float, float]]
    within_s: float


def _window_lags(
    segments: Sequence[Mapping[str, MotionTrack]],
    offsets: Mapping[str, float],
    peaks: Mapping[tuple[str, str], Peak],
    reference: str,
) -> dict[str, _WindowLags]:
    """Each camera's residual lags by windows of programme time, every window's pairs solved together."""
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in offsets}
    rate = segments[0][reference].rate
    for tracks in segments:
        start = min(t.start_s + offsets[n] for n, t in tracks.items() if n in offsets)
        stop = max(t.start_s + t.values.shape[1] / t.rate + offsets[n] for n, t in tracks.items() if n in offsets)
        for begin in np.arange(start, stop - WINDOW_S, WINDOW_S):
            lags: dict[tuple[str, str], float] = {}
            heights: dict[tuple[str, str], float] = {}
            for a, b in combinations([n for n in tracks if n in offsets], 2):
                fit = _window_lag(tracks[a], tracks[b], begin, offsets[a], offsets[b]) if peaks[a, b].clear else None
                if fit is not None:
                    lags[a, b], heights[a, b] = fit.lag_s, max(0.1, fit.height)
            for name, lag in _least_squares_offsets(lags, heights, reference).items():
                found[name].append((float(begin) + WINDOW_S / 2, lag))
    return {name: _WindowLags(found[name], 1.0 / rate) for name in offsets}


def _window_lag(a: MotionTrack, b: MotionTrack, begin: float, offset_a: float, offset_b: float) -> Peak | None:
    """The residual lag of ``b`` in the window from ``begin`` on, within `SEARCH_S`.

    None where a track does not reach over the whole window, or nothing moves in it.
    """
    first_a, first_b = (round((begin - o - t.start_s) * t.rate) for t, o in ((a, offset_a), (b, offset_b)))
    count, reach = round(WINDOW_S * a.rate), round(SEARCH_S * a.rate)
    x, y = a.values[:, max(0, first_a) : first_a + count], b.values[:, max(0, first_b) : first_b + count]
    if min(x.shape[1], y.shape[1]) < count:
        return None
    if min(x.std(), y.std()) < 0.05:
        return None
    lags, correlation = _cross_correlation(x, y)
    spread = 1.4826 * float(np.median(np.abs(correlation - np.median(correlation)))) + 1e-12
    middle = int(np.flatnonzero(lags == 0)[0])
    near = correlation[middle - reach : middle + reach + 1]
    at = middle - reach + int(near.argmax())
    # Both were cut at whole values: what that shifted them by comes off again.
    cut = (a.start_s + first_a / a.rate + offset_a) - (b.start_s + first_b / b.rate + offset_b)
    return Peak((lags[at] + _subsample_shift(correlation, at)) / a.rate + cut, float(correlation[at] / spread), 0.0)


def _clock(measured: _WindowLags, offset: float) -> Clock:
    """The clock by the line through the windows that agree, its slope shrunk towards 0.

    A window's lag is good to a few hundredths of a second, and crystals are known to drift little (`CRYSTAL_DRIFT`):
    the slope is the posterior mean of two normal distributions.
    """
    level, slope, share = robust_line(measured.found, len(measured.found), measured.within_s)
    times, lags = np.array(measured.found).T
    agree = np.abs(lags - level - slope * times) < measured.within_s
    times, lags = times[agree], lags[agree]
    middle = float(times.mean())
    scatter = max(float(np.std(lags - level - slope * times)), measured.within_s / 4)
    slope *= CRYSTAL_DRIFT**2 / (CRYSTAL_DRIFT**2 + scatter**2 / float(np.square(times - middle).sum()))
    level = float(lags.mean()) - slope * middle
    return Clock(
        offset_s=(offset + level) / (1 - slope),
        drift_ppm=-slope * 1e6,
        method="motion",
        confidence=round(0.8 * share, 3),
    )


def _diagnosis(name: str, peaks: Mapping[tuple[str, str], Peak]) -> str:
    own = [peak for pair, peak in peaks.items() if name in pair]
    best = max(own, key=lambda peak: peak.height, default=None)
    if best is None or best.height == 0:
        return f"nothing moves in its pictures, or they are too short: {LEAST_S:.0f} s at least"
    if best.height < CLEAR_PEAK:
        return "what moves in its pictures fits no other camera"
    return "what moves in its pictures fits the others in several ways"
