"""Alignment by calibration, as in the paper: cameras and places in space, the surgical field's plane among them, and
for each camera the homography that this plane induces to the reference camera.

From the pooled matches of camera pairs to tracks, one a place; from two cameras to all by pose and triangulation;
bundle adjustment over everything (pycolmap). The lamp's cameras are of one make: one focal length for all, square
pixels, the principal point in the middle. A scene that is nearly flat leaves the focal length open and may even turn
the views inside out, so several focal lengths are tried and the one that leaves the least is taken.

Pixels are full-size with centres at integers; space is the reference camera's own, of arbitrary scale.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np
import pycolmap
from attrs import evolve, field, frozen
from numpy.typing import NDArray

from mcsl_core.alignment import Alignment, Correspondences, apply
from mcsl_core.edl import Weak
from mcsl_core.hookspecs import hookimpl

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

CELL_PX = 4.0  # matches within one cell are one place


@frozen
class CalibrationSettings:
    """Lengths in fractions of the picture's diagonal, so that they fit every size.

    focal_per_width: the focal lengths begun with, over the picture's width: views of 37, 53 and 26 degrees. off_line:
    how far a true match may lie off its epipolar line (2 px at 960x540). off_place: how far an observation may lie off
    its calibrated place. off_plane: how far matches may lie off the field's plane: more than any relief shifts them.
    """

    focal_per_width: tuple[float, ...] = field(default=(1.5, 1.0, 2.2))
    off_line: float = field(default=0.0018)
    off_place: float = field(default=0.004)
    off_plane: float = field(default=0.02)
    min_places: int = field(default=16)
    min_spread: float = field(default=0.015)  # share of the picture that a camera's places must span


# ------------------------------------------------------------------------------------------------------------- tracks


@frozen(eq=False)
class Tracks:
    """What the cameras see of P places. camera, place: (M,) numbers; points: (M, 2) pixels, one a camera and place.

    weight: (P,), the matches' weight: that of the surgical field counts, that of the drapes hardly.
    """

    camera: Numbers
    place: Numbers
    points: Array
    weight: Array

    def of(self, camera: int) -> tuple[Numbers, Array]:
        """(places, points) that a camera sees."""
        own = self.camera == camera
        return self.place[own], self.points[own]

    def where(self, keep: NDArray[np.bool_]) -> Tracks:
        """Some of the observations; places that fewer than two cameras see then go too."""
        places = self.place[keep]
        lasting = np.bincount(places, minlength=len(self.weight)) >= 2
        keep = keep & lasting[self.place]
        return evolve(self, camera=self.camera[keep], place=self.place[keep], points=self.points[keep])


def true_matches(pair: Correspondences, diagonal: float, settings: CalibrationSettings) -> Correspondences | None:
    """The matches that obey one epipolar geometry; None when they are too few to tie two cameras."""
    if len(pair) < settings.min_places:
        return None
    options = pycolmap.RANSACOptions(max_error=settings.off_line * diagonal, random_seed=0, max_num_trials=20000)
    found = pycolmap.estimate_fundamental_matrix(pair.a, pair.b, options)
    if found is None:
        return None
    kept = pair.where(np.asarray(found["inlier_mask"], bool))
    return kept if len(kept) >= settings.min_places else None


def build_tracks(pairs: Mapping[tuple[int, int], Correspondences]) -> Tracks:
    """Chains matches by the cells they share, strongest first; a chain never holds two cells of one camera."""
    rows = [
        (-float(weight), a, b, tuple(xa), tuple(xb))
        for (a, b), pair in sorted(pairs.items())
        for xa, xb, weight in zip(pair.a.tolist(), pair.b.tolist(), pair.weight, strict=True)
    ]
    chain_of: dict[tuple[int, int, int], int] = {}
    chains: dict[int, dict[int, tuple[int, int, int]]] = {}
    seen: dict[tuple[int, int, int], list[tuple[float, float]]] = {}
    weights: dict[int, float] = {}
    for minus, a, b, xa, xb in sorted(rows):
        ends = [(camera, int(x[0] // CELL_PX), int(x[1] // CELL_PX)) for camera, x in ((a, xa), (b, xb))]
        for end in ends:
            if end not in chain_of:
                chain_of[end] = len(chain_of)
                chains[chain_of[end]] = {end[0]: end}
                seen[end], weights[chain_of[end]] = [], 0.0
        one, other = (chain_of[end] for end in ends)
        if one != other:
            if chains[one].keys() & chains[other].keys():
                continue
            for end in chains.pop(other).values():
                chain_of[end] = one
                chains[one][end[0]] = end
            weights[one] = max(weights[one], weights.pop(other))
        weights[one] = max(weights[one], -minus)
        for end, x in zip(ends, (xa, xb), strict=True):
            seen[end].append(x)
    camera, place, points, weight = [], [], [], []
    for number, chain in sorted(chains.items()):
        if len(chain) < 2:
            continue
        for name, end in sorted(chain.items()):
            camera.append(name)
            place.append(len(weight))
            points.append(np.mean(seen[end], axis=0))
        weight.append(weights[number])
    return Tracks(
        np.array(camera, np.int64), np.array(place, np.int64), np.array(points).reshape(-1, 2), np.array(weight)
    )


# -------------------------------------------------------------------------------------------------------- calibration


@frozen(eq=False)
class Calibration:
    """poses: camera -> (3, 4) from space to camera. cameras: camera -> 3x3 intrinsics. places: (P, 3), NaN unknown.

    tracks: the observations that fit. error: their rms in fractions of the diagonal, the misfits' counted at the bound.
    """

    poses: Mapping[int, Array]
    cameras: Mapping[int, Array]
    places: Array
    tracks: Tracks
    error: float


def intrinsics(size: tuple[int, int], focal_px: float) -> Array:
    return np.array([[focal_px, 0, (size[0] - 1) / 2], [0, focal_px, (size[1] - 1) / 2], [0, 0, 1.0]])


def project(pose: Array, camera: Array, places: Array) -> tuple[Array, Array]:
    """((N, 2) pixels, (N,) depths) of places."""
    own = places @ pose[:, :3].T + pose[:, 3]
    seen = own @ camera.T
    return seen[:, :2] / seen[:, 2:], own[:, 2]


def triangulate(tracks: Tracks, poses: Mapping[int, Array], cameras: Mapping[int, Array]) -> Array:
    """(P, 3) places from all views that are posed, linearly; NaN for those with fewer than two or behind a camera."""
    total = np.zeros((len(tracks.weight), 4, 4))
    views = np.zeros(len(total), np.int64)
    for name, pose in poses.items():
        places, points = tracks.of(name)
        rays = np.column_stack([points, np.ones(len(points))]) @ np.linalg.inv(cameras[name]).T
        rows = [rays[:, axis, None] * pose[2] - pose[axis] for axis in (0, 1)]
        np.add.at(total, places, sum(r[:, :, None] * r[:, None, :] for r in rows))
        np.add.at(views, places, 1)
    _, vectors = np.linalg.eigh(total)
    homogeneous = vectors[:, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        places = homogeneous[:, :3] / homogeneous[:, 3:]
    places[views < 2] = np.nan
    for name, pose in poses.items():
        own = tracks.of(name)[0]
        places[own[project(pose, cameras[name], places[own])[1] <= 0]] = np.nan
    return places


def calibrate(
    tracks: Tracks, sizes: Mapping[int, tuple[int, int]], per_width: float, settings: CalibrationSettings
) -> Calibration | None:
    """All cameras that can be posed, beginning with a focal length of ``per_width`` widths; None where none can be."""
    cameras = {name: intrinsics(size, per_width * size[0]) for name, size in sizes.items()}
    diagonal = {name: float(np.hypot(*size)) for name, size in sizes.items()}
    first = _first_pair(tracks, sizes, cameras, settings)
    if first is None:
        return None
    (a, b), pose = first
    poses = {a: np.eye(3, 4), b: pose}
    model = _bundled(Calibration(poses, cameras, np.zeros((0, 3)), tracks, 0.0), sizes, diagonal, settings)
    while model is not None:
        name, pose = _next_camera(model, sizes, diagonal, settings)
        if pose is None:
            break
        wider = evolve(model, poses={**model.poses, name: pose}, tracks=tracks)
        bundled = _bundled(wider, sizes, diagonal, settings)
        if bundled is None:
            break
        model = bundled
    return model


def _colmap_camera(number: int, size: tuple[int, int], camera: Array) -> Any:
    return pycolmap.Camera(
        model="SIMPLE_PINHOLE",
        camera_id=number,
        width=size[0],
        height=size[1],
        params=[camera[0, 0], camera[0, 2], camera[1, 2]],
    )


def _first_pair(
    tracks: Tracks, sizes: Mapping[int, tuple[int, int]], cameras: Mapping[int, Array], settings: CalibrationSettings
) -> tuple[tuple[int, int], Array] | None:
    """The two cameras to begin with: the most places times the angle between their rays, and the second one's pose."""
    best: tuple[float, tuple[int, int], Array] | None = None
    names = sorted(sizes)
    for i, a in enumerate(names):
        for b in names[i + 1 :]:
            (pa, xa), (pb, xb) = tracks.of(a), tracks.of(b)
            common, ia, ib = np.intersect1d(pa, pb, return_indices=True)
            if len(common) < settings.min_places:
                continue
            diagonal = float(np.hypot(*sizes[a]))
            ransac = pycolmap.RANSACOptions(max_error=2 * settings.off_line * diagonal, random_seed=0)
            options = pycolmap.TwoViewGeometryOptions(compute_relative_pose=True, ransac=ransac)
            views = [_colmap_camera(n, sizes[n], cameras[n]) for n in (a, b)]
            number = np.arange(len(common), dtype=np.uint32)
            two = pycolmap.estimate_calibrated_two_view_geometry(
                views[0], xa[ia], views[1], xb[ib], np.column_stack([number, number]), options
            )
            if two.cam2_from_cam1 is None or len(two.inlier_matches) < settings.min_places:
                continue
            worth = len(two.inlier_matches) * min(float(two.tri_angle), np.deg2rad(20))
            if best is None or worth > best[0]:
                best = (worth, (a, b), np.asarray(two.cam2_from_cam1.matrix(), np.float64))
    return None if best is None or best[0] <= 0 else (best[1], best[2])


def _next_camera(
    model: Calibration,
    sizes: Mapping[int, tuple[int, int]],
    diagonal: Mapping[int, float],
    settings: CalibrationSettings,
) -> tuple[int, Array | None]:
    """The camera not yet posed that sees most of the known places, and its pose; None where there is none left."""
    best: tuple[int, int, Array | None] = (0, -1, None)
    known = np.isfinite(model.places[:, 0])
    for name in sorted(set(sizes) - set(model.poses)):
        places, points = model.tracks.of(name)
        usable = known[places]
        if usable.sum() < settings.min_places:
            continue
        options = pycolmap.AbsolutePoseEstimationOptions()
        options.ransac.max_error = settings.off_place * diagonal[name]
        options.ransac.random_seed = 0
        found = pycolmap.estimate_and_refine_absolute_pose(
            points[usable],
            model.places[places[usable]],
            _colmap_camera(name, sizes[name], model.cameras[name]),
            options,
        )
        if found is None or not _spans(points[usable][found["inlier_mask"]], sizes[name], settings):
            continue
        if found["num_inliers"] > best[0]:
            best = (found["num_inliers"], name, np.asarray(found["cam_from_world"].matrix(), np.float64))
    return best[1], best[2]


def _spans(points: Array, size: tuple[int, int], settings: CalibrationSettings) -> bool:
    if len(points) < settings.min_places:
        return False
    area = cv2.contourArea(cv2.convexHull(points.astype(np.float32)))
    return area >= settings.min_spread * size[0] * size[1]


def _bundled(
    start: Calibration,
    sizes: Mapping[int, tuple[int, int]],
    diagonal: Mapping[int, float],
    settings: CalibrationSettings,
) -> Calibration | None:
    """Everything refined together, three times over: what does not fit then is left out; None where too little fits.

    The tracks of cameras not yet posed are kept as they are.
    """
    model = start
    posed = np.isin(start.tracks.camera, list(start.poses))
    keep = np.ones(len(posed), bool)
    for bound in (4 * settings.off_place, 2 * settings.off_place, settings.off_place):
        used = evolve(start.tracks, camera=np.where(keep, start.tracks.camera, -1))
        places = triangulate(used, model.poses, model.cameras)
        model = _adjusted(evolve(model, places=places, tracks=used), sizes, settings)
        off = _misfits(evolve(model, tracks=start.tracks), diagonal)
        keep = ~posed | (off < bound)
        for name in model.poses:
            own = start.tracks.camera == name
            if not _spans(start.tracks.points[own & keep & np.isfinite(off)], sizes[name], settings):
                return None
    used = evolve(start.tracks, camera=np.where(keep, start.tracks.camera, -1))
    places = triangulate(used, model.poses, model.cameras)
    off = _misfits(evolve(model, tracks=start.tracks, places=places), diagonal)
    capped = np.minimum(off[posed], settings.off_place)
    error = float(np.sqrt(np.mean(capped**2)))
    return Calibration(model.poses, model.cameras, places, start.tracks.where(keep), error)


def _misfits(model: Calibration, diagonal: Mapping[int, float]) -> Array:
    """(M,) how far each observation lies off its place, in diagonals; infinite where either is not known."""
    off = np.full(len(model.tracks.camera), np.inf)
    for name, pose in model.poses.items():
        own = model.tracks.camera == name
        seen, depth = project(pose, model.cameras[name], model.places[model.tracks.place[own]])
        apart = np.hypot(*(seen - model.tracks.points[own]).T) / diagonal[name]
        off[own] = np.where(np.isfinite(apart) & (depth > 0), apart, np.inf)
    return off


def _adjusted(model: Calibration, sizes: Mapping[int, tuple[int, int]], settings: CalibrationSettings) -> Calibration:
    """Bundle adjustment of poses, places and one focal length for each picture size."""
    world = pycolmap.Reconstruction()
    kinds = {size: number + 1 for number, size in enumerate(sorted({sizes[n] for n in model.poses}))}
    for size, number in kinds.items():
        name = next(n for n in model.poses if sizes[n] == size)
        world.add_camera_with_trivial_rig(_colmap_camera(number, size, model.cameras[name]))
    index = np.zeros(len(model.tracks.camera), np.int64)
    for name, pose in model.poses.items():
        own = np.flatnonzero(model.tracks.camera == name)
        index[own] = np.arange(len(own))
        image = pycolmap.Image(
            name=str(name), keypoints=model.tracks.points[own], camera_id=kinds[sizes[name]], image_id=name + 1
        )
        world.add_image_with_trivial_frame(image, pycolmap.Rigid3d(pose))
    numbers: dict[int, int] = {}
    order = np.argsort(model.tracks.place, kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(model.tracks.place[order])) + 1):
        place = int(model.tracks.place[rows[0]])
        seen = [r for r in rows.tolist() if int(model.tracks.camera[r]) in model.poses]
        if np.isfinite(model.places[place]).all() and len(seen) >= 2:
            elements = [pycolmap.TrackElement(int(model.tracks.camera[r]) + 1, int(index[r])) for r in seen]
            numbers[place] = world.add_point3D(model.places[place], pycolmap.Track(elements))
    config = pycolmap.BundleAdjustmentConfig()
    for name in model.poses:
        config.add_image(name + 1)
    config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
    options = pycolmap.BundleAdjustmentOptions(print_summary=False)
    options.ceres.loss_function_type = pycolmap.LossFunctionType.SOFT_L1
    options.ceres.loss_function_scale = settings.off_line * float(np.hypot(*max(sizes.values()))) / 2
    options.ceres.solver_options.function_tolerance = 1e-6
    options.ceres.solver_options.num_threads = 1  # sums in one order: the same input gives the same bits
    pycolmap.create_default_bundle_adjuster(options, config, world).solve()
    places = np.full_like(model.places, np.nan)
    for place, number in numbers.items():
        places[place] = world.point3D(number).xyz
    focal = {size: world.camera(number).focal_length / size[0] for size, number in kinds.items()}
    typical = float(np.median(list(focal.values())))
    return evolve(
        model,
        poses={name: np.asarray(world.image(name + 1).cam_from_world().matrix(), np.float64) for name in model.poses},
        cameras={n: intrinsics(size, focal.get(size, typical) * size[0]) for n, size in sizes.items()},
        places=places,
    )


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
            apart.append(np.hypot(*(apply(homographies[names[a]], pair.a) - apply(homographies[names[b]], pair.b)).T))
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
