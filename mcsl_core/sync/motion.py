"""Clocks from what moves: all cameras see the same hands, heads and lamp movements, each from its side.

Of every picture, reduced to 64 columns, the share that changed since the picture before; of that, what is more or
less than usual within eight seconds. Two cameras' tracks are slid along each other; all pairs together place every
camera, so that one whose view a head covers is tied in through the others. Stretches of two minutes are decoded: one
at the beginning (longer, where that is not sure), then one in the middle and one at the end; through the lags of their
windows a line is laid.

Simulated recordings of 2 to 10 minutes at 8 to 25 pictures a second came out within 27 ms over their whole length, half
of the cameras within 12 ms. Drift is known to 30 ppm at best, so a usual crystal's counts for little.
"""

from __future__ import annotations

import threading
from collections.abc import Generator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from fractions import Fraction
from itertools import combinations

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray
from scipy import ndimage, signal

from mcsl_core.edl import Clock
from mcsl_core.media.frames import to_planes
from mcsl_core.media.reading import VideoReader
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage

from .clock_fit import Found, Refusal, length_s, robust_line

Floats = NDArray[np.float64]

SIZE = (64, 36)
CHANGED = (4, 10)  # grey levels: past the noise of a reduced picture; past the shimmer of wet tissue
USUAL_S = 8.0
LEAST_RATE = 5  # pictures a second: below, a hand's strokes are not told apart
MOST_RATE = 30
LOOK_S = 120.0
LOOKS = (1, 2, 4)  # so many times LOOK_S are decoded from the beginning until all cameras are found
WINDOW_S = 20.0
REACH_S = 0.5
CRYSTALS = 30e-6  # how far two cameras' clocks commonly drift apart
LEAST_S = 30.0  # to be looked for; the line through windows asks for a minute in common
CLEAR_PEAK = 6.0  # in deviations. Of 2,600 pairs of unrelated simulated stretches of 60 to 240 s none reached
LEAST_LEAD = 1.5  # both; of pairs of one recording 60 %, 85 % and all did at 60, 120 and 240 s


@frozen(eq=False)
class Track:
    """What changed in a camera's picture. values: (2, n) at ``rate`` a second from own time ``start_s`` on."""

    values: Floats
    start_s: float
    rate: float

    def between(self, start_s: float, stop_s: float) -> Floats:
        first, last = (round((t - self.start_s) * self.rate) for t in (start_s, stop_s))
        return self.values[:, max(0, first) : max(0, last)]


@frozen
class Peak:
    """Where two tracks fit best. lag_s: own time of the first less that of the second. height: in deviations.

    lead: over the next-best answer, 0.3 s and more away.
    """

    lag_s: float
    height: float
    lead: float

    @property
    def clear(self) -> bool:
        return self.height >= CLEAR_PEAK and self.lead >= LEAST_LEAD


def find(footage: Footage, reference: str, wanted: Sequence[str], progress: Progress) -> Found:
    """The clocks of the cameras ``wanted`` against ``reference``, each by its motion or refused."""
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
    tracks: dict[str, Track] = {}
    peaks: dict[tuple[str, str], Peak] = {}
    for look in LOOKS:
        tracks = _watch(footage, {n: (0.0, look * LOOK_S) for n in usable}, rate, progress)
        peaks = {(a, b): best_fit(tracks[a], tracks[b]) for a, b in combinations(usable, 2)}
        offsets = place(peaks, reference)
        if set(wanted) <= offsets.keys() | slow or look * LOOK_S >= longest:
            break
    looks = [tracks]
    end = min(length_s(footage, n) + offsets[n] for n in offsets)
    seen = max(t.start_s + t.values.shape[1] / rate for t in tracks.values())
    for middle in (0.5 * (seen + end), end - LOOK_S / 2) if end - seen > LOOK_S else ():
        pieces = {n: (middle - LOOK_S / 2 - o, middle + LOOK_S / 2 - o) for n, o in offsets.items()}
        looks.append(_watch(footage, pieces, rate, progress))
    lines = _lines(looks, offsets, peaks, reference)
    for name in wanted:
        if name in found:
            continue
        if name not in offsets:
            found[name] = Refusal(_diagnosis(name, peaks))
            continue
        try:
            found[name] = _clock(lines[name], offsets[name])
        except Refusal as refusal:
            found[name] = refusal
    return found


# ------------------------------------------------------------------------------------------------------- watching


def _watch(
    footage: Footage, pieces: Mapping[str, tuple[float, float]], rate: float, progress: Progress
) -> dict[str, Track]:
    """The tracks of cameras over (start, stop) seconds of their own times; two cameras at once."""
    progress.stage("Watching what moves", len(pieces), "cameras")
    tracks: dict[str, Track] = {}
    stop = threading.Event()
    with ThreadPoolExecutor(max_workers=2) as workers:
        names = list(pieces)
        jobs = [workers.submit(watch, footage, name, *pieces[name], rate, stop) for name in names]
        try:
            for done, (name, job) in enumerate(zip(names, jobs, strict=True)):
                tracks[name] = job.result()
                progress.advance(done + 1)
        finally:
            stop.set()
    return tracks


def watch(
    footage: Footage, camera: str, start_s: float, stop_s: float, rate: float, stop: threading.Event | None = None
) -> Track:
    """One camera's track over its own times from ``start_s`` to ``stop_s`` at ``rate`` a second; short once ``stop``
    is set."""
    start_s = max(0.0, start_s)
    times, changes = [], []
    before = None
    with closing(_greys(footage, camera, Fraction(start_s), Fraction(stop_s))) as greys:
        for time, grey in greys:
            if stop is not None and stop.is_set():
                break
            if before is not None:
                change = cv2.absdiff(grey, before)
                changes.append([float((change >= least).mean()) for least in CHANGED])
                times.append(float(time))
            before = grey
    return Track(_evenly(times, changes, start_s, rate), start_s, rate)


def _greys(
    footage: Footage, camera: str, start_s: Fraction, stop_s: Fraction
) -> Generator[tuple[Fraction, NDArray[np.uint8]]]:
    """(own time, reduced grey picture) of every picture of a camera between two of its own times."""
    for part in footage.parts(camera):
        if part.end_s <= start_s or part.begin_s >= stop_s:
            continue
        with closing(VideoReader(part.facts, threads=1)) as reader:
            for time, frame in reader.read(max(part.facts.start_s, start_s - part.begin_s)):
                own = part.begin_s + time
                if own >= stop_s:
                    break
                grey = to_planes(frame, part.facts).y
                yield own, cv2.resize(grey, SIZE, interpolation=cv2.INTER_AREA)  # pyright: ignore[reportReturnType]


def _evenly(times: Sequence[float], changes: Sequence[Sequence[float]], start_s: float, rate: float) -> Floats:
    """(2, n) at an even rate: what changed until a moment is laid out evenly between two pictures, then cut anew."""
    if len(times) < 2:
        return np.zeros((len(CHANGED), 0))
    edges = np.arange(start_s, times[-1] + 1e-6, 1 / rate)
    sums = np.cumsum(np.array(changes), axis=0)
    tracks = np.array([np.diff(np.interp(edges, times, column)) for column in sums.T])
    # Logarithms: a head close to one lens changes twenty times as much as the hands that all of them see.
    level = np.log(tracks + 0.02 * tracks.mean(axis=1, keepdims=True) + 1e-4)
    usual = ndimage.uniform_filter1d(level, round(USUAL_S * rate) | 1, axis=1, mode="nearest")
    return np.clip(level - usual, -3, 3)


# -------------------------------------------------------------------------------------------------------- fitting


def _likeness(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """(lags in samples, likeness at each) of two tracks; a short overlap cannot win by chance."""
    total = np.sum(
        [signal.correlate(x - x.mean(), y - y.mean(), "full", method="fft") for x, y in zip(a, b, strict=True)], axis=0
    )
    lags = np.arange(-(b.shape[1] - 1), a.shape[1])
    overlap = np.minimum(a.shape[1], lags + b.shape[1]) - np.maximum(0, lags)
    return lags, total / np.sqrt(np.maximum(overlap, 0.25 * min(a.shape[1], b.shape[1])))


def best_fit(a: Track, b: Track) -> Peak:
    """Where ``b`` fits ``a`` best, between samples by a parabola."""
    if min(a.values.shape[1], b.values.shape[1]) < LEAST_S * a.rate or min(a.values.std(), b.values.std()) < 1e-3:
        return Peak(0.0, 0.0, 0.0)
    lags, like = _likeness(a.values, b.values)
    spread = 1.4826 * float(np.median(np.abs(like - np.median(like)))) + 1e-12
    at = int(like.argmax())
    rest = like.copy()
    near = max(2, round(0.3 * a.rate))
    rest[max(0, at - near) : at + near + 1] = -np.inf
    # Where motion goes on, a peak has broad shoulders: its neighbours count as rivals only once it has fallen off.
    lead = float(like[at] / max(rest.max(), spread))
    lag = (lags[at] + _between(like, at)) / a.rate
    return Peak(lag + a.start_s - b.start_s, float(like[at] / spread), lead)


def _between(like: Floats, at: int) -> float:
    """The peak's place between samples, -0.5 to 0.5 of one."""
    if not 0 < at < len(like) - 1:
        return 0.0
    left, top, right = like[at - 1 : at + 2]
    bend = left - 2 * top + right
    return 0.0 if bend >= 0 else float(np.clip(0.5 * (left - right) / bend, -0.5, 0.5))


def place(peaks: Mapping[tuple[str, str], Peak], reference: str) -> dict[str, float]:
    """camera -> programme time of its own 0, of those that clear pairs tie to the reference.

    A tree of the highest peaks (Prim), then all clear pairs that agree with it to 0.1 s together, by least squares.
    """
    clear = {pair: peak for pair, peak in peaks.items() if peak.clear}
    offsets = {reference: 0.0}
    while True:
        doors = [(peak.height, pair) for pair, peak in clear.items() if (pair[0] in offsets) != (pair[1] in offsets)]
        if not doors:
            break
        a, b = max(doors)[1]
        lag = clear[a, b].lag_s
        if a in offsets:
            offsets[b] = offsets[a] + lag
        else:
            offsets[a] = offsets[b] - lag
    agreeing = {(a, b): peak.lag_s for (a, b), peak in clear.items() if a in offsets and b in offsets}
    agreeing = {(a, b): lag for (a, b), lag in agreeing.items() if abs(offsets[b] - offsets[a] - lag) < 0.1}
    return _balanced(agreeing, {pair: clear[pair].height for pair in agreeing}, reference)


def _balanced(
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


# --------------------------------------------------------------------------------------------------------- the line


@frozen(eq=False)
class _Line:
    """One camera's (programme time, lag to what was expected) by windows; what lies ``within_s`` of a line agrees."""

    found: Sequence[tuple[float, float]]
    within_s: float


def _lines(
    looks: Sequence[Mapping[str, Track]],
    offsets: Mapping[str, float],
    peaks: Mapping[tuple[str, str], Peak],
    reference: str,
) -> dict[str, _Line]:
    """Each camera's lags by windows of programme time, every window's pairs balanced together."""
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in offsets}
    rate = looks[0][reference].rate
    for tracks in looks:
        start = min(t.start_s + offsets[n] for n, t in tracks.items() if n in offsets)
        stop = max(t.start_s + t.values.shape[1] / t.rate + offsets[n] for n, t in tracks.items() if n in offsets)
        for begin in np.arange(start, stop - WINDOW_S, WINDOW_S):
            lags: dict[tuple[str, str], float] = {}
            heights: dict[tuple[str, str], float] = {}
            for a, b in combinations([n for n in tracks if n in offsets], 2):
                fit = _near_fit(tracks[a], tracks[b], begin, offsets[a], offsets[b]) if peaks[a, b].clear else None
                if fit is not None:
                    lags[a, b], heights[a, b] = fit.lag_s, max(0.1, fit.height)
            for name, lag in _balanced(lags, heights, reference).items():
                found[name].append((float(begin) + WINDOW_S / 2, lag))
    return {name: _Line(found[name], 1.0 / rate) for name in offsets}


def _near_fit(a: Track, b: Track, begin: float, offset_a: float, offset_b: float) -> Peak | None:
    """The lag of ``b`` to what was expected in one window, within `REACH_S`; None where it is not seen whole by
    both, or nothing moves in it."""
    first_a, first_b = (round((begin - o - t.start_s) * t.rate) for t, o in ((a, offset_a), (b, offset_b)))
    count, reach = round(WINDOW_S * a.rate), round(REACH_S * a.rate)
    x, y = a.values[:, max(0, first_a) : first_a + count], b.values[:, max(0, first_b) : first_b + count]
    if min(x.shape[1], y.shape[1]) < count:
        return None
    if min(x.std(), y.std()) < 0.05:
        return None
    lags, like = _likeness(x, y)
    spread = 1.4826 * float(np.median(np.abs(like - np.median(like)))) + 1e-12
    middle = int(np.flatnonzero(lags == 0)[0])
    near = like[middle - reach : middle + reach + 1]
    at = middle - reach + int(near.argmax())
    # Both were cut at whole samples: what that moved them by comes off again.
    cut = (a.start_s + first_a / a.rate + offset_a) - (b.start_s + first_b / b.rate + offset_b)
    return Peak((lags[at] + _between(like, at)) / a.rate + cut, float(like[at] / spread), 0.0)


def _clock(line: _Line, offset: float) -> Clock:
    """The line through the windows that agree, as steep as they can tell.

    A window's lag is good to a few hundredths of a second. Against that stands what is known of crystals: the slope
    found counts by the share that its variance leaves it (Bayes' rule for two normal distributions).
    """
    level, slope, share = robust_line(line.found, len(line.found), line.within_s)
    times, lags = np.array(line.found).T
    agree = np.abs(lags - level - slope * times) < line.within_s
    times, lags = times[agree], lags[agree]
    middle = float(times.mean())
    scatter = max(float(np.std(lags - level - slope * times)), line.within_s / 4)
    slope *= CRYSTALS**2 / (CRYSTALS**2 + scatter**2 / float(np.square(times - middle).sum()))
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
