"""When the lamp moves. All cameras sit on one lamp: they start and stop together.

`stillness` asks whether each camera's static background still lies where it lay. Heads and hands cover parts of a
view; a movement of the lamp leaves no part of any view where it was.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from .edl import Movement
from .footage import Footage
from .progress import Progress
from .samples import SAMPLE_HEIGHT, Samples
from .scores import Curve, Detection
from .timing import FrameRange

Grey = NDArray[np.float32]


def texture(picture: NDArray[np.uint8]) -> Grey:
    """The picture's fine structure: grey, free of slow shading, so that a change of light does not count."""
    grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY).astype(np.float32)
    fine = cv2.GaussianBlur(grey, (0, 0), 1.2)  # sensor noise and coding below, what is seen above
    return fine - cv2.GaussianBlur(grey, (0, 0), 5)  # pyright: ignore[reportReturnType]


def share_in_place(before: Grey, after: Grey, *, patch_px: int = 21, contrast: float = 1.2) -> float:
    """The share of textured patches of ``before`` that lie unchanged at the same place in ``after``: 0..1, or NaN.

    A patch is unchanged when its normalised correlation at zero displacement is above 0.7. NaN (no data) where
    fewer than 40 patches have texture.
    """
    box = (patch_px, patch_px)
    mean_b, mean_a = cv2.blur(before, box), cv2.blur(after, box)
    var_b = cv2.blur(before * before, box) - mean_b * mean_b
    var_a = cv2.blur(after * after, box) - mean_a * mean_a
    covariance = cv2.blur(before * after, box) - mean_b * mean_a
    step = patch_px // 2
    grid = (slice(step, -step, step), slice(step, -step, step))
    textured = var_b[grid] > contrast**2
    if int(textured.sum()) < 40:
        return float("nan")
    correlation = covariance[grid] / np.sqrt(np.maximum(var_b[grid] * var_a[grid], 1e-6))
    return float((correlation[textured] > 0.7).mean())


def stillness(shares: Sequence[float]) -> float:
    """How still the lamp is, from every camera's share in place: the second highest, so that one view that a bare
    sheet or a frozen stream fills cannot hide a movement, and heads before all but two cannot fake one."""
    known = sorted((s for s in shares if not np.isnan(s)), reverse=True)
    if not known:
        return float("nan")
    return known[min(1, len(known) - 1)]


@frozen
class Stillness:
    """Whether each camera's static background still lies where it lay. All cameras start and stop together.

    still: with at least this share of the background in place the lamp stands. Between samples a stretch below it
    is looked at closely, ``close_s`` apart, for the frame at which it starts and stops; ``looks_gone`` of these in a
    row must differ. Movements less than ``join_s`` apart are one.
    """

    still: float = field(default=0.12)
    close_s: float = field(default=0.1)
    join_s: float = field(default=2.0)
    looks_gone: int = field(default=4)
    name = "stillness"

    def detect(self, samples: Samples, footage: Footage, progress: Progress) -> Detection:
        """The movements, in order, on the programme clock."""
        progress.stage("Looking for lamp movements", len(samples), "samples")
        coarse = self._coarse(samples, progress)
        spans = self._spans(coarse, samples.frames, join_frames=self.join_s * float(footage.rate))
        progress.stage("Timing the movements", len(spans), "movements")
        found = []
        for number, (first, last) in enumerate(spans):
            found.append(self._time(first, last, coarse, samples, footage))
            progress.advance(number + 1)
        middles = np.array(samples.frames[1:], np.int64)
        curve = Curve("background in place", "", middles, coarse, np.full(len(middles), self.still))
        return Detection(tuple(_apart(found)), curve)

    def _coarse(self, samples: Samples, progress: Progress) -> NDArray[np.float64]:
        """(S - 1,) stillness between neighbouring samples; NaN where nothing can be said."""
        values = np.full(max(len(samples) - 1, 0), np.nan)
        before: dict[str, Grey] = {}
        for i, moment in enumerate(samples):
            now = {name: texture(p) for name, p in moment.pictures.items() if p is not None}
            if i:
                values[i - 1] = stillness([share_in_place(before[n], now[n]) for n in now if n in before])
            before = now
            progress.advance(i + 1)
        return values

    def _spans(
        self, coarse: NDArray[np.float64], frames: Sequence[int], *, join_frames: float
    ) -> list[tuple[int, int]]:
        """(first, last) positions of samples between which the lamp moves; neighbours closer than a pause joined."""
        spans: list[tuple[int, int]] = []
        for i in np.flatnonzero(coarse < self.still).tolist():
            if spans and frames[i] - frames[spans[-1][1]] <= join_frames:
                spans[-1] = (spans[-1][0], i + 1)
            else:
                spans.append((i, i + 1))
        return spans

    def _time(self, first: int, last: int, coarse: NDArray[np.float64], samples: Samples, footage: Footage) -> Movement:
        """Start and stop to about ``close_s``: the last frame that matches the view before, the first that matches
        the view after. Each camera says its own; the median counts."""
        step = max(1, round(self.close_s * float(footage.rate)))
        begin, end = samples.frames[max(first - 1, 0)], samples.frames[min(last + 1, len(samples) - 1)]
        frames = list(range(begin, end + 1, step))
        starts, stops = [], []
        for camera in samples.cameras:
            close = {
                frame: texture(picture)
                for frame, picture in footage.pictures(camera, frames, height=SAMPLE_HEIGHT)
                if picture is not None
            }
            if len(close) < 3:
                continue
            start = self._departure(close, sorted(close))
            stop = self._departure(close, sorted(close, reverse=True))
            if start is not None and stop is not None and start < stop:
                starts.append(start)
                stops.append(stop)
        lowest = float(np.nanmin(coarse[first:last]))
        confidence = round(min(1.0, max(0.0, 1 - lowest / self.still)), 3)
        if not starts:
            return Movement(FrameRange(samples.frames[first], samples.frames[last]), 0.5 * confidence)
        start, stop = int(np.median(starts)), int(np.median(stops))
        return Movement(FrameRange(start, max(stop, start + 1)), confidence)

    def _departure(self, close: Mapping[int, Grey], order: Sequence[int]) -> int | None:
        """The last frame along ``order`` before the standing view at its beginning is left for good."""
        standing = close[order[0]]
        shares = np.array([share_in_place(standing, close[frame]) for frame in order])
        if np.isnan(shares).any() or len(shares) < 3:
            return None
        usual = float(np.median(shares[1:4]))
        if usual < 2 * self.still:
            return None
        gone = shares < 0.5 * usual
        for i in range(1, len(order)):
            if gone[i : i + self.looks_gone].all():  # for good, not a hand passing
                return order[i - 1]
        return None


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
