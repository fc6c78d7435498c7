"""The paper's movement detection: the degree of misalignment (DOM) of correspondences between the cameras.

Section "View Alignment" of the paper, whose symbols stand here: d_DOM (px of the full-size pictures), tau_DOM, m,
N_sub, t_mov, t_hom, d_DOO. It says when the lamp begins to move; how the end of a movement is found, which an analysis
needs too, is told at `_end_of_movement`.
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
class Correspondences:
    """The correspondences between two cameras, over all samples.

    Attributes
    ----------
    sample
        (M,) positions of the samples they come from, rising.
    a, b
        (M, 2) full-size pixels of either camera.
    """

    sample: NDArray[np.int64]
    a: Array
    b: Array


Pair = tuple[str, str]


def homography_inliers(a: Array, b: Array, within_px: float, least: int = 10) -> NDArray[np.bool_]:
    """Which matches are inliers of some homography, by RANSAC.

    Parameters
    ----------
    a, b
        (M, 2) matched points, pixels.
    within_px
        Largest reprojection error of an inlier.
    least
        Fewer inliers than that count as none.

    Returns
    -------
    NDArray
        (M,) bool.

    Notes
    -----
    The paper takes its matches as they are; here 6 of 10 are chance on drapes, and their errors of 100 px and more bury
    every movement (d_DOM 65 to 99 px with and without one).
    """
    if len(a) < least:
        return np.zeros(len(a), bool)
    _, info = poselib.estimate_homography(a, b, {"max_reproj_error": within_px, "seed": 0, "max_iterations": 1000})
    agree = np.asarray(info["inliers"], bool)
    return agree if agree.sum() >= least else np.zeros(len(a), bool)


def degree_of_misalignment(
    correspondences: Mapping[Pair, Correspondences], homographies: Mapping[str, Array], samples: int
) -> Array:
    """d_DOM: the mean of ||H_c->c'(p_c) - p_c'|| over all correspondences of all ordered pairs of cameras.

    Parameters
    ----------
    correspondences
        Of every two cameras.
    homographies
        Camera -> (3, 3) to the reference camera, as calibrated while the lamp stood; H_c->c' follows from two of them.
    samples
        How many there are.

    Returns
    -------
    Array
        (samples,) pixels; NaN where there is no correspondence: no data, never 0.

    References
    ----------
    The paper, section "View Alignment", d_DOM.
    """
    total, count = np.zeros(samples), np.zeros(samples)
    for (a, b), points in correspondences.items():
        if a not in homographies or b not in homographies or not len(points.sample):
            continue
        there = np.asarray(np.linalg.inv(homographies[b]) @ homographies[a], np.float64)
        back = np.asarray(np.linalg.inv(there), np.float64)
        for warp, source, target in ((there, points.a, points.b), (back, points.b, points.a)):
            error = np.hypot(*(transform_points(warp, source) - target).T)
            total += np.bincount(points.sample, error, samples)
            count += np.bincount(points.sample, minlength=samples)
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


def first_exceedance(frames: NDArray[np.int64], above: NDArray[np.bool_], *, within: float, least: int) -> int | None:
    """The first of ``frames`` from which on ``above`` holds ``least`` times or more in ``within`` frames.

    Parameters
    ----------
    frames
        (N,) programme frames, rising.
    above
        (N,) whether d_DOM exceeds tau_DOM.
    within, least
        The paper's m in frames, and its four times.
    """
    over = frames[above]
    counts = np.searchsorted(over, over + within) - np.arange(len(over))
    found = np.flatnonzero(counts >= least)
    return int(over[found[0]]) if len(found) else None


def median_vote(votes: Sequence[int], *, within: float) -> int | None:
    """t_mov: the median of the votes that lie ``within`` frames of the first; None without any."""
    near = [v for v in votes if v - min(votes) < within]
    return int(np.median(near)) if near else None


@frozen
class DegreeOfMisalignment:
    """The paper's movement detector.

    A segment votes for the frame from which on d_DOM exceeds tau_DOM ``times`` or more within m seconds; the median of
    the votes within m seconds is t_mov.

    Parameters
    ----------
    segment_s
        N_sub in seconds.
    hop_s
        m in seconds; every hop a segment begins, the first ones before the recording does, so that each sample lies in
        equally many.
    times
        How often d_DOM must exceed the threshold.
    smooth
        Samples of the moving average.
    clear
        d_DOO below it is clear. The paper gives no number.
    run
        n, clear samples in a row from which homographies are calibrated. The paper gives no number.
    relief
        Share of the diagonal that a correspondence may lie off its sample's plane.
    matcher
        Finds the correspondences.

    Notes
    -----
    Since tau is twice the mean, only segments with the movement in their second half see it; and with several movements
    in ten minutes, which the paper assumes not to be, only some are found.

    References
    ----------
    The paper, section "View Alignment".
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
        """The movements, in order, on the programme clock.

        The curve is the smoothed d_DOM against the calibration of the pose it belongs to.
        """
        progress.stage("Finding points that cameras share", len(samples), "samples")
        correspondences, doo = self._correspondences(samples, footage, progress)
        frames = np.array(samples.frames, np.int64)
        values, bounds = np.full(len(frames), np.nan), np.full(len(frames), np.nan)
        found: list[Movement] = []
        begin = 0
        homographies, used = self._calibrate(correspondences, doo, begin, footage)
        while used is not None:
            dom = degree_of_misalignment(correspondences, homographies, len(frames))
            smoothed, tau, at = self._search_segments(dom, frames, begin, float(footage.rate))
            values[begin:], bounds[begin:] = smoothed[begin:], tau[begin:]
            if at is None:
                break
            homographies, used = self._calibrate(correspondences, doo, at + 1, footage)
            end = len(frames) - 1
            if used is not None:
                dom = degree_of_misalignment(correspondences, homographies, len(frames))
                end = self._end_of_movement(dom, at, used)
            found.append(Movement(FrameRange(int(frames[at]), int(max(frames[end], frames[at] + 1))), 0.5))
            begin = end
        return Detection(tuple(found), Curve("degree of misalignment", "px", frames, values, bounds))

    def _correspondences(
        self, samples: SampleStore, footage: Footage, progress: Progress
    ) -> tuple[dict[Pair, Correspondences], Array]:
        """The correspondences of every two cameras over all samples, and d_DOO at each."""
        pairs = list(combinations(samples.cameras, 2))
        positions: dict[Pair, list[int]] = {pair: [] for pair in pairs}
        points: dict[Pair, list[tuple[Array, Array]]] = {pair: [] for pair in pairs}
        doo, to_full_size = np.full(len(samples), np.nan), {}
        with ThreadPoolExecutor(max_workers=2) as workers:
            for i, sample in enumerate(samples):
                pictures = {name: p for name, p in sample.pictures.items() if p is not None}
                doo[i] = degree_of_occlusion([field_area(p) for p in pictures.values()])
                for name, p in pictures.items():
                    to_full_size.setdefault(name, scaling((p.shape[1], p.shape[0]), footage.camera(name).size))
                features = dict(zip(pictures, workers.map(self.matcher.features, pictures.values()), strict=True))
                for a, b in pairs:
                    if a not in features or b not in features:
                        continue
                    matched = self.matcher.match(features[a], features[b])
                    points_a = features[a].points[matched[:, 0]].astype(np.float64)
                    points_b = features[b].points[matched[:, 1]].astype(np.float64)
                    within_px = self.relief * float(np.hypot(*features[b].size))
                    kept = homography_inliers(points_a, points_b, within_px)
                    positions[a, b] += [i] * int(kept.sum())
                    points[a, b].append((points_a[kept], points_b[kept]))
                progress.advance(i + 1)
        found = {}
        for (a, b), pieces in points.items():
            if pieces:
                all_a, all_b = (np.concatenate(side) for side in zip(*pieces, strict=True))
                all_a, all_b = transform_points(to_full_size[a], all_a), transform_points(to_full_size[b], all_b)
                found[a, b] = Correspondences(np.array(positions[a, b], np.int64), all_a, all_b)
        return found, doo

    def _calibrate(
        self, correspondences: Mapping[Pair, Correspondences], doo: Array, begin: int, footage: Footage
    ) -> tuple[Mapping[str, Array], NDArray[np.int64] | None]:
        """(homographies to the reference camera, t_hom: the samples they are calibrated from).

        The first run of clear samples that begins within a minute from ``begin`` on, else the clearest run of that
        minute: a later one may belong to another pose. (.., None) where nothing is left.
        """
        known = np.nan_to_num(doo, nan=np.inf)
        starts = range(begin, min(begin + 60, len(doo) - self.run + 1))
        if not starts:
            return {}, None
        worst = np.array([known[i : i + self.run].max() for i in starts])
        clear = np.flatnonzero(worst < self.clear)
        first = starts[int(clear[0] if len(clear) else worst.argmin())]
        used = np.arange(first, first + self.run)
        pooled = {}
        for pair, points in correspondences.items():
            inside = [points.sample == i for i in used]
            pooled[pair] = pool([(points.a[k], points.b[k], np.ones(int(k.sum()))) for k in inside])
        sizes = {c.name: c.size for c in footage.cameras}
        return JointPlane().align(pooled, sizes, footage.cameras[0].name).homographies, used

    def _search_segments(
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
            vote = first_exceedance(frames[inside], smoothed[inside] > tau, within=hop, least=self.times)
            if vote is not None:
                votes.append(vote)
            for i in inside:
                taus[i].append(tau)
            start += hop
        elect = median_vote(votes, within=hop)
        at = None if elect is None else int(np.searchsorted(frames, elect))
        return smoothed, np.array([np.median(t) if t else np.nan for t in taus]), at

    def _end_of_movement(self, dom: Array, at: int, used: NDArray[np.int64]) -> int:
        """The position from which on the lamp stands again.

        Walking back from t_hom, how long d_DOM against the new calibration stays as small as at t_hom (twice its median
        there, at least a pixel more).
        """
        usual = float(np.nanmedian(dom[used])) if not np.isnan(dom[used]).all() else 0.0
        bound = max(2 * usual, usual + 1)
        dom = moving_average(without_outliers(dom), 3)
        end = int(used[0])
        while end - 1 > at and not dom[end - 1] > bound:
            end -= 1
        return max(end, at + 1)
