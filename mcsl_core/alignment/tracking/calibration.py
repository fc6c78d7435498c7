"""The lamp calibrated from a perspective's poses: its cameras, and its place and zoom in each of them.

A perspective's reliefs know its scene and cameras but for a projective transformation of space. That a camera's pixels
are square, its axis goes through the picture's middle and the rig is rigid leaves little of it open (self-calibration,
Hartley and Zisserman 2004, chapter 19): a focal length a camera, the plane at infinity, and six numbers and a zoom a
pose. What a rig does beyond that, one that bends, or a lens, is kept as a small correction of each camera's picture.

References
----------
R. Hartley, A. Zisserman: Multiple view geometry in computer vision. Cambridge 2004.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import cv2
import numpy as np
from attrs import evolve, frozen
from scipy.spatial.transform import Rotation

from mcsl_core.imaging.geometry import Array, project

from .lamp import AT_REST, Lamp, LampView, intrinsics, rotation
from .least_squares import minimum

Projections = Mapping[str, Array]

_FOCALS = (1.1, 1.9, 3.0)  # widths, where the calibration starts
_BASELINE = 0.4  # of the distance to the field: how far a camera stands from the reference, for a start
_OFF = 1.0 / 960  # of the width, where the calibration's loss grows slower
_FEW = 24  # points that starts are tried with
_MOST_OFF = 4.0 / 960  # of the width, median: what fits no better is no rigid rig
# Of the width, the median of the worst camera of a pose: 14 recordings whose cameras lie right have 0.07 to 1.15 of
# 960, those with one that is off by about 10 have 6 and 9.
_RIGID = 2.0 / 960
_CLEARER = 3.0  # times that, without that camera of another pose; 724 has 7, 728 has 18
_NOISE = 0.1 / 960  # of it
_TRIES = 8  # of cameras that may be off, the most suspect first
_KEPT = 3  # cameras of a pose that one of them is left out of


@frozen(eq=False)
class Rig:
    """The lamp of a perspective's poses.

    Attributes
    ----------
    lamp : Lamp
        Calibrated.
    views : tuple of LampView
        Where it stands in each pose.
    off : mapping of (int, str) to float
        By which it misses a pose's camera, in widths, median.
    refused : tuple of (int, str)
        Poses and cameras that were left out.
    """

    lamp: Lamp
    views: tuple[LampView, ...]
    off: Mapping[tuple[int, str], float]
    refused: tuple[tuple[int, str], ...] = ()

    @property
    def worst(self) -> float:
        """Of the camera of a pose that it misses most."""
        return max(self.off.values())

    @property
    def rigid(self) -> bool:
        """Whether it explains every camera of every pose that is not refused."""
        return self.worst < _RIGID


def calibrate(
    poses: Sequence[Projections], points: Array, reference: str, sizes: Mapping[str, tuple[int, int]]
) -> Rig | None:
    """The rig of a perspective, and where it stands in each of its poses; without what is off.

    A camera that sees a head all through a pose may be tied by what is about it, and elsewhere than the rig has it. The
    other cameras and poses tell which: without it the rest is rigid, without any other it is not.

    Parameters
    ----------
    poses : sequence of mapping of str to (3, 4) array
        Camera -> its projection over programme pixels.
    points : (N, 3) array
        Scene points, programme pixel and gamma, spread over what is seen.
    reference : str
        The reference camera. Views count from the first pose that has it.
    sizes : mapping of str to (int, int)
        Every camera's full width and height.

    Returns
    -------
    Rig or None
        None where no rigid rig explains the projections, or fewer than two cameras have one.
    """
    found = _rig(poses, points, reference, sizes)
    if found is not None and not found.rigid:
        found = _without_one(found, poses, points, reference, sizes) or found
    return None if found is None or np.median(list(found.off.values())) > _MOST_OFF else found


def _without_one(
    rig: Rig, poses: Sequence[Projections], points: Array, reference: str, sizes: Mapping[str, tuple[int, int]]
) -> Rig | None:
    """The rig that explains all but one camera of one pose, which is known in another; None where no single one is off.

    The reference camera of the pose that views count from is never missed, and tried first. None, too, where the rest
    is nearly as rigid without that camera of another pose: of two that contradict each other nothing tells the wrong.
    """

    def without(view: tuple[int, str], points: Array) -> Rig | None:
        less = [{n: p for n, p in pose.items() if (i, n) != view} for i, pose in enumerate(poses)]
        return _rig(less, points, reference, sizes)

    few = points[:: max(1, len(points) // _FEW)]
    views = [(i, name) for i, pose in enumerate(poses) if len(pose) > _KEPT for name in pose]
    views = [(i, name) for i, name in views if any(name in pose for n, pose in enumerate(poses) if n != i)]
    suspects = sorted(views, key=lambda view: (view in rig.off, -rig.off.get(view, 0.0)))
    for view in suspects[:_TRIES]:
        found = without(view, few)
        if found is None or not found.rigid:
            continue
        rigs = {view: found}
        for i in range(len(poses)):
            if i != view[0] and (other := without((i, view[1]), few)) is not None:
                rigs[i, view[1]] = other
        best, *others = sorted(rigs, key=lambda view: rigs[view].worst)
        if others and rigs[others[0]].worst < _CLEARER * max(rigs[best].worst, _NOISE):
            return None
        found = without(best, points)
        return None if found is None else evolve(found, refused=(best,))
    return None


def _rig(
    poses: Sequence[Projections], points: Array, reference: str, sizes: Mapping[str, tuple[int, int]]
) -> Rig | None:
    """The rig that explains the projections best, however well it does; None where there is nothing to solve."""
    first = next((i for i, pose in enumerate(poses) if reference in pose), None)
    cameras = sorted(set().union(*poses) - {reference})
    if first is None or not cameras:
        return None
    order = sorted(range(len(poses)), key=lambda i: i != first)
    sources, poses = poses, [poses[i] for i in order]
    base = np.vstack([poses[0][reference], [0, 0, 0, 1]])  # the reference camera's own pixel, and gamma
    back = np.linalg.inv(base)
    own = np.column_stack([points[:, :2], np.ones(len(points)), points[:, 2]]) @ base.T
    own = own / own[:, 2:3]
    based = [{name: p @ back for name, p in pose.items()} for pose in poses]
    scene = own[:, [0, 1, 3]]
    rough = Calibration(based, scene[:: max(1, len(scene) // _FEW)], reference, cameras, sizes)
    starts = (rough.solved(rough.start(focal, sign)) for focal in _FOCALS for sign in (1, -1))
    cost, numbers = min(starts, key=lambda found: found[0])
    if not np.isfinite(cost):
        return None
    problem = Calibration(based, scene, reference, cameras, sizes)
    cost, numbers = problem.solved(numbers)
    if not np.isfinite(cost):
        return None
    lamp, off = problem.lamp(numbers), np.median(problem.distances(numbers).reshape(-1, len(scene)), axis=1)
    views = dict(zip(order, problem.views(numbers), strict=True))
    seen = [(i, name) for i in order for name in sources[i] if (i, name) != (first, reference)]
    return Rig(
        evolve(lamp, to_metric=lamp.to_metric @ base),
        tuple(views[i] for i in range(len(poses))),
        {view: float(value) for view, value in zip(seen, off, strict=True)},
    )


class Calibration:
    """The calibration's least-squares problem.

    Its numbers are the log of the reference's focal length in widths, the plane at infinity (2), gamma's scale, seven a
    camera (log focal, rotation, translation), seven a later pose.
    """

    def __init__(
        self,
        poses: Sequence[Projections],
        points: Array,
        reference: str,
        cameras: Sequence[str],
        sizes: Mapping[str, tuple[int, int]],
    ) -> None:
        self._poses, self._points, self._sizes = poses, points, sizes
        self._reference, self._cameras = reference, cameras
        self._scene = np.column_stack([points[:, :2], np.ones(len(points)), points[:, 2]])
        self._seen = [{name: project(p, points) for name, p in pose.items()} for pose in poses]

    def start(self, focal: float, sign: int) -> Array:
        """Numbers to start from, of a focal length in widths and the way gamma rises."""
        head = np.array([np.log(focal), 0.0, 0.0, sign * 1.0])
        rest = np.zeros(7 * (len(self._cameras) + len(self._poses) - 1))
        start = np.concatenate([head, rest])
        lamp = self.lamp(start)
        for index, name in enumerate(self._cameras):
            seen = next(pose[name] for pose in self._poses if name in pose)
            at = intrinsics(focal * self._sizes[name][0], self._sizes[name])
            mount = np.linalg.inv(at) @ seen @ np.linalg.inv(lamp.to_metric)
            u, s, vt = np.linalg.svd(mount[:, :3])
            turn = u @ vt
            turn, scale = (turn, s.mean()) if np.linalg.det(turn) > 0 else (-turn, -s.mean())
            own = slice(4 + 7 * index, 11 + 7 * index)
            start[own] = [np.log(focal), *Rotation.from_matrix(turn).as_rotvec(), *(mount[:, 3] / scale)]
        return start

    def solved(self, start: Array) -> tuple[float, Array]:
        """(cost, numbers); a cost without end where nothing is found."""
        try:
            return minimum(self, start, _OFF, 4 + 7 * len(self._cameras), 7)
        except np.linalg.LinAlgError:
            return float("inf"), start

    def distances(self, numbers: Array) -> Array:
        """(N,): by which the rig misses the projections, in widths."""
        return np.hypot(*self.off(numbers).reshape(-1, 2).T)

    def off(self, numbers: Array) -> Array:
        """(2 N,): how far the rig has scene points from where the projections have them, x and y, in widths."""
        lamp, views = self.lamp(numbers), self.views(numbers)
        parts = [
            (project(lamp.projection(name, views[i]), self._points) - self._seen[i][name]) / self._sizes[name][0]
            for i, name in self._counted()
        ]
        return np.nan_to_num(np.concatenate(parts), nan=1e3, posinf=1e3, neginf=-1e3).ravel()

    def slopes(self, numbers: Array) -> Iterator[tuple[list[int], Array]]:
        """The derivatives of `off`, for each camera in a pose: the K numbers it depends on, and by those (2 N, K).

        Those are its own seven, the pose's and the first four alone.
        """
        lamp, views = self.lamp(numbers), self.views(numbers)
        for i, name in self._counted():
            projection, columns, by_number = self._projection_slopes(lamp, views[i], i, name)
            at_pixel = self._scene @ projection.T
            moved = np.einsum("nj,kij->nik", self._scene, by_number)
            pixel, depth = at_pixel[:, :2] / at_pixel[:, 2:], at_pixel[:, 2, None, None]
            slopes = (moved[:, :2] - pixel[..., None] * moved[:, 2:]) / depth / self._sizes[name][0]
            yield columns, np.nan_to_num(slopes.reshape(-1, len(columns)), nan=0.0, posinf=0.0, neginf=0.0)

    def _counted(self) -> Iterator[tuple[int, str]]:
        """Poses and cameras in the order of `off`; not the one that says what the programme's pixels are."""
        for i, seen in enumerate(self._seen):
            yield from ((i, name) for name in seen if i or name != self._reference)

    def _projection_slopes(self, lamp: Lamp, view: LampView, pose: int, camera: str) -> tuple[Array, list[int], Array]:
        """A camera's projection (3, 4), the numbers it depends on, and its derivatives by those (K, 3, 4)."""
        focal = lamp.focal[camera] * np.exp(view.zoom)
        inner, mount, motion = intrinsics(focal, self._sizes[camera]), lamp.mounts[camera], view.motion
        before, after = inner @ mount, motion @ lamp.to_metric
        longer = np.diag([focal, focal, 0.0]) @ mount @ after
        columns, by = list(range(4)), list(before @ motion @ self._metric_slopes(lamp))
        if camera == self._reference:
            by[0] = by[0] + longer
        else:
            own = 4 + 7 * self._cameras.index(camera)
            columns += range(own, own + 7)
            turned = np.asarray(cv2.Rodrigues(mount[:, :3])[0], np.float64)
            by += [longer, *(inner @ _rigid_slopes(turned)[:, :3] @ after)]
        if pose:
            own = 4 + 7 * (len(self._cameras) + pose - 1)
            columns += range(own, own + 7)
            by += [*(before @ _rigid_slopes(view.turn) @ lamp.to_metric), longer]
        return before @ after, columns, np.array(by)

    def _metric_slopes(self, lamp: Lamp) -> Array:
        """(4, 4, 4): the derivatives of the lamp's `to_metric` by the first four numbers."""
        width, height = self._sizes[self._reference]
        found = np.zeros((4, 4, 4))
        found[0, :2] = -lamp.to_metric[:2]
        found[0, 3, 3] = -lamp.to_metric[3, 3]
        found[1, 3, [0, 2]] = 1 / width, -(width - 1) / 2 / width
        found[2, 3, [1, 2]] = 1 / width, -(height - 1) / 2 / width
        found[3, 3, 3] = 1 / (_BASELINE * lamp.focal[self._reference])
        return found

    def lamp(self, numbers: Array) -> Lamp:
        """The rig of these numbers."""
        width, height = size = self._sizes[self._reference]
        focal = float(np.exp(numbers[0])) * width
        to_metric = np.zeros((4, 4))
        to_metric[:3, :3] = np.linalg.inv(intrinsics(focal, size))
        a, b = numbers[1:3] / width
        x, y = (width - 1) / 2, (height - 1) / 2
        to_metric[3] = [a, b, 1 - a * x - b * y, numbers[3] / (_BASELINE * focal)]
        focals, mounts = {self._reference: focal}, {self._reference: np.eye(3, 4)}
        for index, name in enumerate(self._cameras):
            own = numbers[4 + 7 * index : 11 + 7 * index]
            focals[name] = float(np.exp(own[0])) * self._sizes[name][0]
            mounts[name] = np.column_stack([rotation(own[1:4]), own[4:7]])
        return Lamp(self._sizes, focals, mounts, to_metric)

    def views(self, numbers: Array) -> list[LampView]:
        """Where it stands in each pose."""
        rest = numbers[4 + 7 * len(self._cameras) :].reshape(-1, 7)
        return [AT_REST, *(LampView.of(own) for own in rest)]


def _rigid_slopes(turn: Array) -> Array:
    """(6, 4, 4): the derivatives of a motion by its rotation vector and its translation."""
    found = np.zeros((6, 4, 4))
    found[:3, :3, :3] = cv2.Rodrigues(turn)[1].reshape(3, 3, 3)
    found[[3, 4, 5], [0, 1, 2], 3] = 1
    return found
