"""The paper's way of finding lamp movements: the degree of misalignment of points that the cameras share.

Section "View Alignment" of the paper, whose symbols stand here: d_DOM (px of the full-size pictures), tau_DOM, m,
N_sub, t_mov, t_hom, d_DOO. It says when the lamp begins to move; where it stands again, which an analysis needs too, is
told at `_settled`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import combinations

import numpy as np
import poselib
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.alignment.clear_frames import degree_of_occlusion, field_area
from mcsl_core.alignment.correspondences import pool
from mcsl_core.alignment.features import RootSift
from mcsl_core.alignment.joint import JointPlane
from mcsl_core.edl import Movement
from mcsl_core.imaging.geometry import scaling, transform_points
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.timing import FrameRange

from .protocol import Curve, Detection

Array = NDArray[np.float64]


@frozen(eq=False)
class Shared:
    """The points that two cameras share, over all samples. moment: (M,) rising positions of samples; a, b: (M, 2)
    full-size pixels of either camera."""

    moment: NDArray[np.int64]
    a: Array
    b: Array


Pair = tuple[str, str]


def corresponding(a: Array, b: Array, within_px: float, least: int = 10) -> NDArray[np.bool_]:
    """(M,) which of the matched points a, b (M, 2) correspond: those that agree on some homography ``within_px``; none
    where fewer than ``least`` do.

    The paper takes its matches as they are; here 6 of 10 are chance on drapes, and their errors of 100 px and more bury
    every movement (d_DOM 65 to 99 px with and without one).
    """
    if len(a) < least:
        return np.zeros(len(a), bool)
    _, info = poselib.estimate_homography(a, b, {"max_reproj_error": within_px, "seed": 0, "max_iterations": 1000})
    agree = np.asarray(info["inliers"], bool)
    return agree if agree.sum() >= least else np.zeros(len(a), bool)


def degree_of_misalignment(shared: Mapping[Pair, Shared], homographies: Mapping[str, Array], moments: int) -> Array:
    """(moments,) d_DOM: the mean of ||H_c->c'(p_c) - p_c'|| over all correspondences of all ordered pairs of cameras.

    homographies: camera -> 3x3, to the reference camera, as calibrated while the lamp stood; H_c->c' follows from two
    of them. NaN where no correspondence is found: no data, never 0.
    """
    total, count = np.zeros(moments), np.zeros(moments)
    for (a, b), points in shared.items():
        if a not in homographies or b not in homographies or not len(points.moment):
            continue
        there = np.asarray(np.linalg.inv(homographies[b]) @ homographies[a], np.float64)
        back = np.asarray(np.linalg.inv(there), np.float64)
        for warp, source, target in ((there, points.a, points.b), (back, points.b, points.a)):
            error = np.hypot(*(transform_points(warp, source) - target).T)
            total += np.bincount(points.moment, error, moments)
            count += np.bincount(points.moment, minlength=moments)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def threshold(dom: Array) -> float:
    """tau_DOM = min(max(d) + 1, 2 mean(d)) over a segment's values; NaN without data."""
    known = dom[~np.isnan(dom)]
    return float(min(known.max() + 1, 2 * known.mean())) if len(known) else float("nan")


def without_outliers(dom: Array) -> Array:
    """``dom`` with NaN where an isolation forest (Liu et al., ICDM 2008; scikit-learn's own settings) isolates it."""
    from sklearn.ensemble import IsolationForest  # half a second to import, and only needed here

    known = np.flatnonzero(~np.isnan(dom))
    if len(known) < 8:
        return dom
    inlier = IsolationForest(random_state=0).fit_predict(dom[known, None]) > 0
    kept = np.full_like(dom, np.nan)
    kept[known[inlier]] = dom[known[inlier]]
    return kept


def moving_average(values: Array, width: int) -> Array:
    """The mean over ``width`` samples about each, of those with data; NaN where none of them has any."""
    if not len(values):
        return values
    kernel, about = np.ones(width), slice(width // 2, width // 2 + len(values))
    count = np.convolve(~np.isnan(values), kernel)[about]
    total = np.convolve(np.nan_to_num(values), kernel)[about]
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def rise(frames: NDArray[np.int64], above: NDArray[np.bool_], *, within: float, least: int) -> int | None:
    """The first of ``frames`` from which on ``above`` holds ``least`` times or more within ``within`` frames."""
    over = frames[above]
    counts = np.searchsorted(over, over + within) - np.arange(len(over))
    found = np.flatnonzero(counts >= least)
    return int(over[found[0]]) if len(found) else None


def elected(votes: Sequence[int], *, within: float) -> int | None:
    """t_mov: the median of the votes that lie ``within`` frames of the first; None without any."""
    near = [v for v in votes if v - min(votes) < within]
    return int(np.median(near)) if near else None


@frozen
class DegreeOfMisalignment:
    """The paper's movement detector.

    segment_s: N_sub in seconds. hop_s: m; every hop a segment begins, the first ones before the recording does, so that
    each moment lies in equally many. A segment votes for the frame from which on d_DOM exceeds tau_DOM ``times`` or
    more within m seconds; the median of the votes within m seconds is t_mov. smooth: samples of the average. clear:
    d_DOO below it is clear. run: n, clear samples in a row from which homographies are calibrated (the paper gives no
    number for these two). relief: share of the diagonal that a correspondence may lie off its moment's plane.

    Since tau is twice the mean, only segments with the movement in their second half see it; and with several movements
    in ten minutes, which the paper assumes not to be, only some are found.
    """

    segment_s: float = field(default=600.0)
    hop_s: float = field(default=75.0)
    times: int = field(default=4)
    smooth: int = field(default=9)
    clear: float = field(default=0.5)
    run: int = field(default=4)
    relief: float = field(default=0.02)
    matcher: RootSift = field(factory=lambda: RootSift(max_features=600))
    name = "paper"

    def detect(self, samples: SampleStore, footage: Footage, progress: Progress) -> Detection:
        """The movements, in order, on the programme clock; the curve is the smoothed d_DOM against the calibration of
        the pose it belongs to."""
        progress.stage("Finding points that cameras share", len(samples), "samples")
        shared, doo = self._look(samples, footage, progress)
        frames = np.array(samples.frames, np.int64)
        values, bounds = np.full(len(frames), np.nan), np.full(len(frames), np.nan)
        found: list[Movement] = []
        begin = 0
        homographies, used = self._calibrated(shared, doo, begin, footage)
        while used is not None:
            dom = degree_of_misalignment(shared, homographies, len(frames))
            smoothed, tau, at = self._searched(dom, frames, begin, float(footage.rate))
            values[begin:], bounds[begin:] = smoothed[begin:], tau[begin:]
            if at is None:
                break
            homographies, used = self._calibrated(shared, doo, at + 1, footage)
            end = len(frames) - 1
            if used is not None:
                end = self._settled(degree_of_misalignment(shared, homographies, len(frames)), at, used)
            found.append(Movement(FrameRange(int(frames[at]), int(max(frames[end], frames[at] + 1))), 0.5))
            begin = end
        return Detection(tuple(found), Curve("degree of misalignment", "px", frames, values, bounds))

    def _look(self, samples: SampleStore, footage: Footage, progress: Progress) -> tuple[dict[Pair, Shared], Array]:
        """What every two cameras share at every sample, and d_DOO there."""
        pairs = list(combinations(samples.cameras, 2))
        moments: dict[Pair, list[int]] = {pair: [] for pair in pairs}
        points: dict[Pair, list[tuple[Array, Array]]] = {pair: [] for pair in pairs}
        doo, grow = np.full(len(samples), np.nan), {}
        with ThreadPoolExecutor(max_workers=2) as workers:
            for i, moment in enumerate(samples):
                seen = {name: p for name, p in moment.pictures.items() if p is not None}
                doo[i] = degree_of_occlusion([field_area(p) for p in seen.values()])
                for name, p in seen.items():
                    grow.setdefault(name, scaling((p.shape[1], p.shape[0]), footage.camera(name).size))
                features = dict(zip(seen, workers.map(self.matcher.features, seen.values()), strict=True))
                for a, b in pairs:
                    if a not in features or b not in features:
                        continue
                    matched = self.matcher.match(features[a], features[b])
                    here, there = (features[n].points[matched[:, k]].astype(np.float64) for k, n in enumerate((a, b)))
                    kept = corresponding(here, there, self.relief * float(np.hypot(*features[b].size)))
                    moments[a, b] += [i] * int(kept.sum())
                    points[a, b].append((here[kept], there[kept]))
                progress.advance(i + 1)
        return {
            (a, b): Shared(
                np.array(moments[a, b], np.int64),
                transform_points(grow[a], np.concatenate([p for p, _ in points[a, b]])),
                transform_points(grow[b], np.concatenate([p for _, p in points[a, b]])),
            )
            for a, b in pairs
            if points[a, b]
        }, doo

    def _calibrated(
        self, shared: Mapping[Pair, Shared], doo: Array, begin: int, footage: Footage
    ) -> tuple[Mapping[str, Array], NDArray[np.int64] | None]:
        """(homographies to the reference, t_hom: the samples they are calibrated from): the first run of clear samples
        that begins within a minute from ``begin`` on, else the clearest run of that minute: a later one may belong to
        another pose. (.., None) where nothing is left."""
        known = np.nan_to_num(doo, nan=np.inf)
        starts = range(begin, min(begin + 60, len(doo) - self.run + 1))
        if not starts:
            return {}, None
        worst = np.array([known[i : i + self.run].max() for i in starts])
        clear = np.flatnonzero(worst < self.clear)
        first = starts[int(clear[0] if len(clear) else worst.argmin())]
        used = np.arange(first, first + self.run)
        pooled = {}
        for pair, points in shared.items():
            inside = [points.moment == i for i in used]
            pooled[pair] = pool([(points.a[k], points.b[k], np.ones(int(k.sum()))) for k in inside])
        sizes = {c.name: c.size for c in footage.cameras}
        return JointPlane().align(pooled, sizes, footage.cameras[0].name).homographies, used

    def _searched(
        self, dom: Array, frames: NDArray[np.int64], begin: int, rate: float
    ) -> tuple[Array, Array, int | None]:
        """(smoothed d_DOM, tau_DOM, the position of t_mov or None) from sample ``begin`` on."""
        segment, hop = self.segment_s * rate, self.hop_s * rate
        dom = np.where(np.arange(len(dom)) < begin, np.nan, dom)
        smoothed = moving_average(without_outliers(dom), self.smooth)
        smoothed[:begin] = np.nan
        votes: list[int] = []
        taus: list[list[float]] = [[] for _ in frames]
        start = float(frames[begin]) - segment + hop
        while start <= frames[-1]:
            inside = np.arange(len(frames))[(frames >= max(start, frames[begin])) & (frames < start + segment)]
            tau = threshold(smoothed[inside])
            vote = rise(frames[inside], smoothed[inside] > tau, within=hop, least=self.times)
            if vote is not None:
                votes.append(vote)
            for i in inside:
                taus[i].append(tau)
            start += hop
        elect = elected(votes, within=hop)
        at = None if elect is None else int(np.searchsorted(frames, elect))
        return smoothed, np.array([np.median(t) if t else np.nan for t in taus]), at

    def _settled(self, dom: Array, at: int, used: NDArray[np.int64]) -> int:
        """The position from which on the lamp stands again: walking back from t_hom, how long d_DOM against the new
        calibration stays as small as at t_hom (twice its median there, at least a pixel more)."""
        usual = float(np.nanmedian(dom[used])) if not np.isnan(dom[used]).all() else 0.0
        bound = max(2 * usual, usual + 1)
        dom = moving_average(without_outliers(dom), 3)
        end = int(used[0])
        while end - 1 > at and not dom[end - 1] > bound:
            end -= 1
        return max(end, at + 1)
