"""The programme's perspective across movements: a new pose tied to an earlier one, where they show enough of the same.

Full-size pixels. An anchor maps reference camera pixels of its pose to programme pixels.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.imaging.geometry import scaling, size_at_columns, to_edl_matrix, transform_points
from mcsl_core.imaging.masks import convex_hull, resize_mask
from mcsl_core.progress import Progress
from mcsl_core.recording.sample_store import SampleStore

from .correspondences import Correspondences
from .dense_matching import PlacedCamera, match_densely
from .joint import fit_homography, fit_pair
from .observations import SolvedPose, field_in_camera, match_cameras, weight_matches
from .protocol import Matcher
from .settings import SolveSettings

Array = NDArray[np.float64]


def anchor(
    solved: SolvedPose,
    earlier: Sequence[SolvedPose],
    samples: SampleStore,
    *,
    matcher: Matcher,
    settings: SolveSettings,
    progress: Progress,
) -> SolvedPose:
    """``solved`` with the anchor that keeps the perspective of ``earlier``, the poses before it, or with a new one.

    It is tied to the pose that began the perspective, so that errors do not add up over movements; where that shows too
    little of the same, to the one just before.
    """
    if not earlier:
        return solved
    current = earlier[-1].pose.perspective
    began = next(e for e in earlier if e.pose.perspective == current)
    reason = "too little in common with the view before"
    for before in dict.fromkeys((began, earlier[-1])):
        tie = _tie(solved, before, samples, matcher, settings)
        if tie is None:
            continue
        to_programme = np.array(before.pose.anchor) @ tie
        shown = _shown(solved, to_programme)
        if shown >= settings.least_shown:
            pose = attrs.evolve(solved.pose, anchor=to_edl_matrix(to_programme), perspective=current)
            return attrs.evolve(solved, pose=pose)
        reason = f"the view before shows only {shown:.0%} of the field"
    progress.note(f"frames {solved.pose.range}: {reason}; a new perspective begins")
    return attrs.evolve(solved, pose=attrs.evolve(solved.pose, perspective=current + 1))


def _tie(
    now: SolvedPose, before: SolvedPose, samples: SampleStore, matcher: Matcher, settings: SolveSettings
) -> Array | None:
    """Reference pixel of ``now`` -> reference pixel of ``before``, by all cameras together; None without a tie."""
    names = sorted(now.scene.homographies.keys() & before.scene.homographies.keys() & now.evidence.keys())
    matches: dict[str, Correspondences] = {}
    ways: dict[str, tuple[int, Array]] = {}
    for name in names:
        if name not in before.evidence:
            continue
        size = now.scene.camera_sizes[name]
        pair = match_cameras(now.evidence[name], before.evidence[name], size, size, matcher, settings, every=True)
        shape = now.evidence[name].field.shape
        fields = {"now": field_in_camera(now.scene, name, shape), "before": field_in_camera(before.scene, name, shape)}
        pair = weight_matches(pair, {"now": size, "before": size}, "now", "before", fields, settings)
        fit = fit_pair(pair, size, size, settings.alignment)
        if fit is not None:
            h_now, h_before = now.scene.homographies[name], before.scene.homographies[name]
            ways[name] = fit.support, h_before @ fit.homography @ np.linalg.inv(h_now)
            matches[name] = Correspondences(
                transform_points(h_now, fit.kept.a),
                transform_points(h_before, fit.kept.b),
                fit.kept.weight,
                fit.kept.seen,
            )
    if not ways:
        return None
    diagonal = float(np.hypot(*before.scene.camera_sizes[before.scene.reference]))
    first = _agreed(ways, matches, settings.alignment.relief * diagonal)
    return _by_spots(now, before, names, first, samples, settings)


def _agreed(ways: Mapping[str, tuple[int, Array]], matches: Mapping[str, Correspondences], bound_px: float) -> Array:
    """The way from now to before, offered by one camera, that the matches of most others agree with."""

    def agreement(way: Array) -> int:
        off = {n: float(np.median(np.hypot(*(transform_points(way, m.a) - m.b).T))) for n, m in matches.items()}
        return sum(ways[n][0] for n, px in off.items() if px < bound_px)

    return ways[max(sorted(ways), key=lambda name: agreement(ways[name][1]))][1]


def _by_spots(
    now: SolvedPose,
    before: SolvedPose,
    names: Sequence[str],
    first: Array,
    samples: SampleStore,
    settings: SolveSettings,
) -> Array:
    """``first`` refined by every spot of the field, over all cameras; ``first`` itself where too few agree."""
    size = before.scene.camera_sizes[before.scene.reference]
    dense_size = size_at_columns(size, settings.dense_width)
    to_scene = scaling(size, dense_size)
    place = convex_hull(resize_mask(before.scene.field, dense_size))
    a: list[Array] = []
    b: list[Array] = []
    weights: list[Array] = []
    for name in names:
        h_now, h_before = now.scene.homographies[name], before.scene.homographies[name]
        full = now.scene.camera_sizes[name]
        views = {
            "before": PlacedCamera([samples.picture(i, name) for i in before.moments], to_scene @ h_before, full),
            "now": PlacedCamera([samples.picture(i, name) for i in now.moments], to_scene @ first @ h_now, full),
        }
        for matches in match_densely(views, place, settings.dense).values():
            a.append(transform_points(h_now, matches.b))
            b.append(transform_points(h_before, matches.a))
            weights.append(matches.weight)
    if sum(map(len, weights)) < 40:
        return first
    weight = np.concatenate(weights)
    pooled = Correspondences(np.concatenate(a), np.concatenate(b), weight, np.ones(len(weight), np.int64))
    refined = fit_homography(pooled, first)
    return first if refined is None else refined


def _shown(solved: SolvedPose, to_programme: Array) -> float:
    """The share of the pose's field that lies in the programme's picture and is neither dwarfed nor blown up."""
    size = solved.scene.camera_sizes[solved.scene.reference]
    spots = np.argwhere(solved.scene.field)[:, ::-1].astype(np.float64)
    at = transform_points(scaling(solved.scene.size, size), spots)
    moved = transform_points(to_programme, at)
    area = float(cv2.contourArea(cv2.convexHull(at.astype(np.float32))))
    grown = float(cv2.contourArea(cv2.convexHull(moved.astype(np.float32)))) / max(area, 1.0)
    inside = ((moved >= 0) & (moved < size)).all(axis=1)
    return float(inside.mean()) if 0.15 < grown < 6 else 0.0
