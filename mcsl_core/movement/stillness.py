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

from ..edl import Movement
from ..footage import Footage
from ..progress import Progress
from ..samples import Samples
from ..scores import Curve, Detection
from ..timing import FrameRange
from .displacement import Grey, Standing, texture
from .timing import CloseLook, time_side

IN_PLACE_PX = 0.5
"""A patch found this near to its place lies there: on standing views the error of one patch is 0.1 to 0.3 px."""


def stillness(shares: Sequence[float]) -> float:
    """How still the lamp is, from every camera's share in place: the second highest, so that one view with a burnt-in
    clock over bare cloth cannot hide a movement, and heads before all but two cannot fake one. NaN without data."""
    known = sorted((s for s in shares if not np.isnan(s)), reverse=True)
    if not known:
        return float("nan")
    return known[min(1, len(known) - 1)]


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

    def detect(self, samples: Samples, footage: Footage, progress: Progress) -> Detection:
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

    def _compare(self, samples: Samples, progress: Progress) -> Mapping[int, tuple[NDArray, NDArray]]:
        """lag -> ((S - 1,) stillness, (S - 1,) highest share of any camera) of sample i + 1 against i + 1 - lag; NaN
        where nothing can be said. Where a camera had no picture, its last one before that counts."""
        every = {lag: (np.full(max(len(samples) - 1, 0), np.nan),) * 2 for lag in self.lags}
        every = {lag: (a.copy(), b.copy()) for lag, (a, b) in every.items()}
        past: dict[str, deque[tuple[int, Standing]]] = {c: deque(maxlen=max(self.lags)) for c in samples.cameras}
        for i, moment in enumerate(samples):
            shares: dict[int, list[float]] = {lag: [] for lag in self.lags}
            for name, picture in moment.pictures.items():
                if picture is None:
                    continue
                now = texture(picture)
                for lag in self.lags:
                    before = next((s for at, s in reversed(past[name]) if at <= i - lag), None)
                    if before is not None:
                        shares[lag].append(_in_place(before, now))
                past[name].append((i, Standing.of([now])))
            for lag, found in shares.items():
                if i and found:
                    known = [s for s in found if not np.isnan(s)]
                    every[lag][0][i - 1] = stillness(found)
                    every[lag][1][i - 1] = max(known) if len(known) >= 3 else np.nan
            progress.advance(i + 1)
        return every

    def _spans(self, looks: Mapping[int, tuple[NDArray, NDArray]], samples: Samples, footage: Footage) -> list[Span]:
        """Where looks differ, in order; of a longer lag only what no shorter one explains."""
        spans: list[Span] = []
        for lag in self.lags:
            values, highest = looks[lag]
            added: list[Span] = []
            for i in np.flatnonzero(values < self.still).tolist():
                first, last = max(i + 1 - lag, 0), i + 1
                if any(first < s.last and s.first < last for s in spans):
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

    def _left(self, span: Span, samples: Samples, *, around: int = 4) -> bool:
        """Whether the lamp left its place: no look before the span shows the same view as any look after it."""
        if span.everywhere:
            return True
        before = [samples[i].pictures for i in range(max(0, span.first - around), span.first + 1)]
        after = [samples[i].pictures for i in range(span.last, min(len(samples), span.last + around + 1))]
        prepared = [{n: Standing.of([texture(p)]) for n, p in m.items() if p is not None} for m in before]
        later = [{n: texture(p) for n, p in m.items() if p is not None} for m in after]
        return not any(
            stillness([_in_place(a[n], b[n]) for n in a.keys() & b.keys()]) >= self.still
            for a, b in product(prepared, later)
        )

    def _timed(self, span: Span, earliest: int, latest: int, samples: Samples, footage: Footage) -> Movement:
        """The span's start and stop to the frame, looked for between the samples ``earliest`` and ``latest``."""
        frames = samples.frames
        look = CloseLook(footage, samples.cameras, self.close_s * min(span.lag, 4), margin_s=2.5 * span.lag)
        rate = float(footage.rate)
        low, high = frames[earliest], frames[latest] if latest < len(frames) - 1 else footage.frames - 1
        reach = round((2 + span.lag) * rate)  # samples may be half a second off: keyframes stand for them
        start = time_side(look, frames[span.first], frames[span.first] + reach, low)
        stop = time_side(look, frames[span.last], frames[span.last] - reach, high)
        first = frames[span.first] if start is None else int(np.floor(start)) + 1
        last = frames[span.last] if stop is None else int(np.ceil(stop))
        confidence = round(min(1.0, max(0.0, 1 - span.least / self.still)), 3)
        if last <= first:  # the two sides contradict each other: what the samples say stands
            return Movement(FrameRange(frames[span.first], frames[span.last]), 0.5 * confidence)
        return Movement(FrameRange(max(first, 0), min(last, footage.frames)), confidence)


def _in_place(before: Standing, now: Grey) -> float:
    shift = before.shift(now)
    return float("nan") if shift is None else shift.share(IN_PLACE_PX)


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
