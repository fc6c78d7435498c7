"""What others do with the matches that the relief is found by: as-projective-as-possible warps, thin-plate splines.

Both lay each camera's picture over the reference's by the matches of that pair alone; and later poses over the one that
began the perspective, by matches of every camera's own views then and now.

References
----------
J. Zaragoza, T.-J. Chin, M. S. Brown, D. Suter: As-projective-as-possible image stitching with moving DLT. CVPR 2013.
R. I. Hartley: In defense of the eight-point algorithm. PAMI 19(6), 1997 (the scaling).
F. L. Bookstein: Principal warps: thin-plate splines and the decomposition of deformations. PAMI 11(6), 1989.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray
from scipy.interpolate import RBFInterpolator

from benchmarks.ideal_geometry import Map, Points
from mcsl_core import edl
from mcsl_core.alignment.correspondences import Correspondences, Pairs
from mcsl_core.alignment.dense_matching import AlignedCamera, DenseSettings, match_densely
from mcsl_core.alignment.observations import spread
from mcsl_core.alignment.relief.cameras import ReliefCameras
from mcsl_core.alignment.relief.matching import BY_RELIEF, Views, _laid_by, _matched, relief_cameras
from mcsl_core.alignment.relief.rig import Rig
from mcsl_core.alignment.settings import SolveSettings
from mcsl_core.alignment.steady import steady_view
from mcsl_core.edl.placement import first_of_perspective, placement_matrix
from mcsl_core.imaging.geometry import half_widths, inverse, scaling, transform_points
from mcsl_core.recording.sample_store import SampleStore

WIDTH = 960
# Each baseline's own numbers were tuned on the recordings to tune on, in its favour.
SIGMA_PX, FLOOR = 20.0, 0.01  # of the moving DLT; the paper: 8 to 12, 0.0025 to 0.025
STIFFNESS = 1e-2  # of the spline, whose points lie in half widths
CONSENSUS = 0.05  # of the width: a match that lies farther off the plane of all is none
_LEAST = 20  # matches
_ACROSS = DenseSettings(grid_px=6, other_hue=0.0, reach=0.05)
_AT_ONCE = 400  # points


@frozen(eq=False)
class SeenPose:
    """What a pose's cameras show, and how they match.

    Attributes
    ----------
    views : Views
        What the relief's cameras are solved from.
    cameras : ReliefCameras or None
        Those; None where too little is shared.
    matches : Pairs
        The matches that they are solved from last; none without.
    """

    views: Views
    cameras: ReliefCameras | None
    matches: Pairs


def seen_poses(made: edl.Edl, samples: SampleStore) -> list[SeenPose | None]:
    """Every pose as the analysis sees it; None where the reference camera has no picture or no camera is tied."""
    found: list[SeenPose | None] = []
    sizes = {camera.name: camera.size for camera in made.cameras}
    for pose in made.poses:
        standing = samples.standing(pose.range, made.movements) or samples.within(pose.range)
        shown = [i for i in standing if samples.shows(i, made.reference)]
        homographies = {name: np.array(h) for name, h in pose.homographies.items()}
        if not shown or len(homographies) < 2:
            found.append(None)
            continue
        pictures = [samples[i].pictures for i in spread(shown, SolveSettings().dense_moments)]
        steady = {name: steady_view([p.get(name) for p in pictures]) for name in sizes}
        views = Views(made.reference, sizes, steady, pictures)
        rigs = [Rig.of(p.cameras) for p in found if p and p.cameras]
        cameras = relief_cameras(views, homographies, rigs)
        matches = {} if cameras is None else _matched(views, _laid_by(cameras, views), BY_RELIEF).all
        found.append(SeenPose(views, cameras, matches))
    return found


# --------------------------------------------------------------------------------------------------------- the warps

Fit = Callable[[Points, Points], Map]
"""Of (N, 2) points and where they lie, in half widths about the middles: the map from the one to the other."""


def moving_dlt(source: Points, target: Points, *, sigma_px: float = SIGMA_PX, floor: float = FLOOR) -> Map:
    """As-projective-as-possible: at every point the homography that serves the matches near it most."""
    to_a, to_b = _scaled(source), _scaled(target)
    a, b = transform_points(to_a, source), transform_points(to_b, target)
    one = np.column_stack([a, np.ones(len(a))])
    nothing = np.zeros_like(one)
    rows = np.stack([np.hstack([nothing, -one, b[:, 1:] * one]), np.hstack([one, nothing, -b[:, :1] * one])], axis=1)
    squares = np.einsum("nri,nrj->nij", rows, rows).reshape(len(a), 81)
    sigma = sigma_px * 2 / WIDTH

    def lay(points: Points) -> Points:
        found = []
        for part in np.array_split(points, max(1, len(points) // _AT_ONCE)):
            apart = np.square(part[:, None] - source[None]).sum(axis=2)
            weight = np.maximum(np.exp(-apart / sigma**2), floor)
            h = np.linalg.eigh((weight**2 @ squares).reshape(-1, 9, 9))[1][:, :, 0].reshape(-1, 3, 3)
            h = inverse(to_b) @ h @ to_a
            moved = np.einsum("nij,nj->ni", h, np.column_stack([part, np.ones(len(part))]))
            found.append(moved[:, :2] / moved[:, 2:])
        return np.concatenate(found)

    return lay


def thin_plate(source: Points, target: Points, *, stiffness: float = STIFFNESS) -> Map:
    """A thin-plate spline through what the homography of all matches leaves."""
    plane = np.asarray(cv2.findHomography(source, target)[0], np.float64)
    laid = transform_points(plane, source)
    left = RBFInterpolator(laid, target - laid, kernel="thin_plate_spline", smoothing=stiffness)

    def lay(points: Points) -> Points:
        at = transform_points(plane, points)
        return at + left(at)

    return lay


def _scaled(points: Points) -> NDArray[np.float64]:
    """(3, 3): to a mean of 0 and a mean distance of the root of 2 from it."""
    middle = points.mean(axis=0)
    scale = np.sqrt(2) / max(float(np.hypot(*(points - middle).T).mean()), 1e-12)
    return np.array([[scale, 0, -scale * middle[0]], [0, scale, -scale * middle[1]], [0, 0, 1]])


def fitted(fit: Fit, matches: Correspondences, sizes: Sequence[tuple[int, int]]) -> Map | None:
    """The map from the matches' b to their a, full-size pixels, by those near one plane; None where they are few."""
    if len(matches) < _LEAST:
        return None
    to_a, to_b = (half_widths(size) for size in sizes)
    a, b = transform_points(to_a, matches.a), transform_points(to_b, matches.b)
    near = cv2.findHomography(b, a, cv2.RANSAC, CONSENSUS * 2, maxIters=2000, confidence=0.999)[1]
    keep = np.zeros(len(a), bool) if near is None else near.ravel() > 0
    if keep.sum() < _LEAST:
        return None
    lay = fit(b[keep], a[keep])
    return lambda points: transform_points(inverse(to_a), lay(transform_points(to_b, points)))


# ------------------------------------------------------------------------------------------------- over the programme


def baseline(made: edl.Edl, poses: Sequence[SeenPose | None], fit: Fit) -> Mapping[tuple[int, str], Map]:
    """(pose, camera) -> camera pixel -> programme pixel before centering; without views that have too few matches."""
    found: dict[tuple[int, str], Map] = {}
    for index, pose in enumerate(poses):
        if pose is None:
            continue
        own: dict[str, Map] = {made.reference: lambda points: points}
        for (a, b), matches in pose.matches.items():
            if a == made.reference:
                lay = fitted(fit, matches, [pose.views.sizes[a], pose.views.sizes[b]])
                own |= {} if lay is None else {b: lay}
        first = first_of_perspective(made, index)
        before = {name: found[first, name] for name in own if (first, name) in found}
        across = (
            _plane(made, index, made.reference) if first == index else _across(made, poses, index, own, before, fit)
        )
        found |= {(index, name): _chained(lay, across) for name, lay in own.items()}
    return found


def _chained(first: Map, then: Map) -> Map:
    return lambda points: then(first(points))


def _plane(made: edl.Edl, index: int, camera: str) -> Map:
    matrix = np.array(placement_matrix(made, made.poses[index], camera), np.float64)
    return lambda points: transform_points(matrix, points)


def _across(
    made: edl.Edl,
    poses: Sequence[SeenPose | None],
    index: int,
    own: Mapping[str, Map],
    before: Mapping[str, Map],
    fit: Fit,
) -> Map:
    """The reference camera's pixels in a pose -> programme pixels, by what every camera sees now and saw at first.

    By the plane where that is too little.
    """
    first = first_of_perspective(made, index)
    there, here = [np.zeros((0, 2))], [np.zeros((0, 2))]
    for name in before:
        then, now = (_laid_view(made, at, name, poses[at]) for at in (first, index))
        if then is None or now is None:
            continue
        everywhere = np.ones(now.to_camera.shape[:2], bool)
        matches = match_densely({"then": then, "now": now}, everywhere, _ACROSS).get(("then", "now"))
        if matches is not None:
            there.append(before[name](matches.a))
            here.append(own[name](matches.b))
    a, b = np.concatenate(there), np.concatenate(here)
    pooled = Correspondences(a, b, np.ones(len(a)), np.ones(len(a), np.int64))
    return fitted(fit, pooled, [made.size, made.size]) or _plane(made, index, made.reference)


def _laid_view(made: edl.Edl, index: int, camera: str, pose: SeenPose | None) -> AlignedCamera | None:
    """A camera's steady view over the programme by its plane; None where it has none."""
    view, matrix = pose and pose.views.steady.get(camera), placement_matrix(made, made.poses[index], camera)
    if pose is None or view is None or matrix is None:
        return None
    size, aligned = pose.views.sizes[camera], pose.views.size
    to_views = scaling(made.size, aligned) @ np.array(matrix, np.float64)
    return AlignedCamera.by_plane([view.picture], to_views, size, aligned, [view.steady])
