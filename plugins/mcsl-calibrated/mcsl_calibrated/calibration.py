"""From tracks to cameras and places in space: a first pair, one camera after the other, everything adjusted together.

Pixels are full-size with centres at integers; space has any scale, its origin is the first camera's.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np
from attrs import evolve, frozen

from .tracks import Array, CalibrationSettings, Tracks


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
    import pycolmap  # see the package's docstring

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
    import pycolmap  # see the package's docstring

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
    import pycolmap  # see the package's docstring

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
    import pycolmap  # see the package's docstring

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
