"""Alignment by calibration, as in the paper: cameras and places in space, the surgical field's plane among them, and
for each camera the homography that this plane induces to the reference camera.

From the pooled matches of camera pairs to tracks, one a place; from two cameras to all by pose and triangulation;
bundle adjustment over everything (pycolmap). The lamp's cameras are of one make: one focal length for all, square
pixels, the principal point in the middle. A scene that is nearly flat leaves the focal length open and may even turn
the views inside out, so several focal lengths are tried and the one that leaves the least is taken.

Pixels are full-size with centres at integers; space is the reference camera's own, of arbitrary scale.

pycolmap is imported where it is used, not with the package: its logging library takes over SIGTERM, and every `mcsl`
process imports its plugins.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.hooks import Alignment, Correspondences, Weak, hookimpl, transform_points

from .calibration import Calibration, calibrate, project
from .tracks import CELL_PX, Array, CalibrationSettings, Tracks, build_tracks, true_matches

# ---------------------------------------------------------------------------------------------------------- the plane


def fit_plane(places: Array, weight: Array, rounds: int = 10) -> Array:
    """n with n . X = 1 for the plane through places of one camera's space, robustly (Huber at 5 medians).

    Fitted to inverse depths, which are affine over the picture and in which pixels of parallax are counted.
    """
    inverse = 1 / places[:, 2]
    rows = np.column_stack([places[:, :2] * inverse[:, None], np.ones(len(places))])
    factor = np.ones(len(places))
    normal: Any = np.zeros(3)
    for _ in range(rounds):
        root = np.sqrt(weight * factor)
        normal = np.linalg.lstsq(rows * root[:, None], inverse * root, rcond=None)[0]
        off = np.abs(rows @ normal - inverse)
        bound = 5 * max(weighted_median(off, weight), 1e-12)
        factor = np.minimum(1, bound / np.maximum(off, 1e-15))
    return normal


def weighted_median(values: Array, weight: Array) -> float:
    order = np.argsort(values)
    total = np.cumsum(weight[order])
    return float(values[order][min(int(np.searchsorted(total, total[-1] / 2)), len(values) - 1)])


def in_one_patch(points: Array, weight: Array, reach: float = 2.0) -> NDArray[np.bool_]:
    """Which points lie in the patch that most of the weight is in: an ellipse of ``reach`` deviations either way.

    What is weighed as the field but lies apart from it is a hand, or blood on the drapes: on three tuning recordings
    this took the error over the field from 1.30 times the best plane's to 1.18.
    """
    inside = np.ones(len(points), bool)
    for _ in range(10):
        middle = np.array([weighted_median(points[inside, axis], weight[inside]) for axis in (0, 1)])
        apart = np.abs(points - middle)
        spread = [1.4826 * weighted_median(apart[inside, axis], weight[inside]) for axis in (0, 1)]
        now = (np.square(apart / np.maximum(reach * np.array(spread), 1e-9)).sum(axis=1)) < 1
        if now.sum() < 3 or (now == inside).all():
            break
        inside = now
    return inside


def induced(model: Calibration, reference: int, camera: int, normal: Array) -> Array:
    """The homography camera pixel -> reference pixel by way of the plane normal . X = 1 of the reference's space."""
    to_camera = relative(model.poses[camera], model.poses[reference])
    there = model.cameras[camera] @ (to_camera[:, :3] + np.outer(to_camera[:, 3], normal))
    back = np.linalg.inv(there @ np.linalg.inv(model.cameras[reference]))
    return back / back[2, 2]


def relative(pose: Array, reference: Array) -> Array:
    """(3, 4) from the reference's space to the camera's."""
    turn = pose[:, :3] @ reference[:, :3].T
    return np.column_stack([turn, pose[:, 3] - turn @ reference[:, 3]])


# -------------------------------------------------------------------------------------------------------- the aligner


@frozen
class Calibrated:
    """Cameras calibrated together, tied by the surgical field's plane in space (the paper's way; pycolmap).

    Obayashi et al., and section "Multi-Camera Calibration of Consecutive Frames" of the paper.
    """

    settings: CalibrationSettings = field(factory=CalibrationSettings)
    name = "calibrated"

    def align(
        self,
        pairs: Mapping[tuple[str, str], Correspondences],
        sizes: Mapping[str, tuple[int, int]],
        reference: str,
    ) -> Alignment:
        """One homography per camera that can be calibrated together with ``reference``, the others weak."""
        settings, names = self.settings, sorted(sizes)
        number = {name: i for i, name in enumerate(names)}
        kept = {}
        for (a, b), pair in sorted(pairs.items()):
            matches = true_matches(pair, float(np.hypot(*sizes[b])), settings)
            if matches is not None:
                kept[number[a], number[b]] = matches
        by_number = {number[name]: (sizes[name][0], sizes[name][1]) for name in names}
        model = _best_model(build_tracks(kept), by_number, number[reference], settings) if kept else None
        homographies = {reference: np.eye(3)}
        if model is not None:
            homographies |= self._through_the_plane(model, names, reference)
        bound = settings.off_plane * float(np.hypot(*sizes[reference]))
        quality = {n: _quality(number[n], kept, homographies, names, bound) for n in homographies if n != reference}
        far = sorted(n for n, (_, places) in quality.items() if not places)
        weak = []
        for name in names:
            if name in far:
                weak.append(Weak(name, "calibrated, but its matches lie farther off the field's plane than any relief"))
            elif name not in homographies:
                weak.append(Weak(name, _diagnosis(number[name], pairs, kept, name, settings)))
        return Alignment(
            {n: h for n, h in homographies.items() if n not in far},
            {n: rms for n, (rms, _) in sorted(quality.items()) if n not in far},
            {n: places for n, (_, places) in sorted(quality.items()) if n not in far},
            tuple(weak),
        )

    def _through_the_plane(self, model: Calibration, names: list[str], reference: str) -> dict[str, Array]:
        base = names.index(reference)
        own = model.places @ model.poses[base][:, :3].T + model.poses[base][:, 3]
        seen = np.zeros(len(own), bool)
        seen[model.tracks.place] = True
        good = seen & np.isfinite(own[:, 2]) & (own[:, 2] > 0)
        seen_at = project(np.eye(3, 4), model.cameras[base], own[good])[0]
        patch = in_one_patch(seen_at, model.tracks.weight[good])
        normal = fit_plane(own[good][patch], model.tracks.weight[good][patch])
        return {names[c]: induced(model, base, c, normal) for c in model.poses if c != base}


def _best_model(
    tracks: Tracks, sizes: Mapping[int, tuple[int, int]], reference: int, settings: CalibrationSettings
) -> Calibration | None:
    """Of the calibrations from several focal lengths the one with most cameras, then the least error."""
    best: Calibration | None = None
    for per_width in settings.focal_per_width:
        model = calibrate(tracks, sizes, per_width, settings)
        if model is None or reference not in model.poses:
            continue
        if best is None or (-len(model.poses), model.error) < (-len(best.poses), best.error):
            best = model
        if len(best.poses) == len(sizes) and best.error < settings.off_line:
            break  # where all meet, another beginning ends at the same focal length to four digits
    return best


def _quality(
    camera: int,
    kept: Mapping[tuple[int, int], Correspondences],
    homographies: Mapping[str, Array],
    names: list[str],
    bound: float,
) -> tuple[float, int]:
    """(weighted rms in reference pixels, distinct places) of a camera's matches near the plane: within ``bound``.

    Both ends are laid by their homographies. (infinite, 0) where more weight lies beyond than within.
    """
    apart, weights, ends = [np.zeros(0)], [np.zeros(0)], [np.zeros((0, 2))]
    for (a, b), pair in kept.items():
        if camera in (a, b) and names[a] in homographies and names[b] in homographies:
            apart.append(
                np.hypot(
                    *(
                        transform_points(homographies[names[a]], pair.a)
                        - transform_points(homographies[names[b]], pair.b)
                    ).T
                )
            )
            weights.append(pair.weight)
            ends.append(pair.a if camera == a else pair.b)
    off, weight, points = np.concatenate(apart), np.concatenate(weights), np.concatenate(ends)
    near = off < bound
    if weight[near].sum() <= weight[~near].sum():
        return float("inf"), 0
    rms = float(np.sqrt(np.average(off[near] ** 2, weights=weight[near])))
    return rms, len(np.unique(np.floor(points[near] / CELL_PX), axis=0))


def _diagnosis(
    camera: int,
    pairs: Mapping[tuple[str, str], Correspondences],
    kept: Mapping[tuple[int, int], Correspondences],
    name: str,
    settings: CalibrationSettings,
) -> str:
    """Why a camera could not be calibrated, in words for a person."""
    most = max((len(pair) for key, pair in pairs.items() if name in key), default=0)
    if most < settings.min_places:
        return f"too few points in common with any other camera: at most {most}; {settings.min_places} are needed"
    if not any(camera in key for key in kept):
        return "its matches with no other camera obey one epipolar geometry"
    return "no pose in space makes its matches with the other cameras meet in one place, over enough of its picture"


@hookimpl
def register_aligners():
    return [Calibrated()]
