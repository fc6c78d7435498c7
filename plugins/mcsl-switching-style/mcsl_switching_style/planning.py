"""The best way to cut a recording under a style's costs, exactly, by dynamic programming.

A shot [j, i) of camera c between borders j < i is worth the sum of c's samples less `long` a frame beyond `most`, and
is at least `least` frames long. A cut at border i from c to d costs `cut` and `leaving[i, c]`; going back, d being the
camera before c, after less than `soon` frames of c costs `back` more. So what a cut costs depends on the camera, on
the one before it and on whether the shot was short: that is the state, and nothing more.
"""

from __future__ import annotations

from math import isfinite

import numpy as np
from numpy.typing import NDArray

from .style import Costs

NONE = -np.inf
EPSILON = 1e-9  # frames: lengths in seconds times a rate are not whole

Values = NDArray[np.float64]
Numbers = NDArray[np.int64]


def best_path(costs: Costs) -> Numbers:
    """(S,) the camera of every sample. A recording shorter than one shot is one shot.

    best[s, p, c]: most worth of [0, borders[i]) whose last shot, of camera c after camera p (p = C: none), may end at
    border i and is short (s = 1) or not (s = 0). Time grows with the samples times those in the longest of `least`,
    `soon` and `most`.
    """
    samples, cameras = costs.value.shape
    shots = _Shots(costs)
    came = np.zeros((samples + 1, cameras, cameras, 2), np.int64)  # (short, camera before) of the shot that a cut ends
    began = np.zeros((samples + 1, 2, cameras + 1, cameras), np.int64)
    best = np.full(began.shape[1:], NONE)
    for i in range(1, samples + 1):
        best, began[i] = shots.ending(i)
        if i < samples:
            entry, came[i] = _entering(i, best, costs)
            shots.enter(i, entry)
    choice = np.zeros(samples, np.int64)
    short, before, camera = np.unravel_index(int(np.argmax(best)), best.shape)
    if best[short, before, camera] == NONE:
        choice[:] = int(np.argmax(costs.value.sum(axis=0)))
        return choice
    at = samples
    while at > 0:
        start = int(began[at, short, before, camera])
        choice[start:at] = camera
        at, camera, after = start, before, camera
        if at > 0:
            short, before = came[at, camera, after]
    return choice


class _Shots:
    """What shots that end at a border are worth, for borders in rising order.

    start[j, p, c]: most worth of [0, borders[j]) with a cut at j from p to c paid for, less all of c's worth up to j.
    Of shots longer than every bound the best beginning stays the best as they grow, so one is kept for all of those.
    """

    def __init__(self, costs: Costs) -> None:
        self.costs = costs
        samples, cameras = costs.value.shape
        self.borders = costs.borders.astype(np.float64)
        self.total = np.vstack([np.zeros(cameras), np.cumsum(costs.value, axis=0)])
        self.start = np.full((samples + 1, cameras + 1, cameras), NONE)
        self.start[0, cameras] = 0.0
        self.long = costs.long if isfinite(costs.most) else 0.0
        self.beyond = max(costs.least, costs.soon, costs.most if isfinite(costs.most) else 0.0) + EPSILON
        self.kept = np.full((cameras + 1, cameras), NONE)
        self.kept_from = np.zeros(self.kept.shape, np.int64)
        self.passed = 0  # borders so far back that a shot from there is longer than every bound

    def enter(self, j: int, entry: Values) -> None:
        """entry: (C, C) most worth of [0, borders[j]) with a cut at j from p to c paid for."""
        self.start[j, :-1] = entry - self.total[j]

    def ending(self, i: int) -> tuple[Values, Numbers]:
        """(2, C + 1, C) best worth of shots that end at border i, not short and short, and where they began."""
        best = np.full((2, *self.kept.shape), NONE)
        began = np.zeros(best.shape, np.int64)
        while self.borders[i] - self.borders[self.passed] > self.beyond:
            fresh = self.start[self.passed] + self.long * self.borders[self.passed]
            better = fresh > self.kept
            self.kept = np.where(better, fresh, self.kept)
            self.kept_from = np.where(better, self.passed, self.kept_from)
            self.passed += 1
        most = self.costs.most if isfinite(self.costs.most) else 0.0
        best[0] = self.kept + self.total[i] - self.long * (self.borders[i] - most)
        began[0] = self.kept_from
        length = self.borders[i] - self.borders[self.passed : i]
        allowed = self.passed + int((length >= self.costs.least - EPSILON).sum())
        long = min(allowed, self.passed + int((length >= self.costs.soon - EPSILON).sum()))
        gain = self.start[self.passed : i] + self.total[i]
        gain = gain - (self.long * np.maximum(length - most, 0.0))[:, None, None]
        for short, first, stop in ((0, self.passed, long), (1, long, allowed)):
            if first < stop:
                part = gain[first - self.passed : stop - self.passed]
                fresh, at = part.max(axis=0), first + part.argmax(axis=0)
                began[short] = np.where(fresh > best[short], at, began[short])
                best[short] = np.maximum(fresh, best[short])
        return best, began


def _entering(i: int, best: Values, costs: Costs) -> tuple[Values, Numbers]:
    """(C, C) best worth with a cut at border i from camera p to c paid for; (short, camera before p) of what ends."""
    cameras = best.shape[2]
    entry = np.full((cameras, cameras), NONE)
    came = np.zeros((cameras, cameras, 2), np.int64)
    for camera in range(cameras):
        for after in range(cameras):
            if after != camera:
                ends = best[:, :, camera].copy()
                ends[1, after] -= costs.back
                short, before = np.unravel_index(int(np.argmax(ends)), ends.shape)
                entry[camera, after] = ends[short, before] - costs.cut - costs.leaving[i, camera]
                came[camera, after] = short, before
    return entry, came
