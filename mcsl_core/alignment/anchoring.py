"""The programme's perspective across movements: a new pose tied to an earlier one, where they show enough of the same.

Full-size pixels. An anchor maps reference camera pixels of its pose to programme pixels.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs
import cv2
import numpy as np

from mcsl_core.imaging.geometry import Array, scaling, size_at_columns, to_edl_matrix, transform_points
from mcsl_core.imaging.masks import convex_hull, resize_mask
from mcsl_core.progress import Progress

from .correspondences import Correspondences
from .dense_matching import AlignedCamera, match_densely
from .field import field_in_camera
from .joint import fit_homography, fit_pair
from .observations import Samples, SolvedPose, match_cameras, weight_matches
from .protocol import Matcher
from .settings import SolveSettings

_LEAST_DENSE = 40  # dense matches, over all cameras, below which the distinctive points alone decide


def anchor(
    solved: SolvedPose,
    earlier: Sequence[SolvedPose],
    samples: Samples,
    *,
    matcher: Matcher,
    settings: SolveSettings,
    progress: Progress,
) -> SolvedPose:
    """Anchors a pose to those before it.

    Parameters
    ----------
    solved : SolvedPose
        The pose, in its own perspective.
    earlier : sequence of SolvedPose
        The poses before it in order of time, anchored.
    samples : Samples
        What pictures are read from.
    matcher : Matcher
        What matches a camera's points across the movement.
    settings : SolveSettings
        ``least_shown`` says when a perspective is given up.
    progress : Progress
        Told where a new perspective begins, and why.

    Returns
    -------
    SolvedPose
        ``solved`` with the anchor that keeps the perspective of ``earlier``, or with a new perspective.

    Notes
    -----
    It is tied to the pose that began the perspective, so that errors do not add up over movements; where that shows too
    little of the same, to the one just before.
    """
    if not earlier:
        return solved
    current = earlier[-1].pose.perspective
    began = next(pose for pose in earlier if pose.pose.perspective == current)
    reason = "too little in common with the view before"
    for before in dict.fromkeys((began, earlier[-1])):
        tie = _tie(solved, before, samples, matcher, settings)
        if tie is None:
            continue
        to_programme = np.array(before.pose.anchor) @ tie
        shown = _share_shown(solved, to_programme)
        if shown >= settings.least_shown:
            pose = attrs.evolve(solved.pose, anchor=to_edl_matrix(to_programme), perspective=current)
            return attrs.evolve(solved, pose=pose)
        reason = f"the view before shows only {shown:.0%} of the field"
    progress.note(f"frames {solved.pose.range}: {reason}; a new perspective begins")
    return attrs.evolve(solved, pose=attrs.evolve(solved.pose, perspective=current + 1))


def _tie(
    now: SolvedPose, before: SolvedPose, samples: Samples, matcher: Matcher, settings: SolveSettings
) -> Array | None:
    """Reference pixel of ``now`` -> reference pixel of ``before``, by all cameras together; None without a tie."""
    common = now.aligned.homographies.keys() & before.aligned.homographies.keys() & now.observations.keys()
    names = sorted(common)
    matches: dict[str, Correspondences] = {}
    offers: dict[str, tuple[int, Array]] = {}
    for name in names:
        if name not in before.observations:
            continue
        size, own = now.aligned.camera_sizes[name], now.observations[name]
        pair = match_cameras(own, before.observations[name], size, size, matcher, settings, every=True)
        field_now = field_in_camera(now.aligned, name, own.field.shape)
        field_before = field_in_camera(before.aligned, name, own.field.shape)
        pair = weight_matches(pair, size, size, field_now, field_before, settings)
        fit = fit_pair(pair, size, size, settings.alignment)
        if fit is not None:
            h_now, h_before = now.aligned.homographies[name], before.aligned.homographies[name]
            offers[name] = fit.support, h_before @ fit.homography @ np.linalg.inv(h_now)
            matches[name] = Correspondences(
                transform_points(h_now, fit.kept.a),
                transform_points(h_before, fit.kept.b),
                fit.kept.weight,
                fit.kept.seen,
            )
    if not offers:
        return None
    diagonal = float(np.hypot(*before.aligned.camera_sizes[before.aligned.reference]))
    first = _agreed(offers, matches, settings.alignment.relief * diagonal)
    return _refined_densely(first, now, before, names, samples, settings)


def _agreed(offers: Mapping[str, tuple[int, Array]], matches: Mapping[str, Correspondences], bound_px: float) -> Array:
    """Of the homographies that the cameras offer, with their support, the one that most others' matches agree with."""

    def agreement(homography: Array) -> int:
        total = 0
        for name, (support, _) in offers.items():
            off = transform_points(homography, matches[name].a) - matches[name].b
            if float(np.median(np.hypot(off[:, 0], off[:, 1]))) < bound_px:
                total += support
        return total

    best = max(sorted(offers), key=lambda name: agreement(offers[name][1]))
    _, homography = offers[best]
    return homography


def _refined_densely(
    first: Array,
    now: SolvedPose,
    before: SolvedPose,
    names: Sequence[str],
    samples: Samples,
    settings: SolveSettings,
) -> Array:
    """``first`` refined by dense matching over the field, over all cameras; ``first`` itself where too few agree."""
    size = before.aligned.camera_sizes[before.aligned.reference]
    dense_size = size_at_columns(size, settings.dense_width)
    to_aligned = scaling(size, dense_size)
    area = convex_hull(resize_mask(before.aligned.field, dense_size))
    a: list[Array] = []
    b: list[Array] = []
    weights: list[Array] = []
    for name in names:
        h_now, h_before = now.aligned.homographies[name], before.aligned.homographies[name]
        full = now.aligned.camera_sizes[name]
        pictures_before = [samples.picture(i, name) for i in before.samples]
        pictures_now = [samples.picture(i, name) for i in now.samples]
        cameras = {
            "before": AlignedCamera.by_plane(pictures_before, to_aligned @ h_before, full, dense_size),
            "now": AlignedCamera.by_plane(pictures_now, to_aligned @ first @ h_now, full, dense_size),
        }
        for matches in match_densely(cameras, area, settings.dense).values():
            a.append(transform_points(h_now, matches.b))
            b.append(transform_points(h_before, matches.a))
            weights.append(matches.weight)
    if sum(map(len, weights)) < _LEAST_DENSE:
        return first
    weight = np.concatenate(weights)
    pooled = Correspondences(np.concatenate(a), np.concatenate(b), weight, np.ones(len(weight), np.int64))
    refined = fit_homography(pooled, first)
    return first if refined is None else refined


def _share_shown(solved: SolvedPose, to_programme: Array) -> float:
    """The share of the pose's field that lies in the programme's picture and is neither dwarfed nor blown up."""
    size = solved.aligned.camera_sizes[solved.aligned.reference]
    pixels = np.argwhere(solved.aligned.field)[:, ::-1].astype(np.float64)
    points = transform_points(scaling(solved.aligned.size, size), pixels)
    moved = transform_points(to_programme, points)
    area = float(cv2.contourArea(cv2.convexHull(points.astype(np.float32))))
    grown = float(cv2.contourArea(cv2.convexHull(moved.astype(np.float32)))) / max(area, 1.0)
    inside = ((moved >= 0) & (moved < size)).all(axis=1)
    return float(inside.mean()) if 0.15 < grown < 6 else 0.0
