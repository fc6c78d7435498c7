"""Movement detection by stillness: whether each camera's static background still lies where it lay.

Heads and hands occlude parts of a picture; a movement of the lamp leaves no part of any picture where it was. So
stillness is proven by what is found again in place, and no number of heads can fake a movement while two cameras see
some cloth.
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

from .boundaries import CloseSampling, boundary_time, bracket_boundary
from .displacement import Displacement, Grey, Template, common_sizes, texture
from .protocol import Curve, Detection

IN_PLACE_PX = 0.5
"""A patch found this near to its position lies in place: at rest the error of one patch is 0.1 to 0.3 px."""
LIVE = 0.95
"""With more than this in place nothing at all has moved before a camera: its stream may have frozen."""
DRIFT_PX = 0.4
"""A common displacement that is no error: between two samples at rest it is 0.05 px, 0.2 behind heads."""


@frozen
class Candidate:
    """Samples between which the lamp moved, if it did: it stood at the first and stands again at the last.

    Attributes
    ----------
    first, last
        Positions of the samples.
    lag
        Samples between the two that were compared; 1 unless the movement is slow.
    least
        The least stillness in it, 0..1.
    all_lost
        Whether no camera found anything in place at some sample.
    """

    first: int
    last: int
    lag: int
    least: float
    all_lost: bool

    def joined(self, later: Candidate) -> Candidate:
        """One candidate from the start of this one to the end of ``later``."""
        return Candidate(
            self.first,
            later.last,
            max(self.lag, later.lag),
            min(self.least, later.least),
            self.all_lost or later.all_lost,
        )


@frozen(eq=False)
class Comparison:
    """Every sample i + 1 against the sample a lag before it; NaN where nothing can be said.

    Attributes
    ----------
    still
        (S - 1,) stillness, 0..1.
    highest
        (S - 1,) highest share in place of any of three or more cameras.
    """

    still: NDArray
    highest: NDArray


@frozen
class Stillness:
    """Detects movements by whether each camera's static background still lies in place.

    All cameras start and stop together. Each candidate is sampled closely for the frames at which it starts and stops.

    Parameters
    ----------
    still
        With at least this share of the background in place the lamp stands. Simulated recordings gave 0.15 at the least
        while it stood, behind four heads, and 0.11 at the most while it moved.
    lags
        How many samples apart samples are compared: the next one, and farther ones for drifts too slow to see from one
        to the next.
    close_s
        Seconds between the frames of close sampling.
    join_s
        Candidates less than this apart are one movement.

    Notes
    -----
    A movement that ends where it began is one only if no camera at all found anything in place meanwhile: else
    something occluded the background for a while. What is over between two samples and leaves the background where it
    was is not seen.
    """

    still: float = field(default=0.12)
    lags: tuple[int, ...] = field(default=(1, 3, 9))
    close_s: float = field(default=0.1)
    join_s: float = field(default=2.0)
    name = "stillness"

    def detect(self, samples: SampleStore, footage: Footage, progress: Progress) -> Detection:
        """The movements, in order, on the programme clock."""
        progress.stage("Detecting lamp movements", len(samples), "samples")
        comparisons = self._compare(samples, progress)
        middles = np.array(samples.frames[1:], np.int64)
        curve = Curve("background in place", "", middles, comparisons[1].still, np.full(len(middles), self.still))
        candidates = [c for c in self._candidates(comparisons, samples, footage) if self._displaced(c, samples)]
        progress.stage("Timing the movements", len(candidates), "movements")
        found: list[Movement] = []
        for number, candidate in enumerate(candidates):
            until = candidates[number + 1].first if number + 1 < len(candidates) else len(samples) - 1
            earliest = candidates[number - 1].last if number else 0
            found.append(self._timed(candidate, earliest, until, samples, footage))
            progress.advance(number + 1)
        return Detection(tuple(_merged(found)), curve)

    def _compare(self, samples: SampleStore, progress: Progress) -> Mapping[int, Comparison]:
        """Lag -> comparison. Where a camera had no picture, its last one before that counts."""
        steps = max(len(samples) - 1, 0)
        compared = {lag: Comparison(np.full(steps, np.nan), np.full(steps, np.nan)) for lag in self.lags}
        past: dict[str, deque[tuple[int, Template]]] = {c: deque(maxlen=max(self.lags)) for c in samples.cameras}
        for i, sample in enumerate(samples):
            displacements: dict[int, list[Displacement]] = {lag: [] for lag in self.lags}
            for name, picture in sample.pictures.items():
                if picture is None:
                    continue
                now = texture(picture)
                for lag in self.lags:
                    before = next((template for at, template in reversed(past[name]) if at <= i - lag), None)
                    displacement = None if before is None else before.displacement(now)
                    if displacement is not None:
                        displacements[lag].append(displacement)
                past[name].append((i, Template.of([now])))
            for lag, found in displacements.items():
                if found:
                    compared[lag].still[i - 1], compared[lag].highest[i - 1] = self._judged(found, lag)
            progress.advance(i + 1)
        return compared

    def _judged(self, displacements: Sequence[Displacement], lag: int) -> tuple[float, float]:
        """(stillness, highest share of three or more cameras) of one comparison."""
        shares = [share for share in (d.share(IN_PLACE_PX) for d in displacements) if not np.isnan(share)]
        still = stillness(shares)
        if lag > 1:  # heads alone hide much in some seconds: here a displacement must be seen
            moved_px, cameras = second_least_displacement(displacements, least_share=self.still)
            if moved_px > DRIFT_PX and cameras >= 3:
                still = min(still, 0.5 * self.still)
            elif still < self.still and not moved_px > DRIFT_PX:
                still = float("nan")
        return still, max(shares) if len(shares) >= 3 else float("nan")

    def _candidates(
        self, comparisons: Mapping[int, Comparison], samples: SampleStore, footage: Footage
    ) -> list[Candidate]:
        """Where samples differ, in order; of a longer lag only what no shorter one explains."""
        candidates: list[Candidate] = []
        for lag in self.lags:
            still, highest = comparisons[lag].still, comparisons[lag].highest
            added: list[Candidate] = []
            for i in np.flatnonzero(still < self.still).tolist():
                one = Candidate(max(i + 1 - lag, 0), i + 1, lag, float(still[i]), bool(highest[i] < self.still / 4))
                if lag > 1 and any(one.first <= c.last and c.first <= one.last for c in candidates):
                    continue
                if added and one.first <= added[-1].last:
                    added[-1] = added[-1].joined(one)
                else:
                    added.append(one)
            candidates = sorted([*candidates, *added], key=lambda c: c.first)
        return self._join(candidates, comparisons, samples.frames, join_frames=self.join_s * float(footage.rate))

    def _join(
        self,
        candidates: Sequence[Candidate],
        comparisons: Mapping[int, Comparison],
        frames: Sequence[int],
        *,
        join_frames: float,
    ) -> list[Candidate]:
        """Candidates with a short pause between them, or one in which no comparison shows the lamp at rest, are one."""
        joined: list[Candidate] = []
        for candidate in candidates:
            if joined:
                before = joined[-1]
                pause = candidate.first - before.last
                lag = max(lag for lag in self.lags if lag <= max(1, min(3, pause)))
                paused = comparisons[lag].still[before.last + lag - 1 : candidate.first]
                if frames[candidate.first] - frames[before.last] <= join_frames or not (paused >= self.still).any():
                    joined[-1] = before.joined(candidate)
                    continue
            joined.append(candidate)
        return joined

    def _displaced(self, candidate: Candidate, samples: SampleStore, *, around: int = 8) -> bool:
        """Whether the lamp left its position: no sample before shows the same background as any sample after."""
        if candidate.all_lost:
            return True
        before = [_textures(samples, i) for i in range(max(0, candidate.first - around), candidate.first + 1)]
        later = [_textures(samples, i) for i in range(candidate.last, min(len(samples), candidate.last + around + 1))]
        templates = [{name: Template.of([one]) for name, one in textures.items()} for textures in before]
        return not any(self._same(a, b) for a, b in product(templates, later))

    def _same(self, before: Mapping[str, Template], later: Mapping[str, Grey]) -> bool:
        found = [before[name].displacement(later[name]) for name in before.keys() & later.keys()]
        displacements = [displacement for displacement in found if displacement is not None]
        if not stillness([d.share(IN_PLACE_PX) for d in displacements]) >= self.still:
            return False
        return not second_least_displacement(displacements, least_share=self.still)[0] > DRIFT_PX

    def _timed(
        self, candidate: Candidate, earliest: int, latest: int, samples: SampleStore, footage: Footage
    ) -> Movement:
        """The movement's start and stop to the frame, searched between the samples ``earliest`` and ``latest``."""
        frames, rate = samples.frames, float(footage.rate)
        low, high = frames[earliest], frames[latest] if latest < len(frames) - 1 else footage.frames - 1

        def boundary(order: range, bound: int) -> float | None:
            rest, gone = bracket_boundary(_textures(samples, i) for i in order)
            # The slower it is, the farther apart are the frames; keyframes stand for samples half a second off.
            step_s = self.close_s * min(max(1.0, (gone - rest) / 3), 4.0)
            sampling = CloseSampling(footage, samples.cameras, step_s)
            return boundary_time(sampling, frames[order[rest]], frames[order[gone]] + order.step * round(rate), bound)

        start = boundary(range(candidate.first, candidate.last + 1), low)
        stop = boundary(range(candidate.last, candidate.first - 1, -1), high)
        first = frames[candidate.first] if start is None else int(np.floor(start)) + 1
        last = frames[candidate.last] if stop is None else int(np.ceil(stop))
        confidence = round(min(1.0, max(0.0, 1 - float(candidate.least) / self.still)), 3)
        if last <= first:  # the two boundaries contradict each other: what the samples say stands
            return Movement(FrameRange(frames[candidate.first], frames[candidate.last]), 0.5 * confidence)
        return Movement(FrameRange(max(first, 0), min(last, footage.frames)), confidence)


def stillness(shares: Sequence[float]) -> float:
    """How still the lamp is: the second highest of the cameras' shares in place, or half of the highest if larger.

    Parameters
    ----------
    shares
        Each camera's share of the background in place, 0..1; NaN without data.

    Returns
    -------
    float
        0..1, NaN without data.

    Notes
    -----
    Heads before all cameras but one cannot fake a movement, and one stream that has frozen (above `LIVE`) cannot hide
    one.
    """
    known = sorted((s for s in shares if not np.isnan(s)), reverse=True)
    if not known:
        return float("nan")
    return max(known[min(1, len(known) - 1)], 0.5 * known[0] if known[0] < LIVE else 0.0)


def second_least_displacement(displacements: Sequence[Displacement], *, least_share: float) -> tuple[float, int]:
    """The second smallest common displacement of any camera, so that two heads that sway before two fake no drift.

    Parameters
    ----------
    displacements
        One for each camera.
    least_share
        Cameras that find no more of their patches do not count.

    Returns
    -------
    displacement_px, cameras
        NaN where no camera counts, and how many do.
    """
    sizes = sorted(common_sizes(displacements, least_share=least_share))
    return (sizes[min(1, len(sizes) - 1)] if sizes else float("nan")), len(sizes)


def _textures(samples: SampleStore, position: int) -> dict[str, Grey]:
    return {name: texture(p) for name, p in samples[position].pictures.items() if p is not None}


def _merged(movements: Sequence[Movement]) -> list[Movement]:
    """Movements that overlap after timing become one."""
    merged: list[Movement] = []
    for movement in sorted(movements, key=lambda m: m.range):
        if merged and movement.range.start < merged[-1].range.stop:
            joined = FrameRange(merged[-1].range.start, max(merged[-1].range.stop, movement.range.stop))
            merged[-1] = Movement(joined, max(merged[-1].confidence, movement.confidence))
        else:
            merged.append(movement)
    return merged
