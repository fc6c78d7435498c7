"""Whether each camera's static background still lies where it lay.

Heads and hands cover parts of a view; a movement of the lamp leaves no part of any view where it was. So stillness is
proven by what is found again in its place, and no number of heads can fake a movement while two views show some cloth.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.edl import Movement
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.timing import FrameRange

from .boundaries import CloseLook, bracket, time_side
from .displacement import Grey, Shift, Standing, texture
from .protocol import Curve, Detection

IN_PLACE_PX = 0.5
"""A patch found this near to its place lies there: on standing views the error of one patch is 0.1 to 0.3 px."""


LIVE = 0.95
"""With more than this in place nothing at all has moved in a view: it may be a stream that has frozen."""
DRIFT_PX = 0.4
"""A common displacement that is no error: between two samples of a standing view it is 0.05 px, 0.2 behind heads."""


def stillness(shares: Sequence[float]) -> float:
    """How still the lamp is, from every camera's share in place: 0..1, NaN without data.

    The second highest, or half of the highest where that view is alive: heads before all cameras but one cannot fake a
    movement, and one stream that has frozen cannot hide one.
    """
    known = sorted((s for s in shares if not np.isnan(s)), reverse=True)
    if not known:
        return float("nan")
    return max(known[min(1, len(known) - 1)], 0.5 * known[0] if known[0] < LIVE else 0.0)


def drift(shifts: Sequence[Shift], *, found: float) -> tuple[float, int]:
    """(the second smallest displacement of any camera that finds at least the share ``found`` again, how many do): two
    heads that sway before two cameras fake no drift. NaN where no camera does."""
    sizes = sorted(float(np.linalg.norm(c)) for s in shifts if s.share() > found and (c := s.common()) is not None)
    return (sizes[min(1, len(sizes) - 1)] if sizes else float("nan")), len(sizes)


@frozen
class Span:
    """Samples (positions) between which the lamp moved: it stood at ``first`` and stands again at ``last``.

    lag: samples between the looks that showed it; 1 unless it is slow. least: the least stillness in it. everywhere:
    no camera found anything in its place at some moment.
    """

    first: int
    last: int
    lag: int
    least: float
    everywhere: bool


@frozen
class Stillness:
    """Whether each camera's static background still lies where it lay. All cameras start and stop together.

    still: with at least this share of the background in place the lamp stands; simulated standing views with four
    heads gave 0.15 at the least, moving ones 0.11 at the most. lags: how many samples apart looks are compared: the
    next one, and farther ones for drifts too slow to see from one to the next. Each suspected stretch is looked at
    closely, ``close_s`` apart, for the frame at which it starts and stops. Stretches less than ``join_s`` apart are one
    movement.

    A movement that ends where it began is one only if no camera at all found anything in its place meanwhile: else
    something hid the views for a while. What is over between two samples and leaves the views where they were is not
    seen.
    """

    still: float = field(default=0.12)
    lags: tuple[int, ...] = field(default=(1, 3, 9))
    close_s: float = field(default=0.1)
    join_s: float = field(default=2.0)
    name = "stillness"

    def detect(self, samples: SampleStore, footage: Footage, progress: Progress) -> Detection:
        """The movements, in order, on the programme clock."""
        progress.stage("Looking for lamp movements", len(samples), "samples")
        looks = self._compare(samples, progress)
        middles = np.array(samples.frames[1:], np.int64)
        curve = Curve("background in place", "", middles, looks[1][0], np.full(len(middles), self.still))
        spans = [s for s in self._spans(looks, samples, footage) if self._left(s, samples)]
        progress.stage("Timing the movements", len(spans), "movements")
        found: list[Movement] = []
        for number, span in enumerate(spans):
            until = spans[number + 1].first if number + 1 < len(spans) else len(samples) - 1
            found.append(self._timed(span, spans[number - 1].last if number else 0, until, samples, footage))
            progress.advance(number + 1)
        return Detection(tuple(_apart(found)), curve)

    def _compare(self, samples: SampleStore, progress: Progress) -> Mapping[int, tuple[NDArray, NDArray]]:
        """lag -> ((S - 1,) stillness, (S - 1,) highest share of any camera) of sample i + 1 against i + 1 - lag; NaN
        where nothing can be said. Where a camera had no picture, its last one before that counts."""
        steps = max(len(samples) - 1, 0)
        every = {lag: (np.full(steps, np.nan), np.full(steps, np.nan)) for lag in self.lags}
        past: dict[str, deque[tuple[int, Standing]]] = {c: deque(maxlen=max(self.lags)) for c in samples.cameras}
        for i, moment in enumerate(samples):
            shifts: dict[int, list[Shift]] = {lag: [] for lag in self.lags}
            for name, picture in moment.pictures.items():
                if picture is None:
                    continue
                now = texture(picture)
                for lag in self.lags:
                    before = next((s for at, s in reversed(past[name]) if at <= i - lag), None)
                    shift = None if before is None else before.shift(now)
                    if shift is not None:
                        shifts[lag].append(shift)
                past[name].append((i, Standing.of([now])))
            for lag, found in shifts.items():
                if found:
                    every[lag][0][i - 1], every[lag][1][i - 1] = self._judged(found, lag)
            progress.advance(i + 1)
        return every

    def _judged(self, shifts: Sequence[Shift], lag: int) -> tuple[float, float]:
        """(stillness, highest share of three or more cameras) of one comparison."""
        shares = [s for shift in shifts if not np.isnan(s := shift.share(IN_PLACE_PX))]
        still = stillness(shares)
        if lag > 1:  # heads alone hide much in some seconds: here a displacement must be seen
            far_px, cameras = drift(shifts, found=self.still)
            if far_px > DRIFT_PX and cameras >= 3:
                still = min(still, 0.5 * self.still)
            elif still < self.still and not far_px > DRIFT_PX:
                still = float("nan")
        return still, max(shares) if len(shares) >= 3 else float("nan")

    def _spans(
        self, looks: Mapping[int, tuple[NDArray, NDArray]], samples: SampleStore, footage: Footage
    ) -> list[Span]:
        """Where looks differ, in order; of a longer lag only what no shorter one explains."""
        spans: list[Span] = []
        for lag in self.lags:
            values, highest = looks[lag]
            added: list[Span] = []
            for i in np.flatnonzero(values < self.still).tolist():
                first, last = max(i + 1 - lag, 0), i + 1
                if lag > 1 and any(first <= s.last and s.first <= last for s in spans):
                    continue
                everywhere = bool(highest[i] < self.still / 4)
                if added and first <= added[-1].last:
                    before = added[-1]
                    added[-1] = Span(
                        before.first, last, lag, min(before.least, values[i]), before.everywhere or everywhere
                    )
                else:
                    added.append(Span(first, last, lag, float(values[i]), everywhere))
            spans = sorted([*spans, *added], key=lambda s: s.first)
        return self._joined(spans, looks, samples.frames, join_frames=self.join_s * float(footage.rate))

    def _joined(
        self,
        spans: Sequence[Span],
        looks: Mapping[int, tuple[NDArray, NDArray]],
        frames: Sequence[int],
        *,
        join_frames: float,
    ) -> list[Span]:
        """Spans with a short pause between them, or one in which no two looks prove that the lamp stood, are one."""
        joined: list[Span] = []
        for span in spans:
            if joined:
                before = joined[-1]
                pause = span.first - before.last
                lag = max(lag for lag in self.lags if lag <= max(1, min(3, pause)))
                proofs = looks[lag][0][before.last + lag - 1 : span.first]
                if frames[span.first] - frames[before.last] <= join_frames or not (proofs >= self.still).any():
                    joined[-1] = Span(
                        before.first,
                        span.last,
                        max(before.lag, span.lag),
                        min(before.least, span.least),
                        before.everywhere or span.everywhere,
                    )
                    continue
            joined.append(span)
        return joined

    def _left(self, span: Span, samples: SampleStore, *, around: int = 8) -> bool:
        """Whether the lamp left its place: no look before the span shows the same view as any look after it."""
        if span.everywhere:
            return True
        before = [_textures(samples, i) for i in range(max(0, span.first - around), span.first + 1)]
        later = [_textures(samples, i) for i in range(span.last, min(len(samples), span.last + around + 1))]
        prepared = [{n: Standing.of([t]) for n, t in m.items()} for m in before]
        return not any(self._same(a, b) for a, b in product(prepared, later))

    def _same(self, before: Mapping[str, Standing], later: Mapping[str, Grey]) -> bool:
        shifts = [s for n in before.keys() & later.keys() if (s := before[n].shift(later[n])) is not None]
        if not stillness([s.share(IN_PLACE_PX) for s in shifts]) >= self.still:
            return False
        return not drift(shifts, found=self.still)[0] > DRIFT_PX

    def _timed(self, span: Span, earliest: int, latest: int, samples: SampleStore, footage: Footage) -> Movement:
        """The span's start and stop to the frame, looked for between the samples ``earliest`` and ``latest``."""
        frames, rate = samples.frames, float(footage.rate)
        low, high = frames[earliest], frames[latest] if latest < len(frames) - 1 else footage.frames - 1

        def side(order: range, bound: int) -> float | None:
            rest, gone = bracket(_textures(samples, i) for i in order)
            # The slower it is, the farther apart are the looks; keyframes stand for samples half a second off.
            look = CloseLook(footage, samples.cameras, self.close_s * min(max(1.0, (gone - rest) / 3), 4.0))
            return time_side(look, frames[order[rest]], frames[order[gone]] + order.step * round(rate), bound)

        start = side(range(span.first, span.last + 1), low)
        stop = side(range(span.last, span.first - 1, -1), high)
        first = frames[span.first] if start is None else int(np.floor(start)) + 1
        last = frames[span.last] if stop is None else int(np.ceil(stop))
        confidence = round(min(1.0, max(0.0, 1 - float(span.least) / self.still)), 3)
        if last <= first:  # the two sides contradict each other: what the samples say stands
            return Movement(FrameRange(frames[span.first], frames[span.last]), 0.5 * confidence)
        return Movement(FrameRange(max(first, 0), min(last, footage.frames)), confidence)


def _textures(samples: SampleStore, position: int) -> dict[str, Grey]:
    return {name: texture(p) for name, p in samples[position].pictures.items() if p is not None}


def _apart(movements: Sequence[Movement]) -> list[Movement]:
    """Movements that overlap after timing become one."""
    apart: list[Movement] = []
    for movement in sorted(movements, key=lambda m: m.range):
        if apart and movement.range.start < apart[-1].range.stop:
            joined = FrameRange(apart[-1].range.start, max(apart[-1].range.stop, movement.range.stop))
            apart[-1] = Movement(joined, max(apart[-1].confidence, movement.confidence))
        else:
            apart.append(movement)
    return apart
