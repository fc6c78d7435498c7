"""How the cameras lie while the lamp moves, for the EDL: every movement between two poses of one perspective."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing

import attrs
import cv2
import numpy as np
from attrs import frozen
from scipy.optimize import least_squares

from mcsl_core.edl import Movement, MovementView
from mcsl_core.imaging.geometry import (
    Array,
    Homography,
    inverse,
    project,
    to_edl_matrix,
    to_edl_projection,
    transform_points,
)
from mcsl_core.imaging.relief import between_nodes
from mcsl_core.progress import Progress
from mcsl_core.recording.decoder import Decoder, exact_programme_time
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore

from ..observations import SolvedPose
from ..steady import steady_view
from .following import End, Instant
from .lamp import Lamp, LampView, calibrate
from .protocol import Tracker
from .templates import WIDTH, Grey, Ground, templates

_RATE = 12.0  # instants a second: the lamp's speed changes by 500 px/s^2 of 960 at most, a third of a pixel between two
_MOST = 400  # instants of a movement
_MARGIN_S = 0.3  # before and after: the lamp starts a little earlier than it is seen to
_SAMPLES = 12  # of a pose, the nearest to the movement, that its background is made from
_LOST_S = 1.0  # with a longer gap nobody knows where the lamp went
_KNOWN = 0.1  # confidence of nodes that cameras are calibrated by
_PLANE_OFF, _PLANE_MOST = 3.0 / 960, 12.0 / 960  # of the width: what planes are off the relief, and are at most
_BEND = 0.15 / 960  # of the width: views between which a line leads so near are left out


@frozen(eq=False)
class _Standing:
    """A pose with a relief, in arrays.

    gamma, confidence: (rows, columns). projections: camera -> (3, 4). planes: camera -> programme pixel to its pixel.
    view: where the lamp stands. points: (N, 3), scene points that are known.
    """

    pose: SolvedPose
    gamma: Array
    projections: Mapping[str, Array]
    planes: Mapping[str, Homography]
    points: Array
    view: LampView


def follow_movements(
    samples: SampleStore,
    solved: Sequence[SolvedPose],
    movements: Sequence[Movement],
    footage: Footage,
    progress: Progress,
    *,
    reference: str,
    tracker: Tracker,
) -> tuple[Movement, ...]:
    """The movements, with how the cameras lie in them where the poses beside share a perspective with a relief.

    Parameters
    ----------
    samples : SampleStore
        The recording's, for the poses' backgrounds.
    solved : sequence of SolvedPose
        Tiling the programme, anchored.
    movements : sequence of Movement
        In order.
    footage : Footage
        Whose frames in movements are decoded.
    progress : Progress
        Told of every movement, and of those in which the lamp is lost.
    reference : str
        The reference camera.
    tracker : Tracker
        Who follows the lamp through each of them.
    """
    progress.stage("Following the lamp", len(movements), "movements")
    made: list[Movement] = []
    rigs: dict[int, tuple[Lamp, dict[int, _Standing]] | None] = {}
    for movement in movements:
        made.append(movement)
        middle = (movement.range.start + movement.range.stop) // 2
        at = next((i for i, pose in enumerate(solved) if pose.pose.range.start == middle), 0)
        if at and solved[at - 1].pose.perspective == solved[at].pose.perspective:
            perspective = solved[at].pose.perspective
            if perspective not in rigs:
                rigs[perspective] = _calibrated(solved, perspective, reference, footage)
            known = rigs[perspective]
            if known is not None and at - 1 in known[1] and at in known[1]:
                beside = known[1][at - 1], known[1][at]
                views = _views(known[0], beside, movement, samples, movements, footage, tracker)
                made[-1] = attrs.evolve(movement, views=views)
        if not made[-1].views:
            progress.note(f"frames {movement.range}: the lamp cannot be followed; the programme holds its camera")
        progress.advance(len(made))
    return tuple(made)


def _calibrated(
    solved: Sequence[SolvedPose], perspective: int, reference: str, footage: Footage
) -> tuple[Lamp, dict[int, _Standing]] | None:
    """The rig, and where it stands in the poses of a perspective by their index; None where no pose has a relief."""
    found = {
        i: own
        for i, pose in enumerate(solved)
        if pose.pose.perspective == perspective and (own := _standing(pose, footage.camera(reference).size)) is not None
    }
    sizes = {camera.name: camera.size for camera in footage.cameras}
    poses = list(found.values())
    if not poses:
        return None
    calibrated = calibrate([pose.projections for pose in poses], poses[0].points, reference, sizes)
    if calibrated is None:
        return None
    lamp, views = calibrated
    known = {i: attrs.evolve(p, view=v) for (i, p), v in zip(found.items(), views, strict=True)}
    for i, pose in enumerate(solved):
        if pose.pose.perspective == perspective and i not in known:
            nearest = known[min(found, key=lambda n, i=i: abs(n - i))]
            if (placed := _by_planes(lamp, nearest, pose)) is not None:
                known[i] = placed
    return lamp, known


def _by_planes(lamp: Lamp, known: _Standing, pose: SolvedPose) -> _Standing | None:
    """A pose without a relief: where the lamp stands by its planes, over another pose's relief."""
    planes = _planes(pose)
    names = sorted(planes.keys() & known.projections.keys())
    if len(names) < 2:
        return None
    seen = {name: transform_points(planes[name], known.points[:, :2]) for name in names}

    def off(numbers: Array) -> Array:
        view = LampView.of(numbers)
        return np.concatenate(
            [(project(lamp.projection(n, view), known.points) - seen[n]).ravel() / lamp.sizes[n][0] for n in names]
        )

    start = least_squares(off, known.view.numbers, max_nfev=60).x
    found = least_squares(off, start, loss="soft_l1", f_scale=_PLANE_OFF, max_nfev=60).x
    if np.median(np.hypot(*off(found).reshape(-1, 2).T)) > _PLANE_MOST:
        return None
    view = LampView.of(found)
    projections = {name: lamp.projection(name, view) for name in names}
    return attrs.evolve(known, pose=pose, projections=projections, planes=planes, view=view)


def _planes(pose: SolvedPose) -> dict[str, Homography]:
    """Camera -> programme pixel to its own, by the pose's plane."""
    anchor = np.array(pose.pose.anchor)
    return {name: inverse(anchor @ np.array(h)) for name, h in pose.pose.homographies.items()}


def _standing(pose: SolvedPose, size: tuple[int, int]) -> _Standing | None:
    relief = pose.pose.relief
    if relief is None:
        return None
    gamma, confidence = np.array(relief.gamma), np.array(relief.confidence) / 100
    x, y = np.meshgrid(np.linspace(0, size[0] - 1, 12), np.linspace(0, size[1] - 1, 8))
    at = np.column_stack([x.ravel(), y.ravel()])
    heights, sure = between_nodes(np.stack([gamma, confidence], axis=-1), size, at).T
    points = np.column_stack([at, heights])[sure > _KNOWN]
    planes = _planes(pose)
    projections = {name: np.array(p) for name, p in relief.projections.items() if name in planes}
    if len(points) < 8 or len(projections) < 2:
        return None
    return _Standing(pose, gamma, projections, planes, points, LampView.of(np.zeros(7)))


def _views(
    lamp: Lamp,
    beside: tuple[_Standing, _Standing],
    movement: Movement,
    samples: SampleStore,
    movements: Sequence[Movement],
    footage: Footage,
    tracker: Tracker,
) -> tuple[MovementView, ...]:
    """Empty where the lamp is lost."""
    ends = [_end(lamp, pose, samples, movements, movement) for pose in beside]
    instants = _instants(footage, movement)
    found = tracker.follow(lamp, ends[0], ends[1], instants)
    frames = [instant.frame for instant in instants]
    known = [i for i, view in enumerate(found) if view is not None]
    gaps = np.diff([frames[0], *(frames[i] for i in known), frames[-1]])
    if not known or gaps.max() > max(_LOST_S * float(footage.rate), 2):
        return ()
    numbers = np.stack([found[i].numbers for i in known])  # pyright: ignore[reportOptionalMemberAccess]
    numbers = np.stack([np.interp(frames, [frames[i] for i in known], own) for own in numbers.T], axis=-1)
    places = _Places(lamp, beside, [end.bends for end in ends])
    views = [places.at((f - frames[0]) / (frames[-1] - frames[0]), LampView.of(n)) for f, n in zip(frames, numbers)]  # noqa: B905
    views[0], views[-1] = places.standing(0), places.standing(1)
    kept = _few(frames, views, beside[0].points, lamp.sizes)
    return tuple(
        MovementView(
            frames[i],
            {name: to_edl_matrix(inverse(plane)) for name, plane in views[i][1].items()},
            {name: to_edl_projection(p) for name, p in views[i][0].items()},
        )
        for i in kept
    )


def _end(
    lamp: Lamp, standing: _Standing, samples: SampleStore, movements: Sequence[Movement], movement: Movement
) -> End:
    """A pose at an end of a movement, with its background about then."""
    near = samples.standing(standing.pose.pose.range, movements) or list(standing.pose.samples)
    near = sorted(near, key=lambda i: abs(samples.frames[i] - movement.range.start))[:_SAMPLES]
    size = standing.pose.aligned.camera_sizes[standing.pose.aligned.reference]
    ground = Ground.of(size, standing.gamma)
    shown = {name: steady_view([samples.picture(i, name) for i in sorted(near)]) for name in standing.projections}
    views = {name: view for name, view in shown.items() if view is not None}
    bends = {
        name: _homography(project(lamp.projection(name, standing.view), standing.points), project(p, standing.points))
        for name, p in standing.projections.items()
    }
    return End(standing.view, ground, templates(ground, views, standing.projections, lamp.sizes), bends)


def _instants(footage: Footage, movement: Movement) -> list[Instant]:
    """What the cameras show from a little before the movement until a little after it."""
    rate = float(footage.rate)
    margin = max(2, round(_MARGIN_S * rate))
    first, last = max(0, movement.range.start - margin), min(footage.frames - 1, movement.range.stop - 1 + margin)
    step = max(1, round(rate / _RATE), -(-(last - first) // _MOST))
    frames = [*range(first, last, step), last]
    pictures: list[dict[str, Grey]] = [{} for _ in frames]
    late: list[dict[str, float]] = [{} for _ in frames]
    for camera in footage.cameras:
        height = max(1, round(WIDTH * camera.size[1] / camera.size[0]))
        with closing(Decoder(footage.parts(camera.name), threads=0)) as decoder:
            for i, frame in enumerate(frames):
                shown = footage.shown(camera.name, decoder, frame)
                if shown is None:
                    continue
                picture = footage.picture(camera.name, shown, height)
                pictures[i][camera.name] = np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8)
                late[i][camera.name] = frame - float(exact_programme_time(camera, shown.camera_s) * footage.rate)
    return [Instant(f, p, t) for f, p, t in zip(frames, pictures, late, strict=True)]


Places = tuple[dict[str, Array], dict[str, Homography]]  # camera -> projection, and -> programme pixel to its by plane


class _Places:
    """How the cameras lie between two poses: by relief and by plane, at both ends as the poses have it."""

    def __init__(
        self, lamp: Lamp, beside: tuple[_Standing, _Standing], bends: Sequence[Mapping[str, Homography]]
    ) -> None:
        self._lamp, self._beside, self._bends = lamp, beside, bends
        self._names = sorted(beside[0].projections.keys() & beside[1].projections.keys())
        self._planes = [_common_plane(pose, self._names) for pose in beside]
        self._rest = [
            {n: pose.planes[n] @ inverse(_through(pose.projections[n], plane)) for n in self._names}
            for pose, plane in zip(beside, self._planes, strict=True)
        ]

    def standing(self, end: int) -> Places:
        """At one end, as its pose has it."""
        pose = self._beside[end]
        return {n: pose.projections[n] for n in self._names}, {n: pose.planes[n] for n in self._names}

    def at(self, way: float, view: LampView) -> Places:
        """So far on the way (0..1) from one to the other, while the lamp stands so."""
        plane = (1 - way) * self._planes[0] + way * self._planes[1]
        projections, planes = {}, {}
        for name in self._names:
            bend, rest = (
                (1 - way) * a[name] / a[name][2, 2] + way * b[name] / b[name][2, 2]
                for a, b in (self._bends, self._rest)
            )
            projections[name] = bend @ self._lamp.projection(name, view)
            planes[name] = rest @ _through(projections[name], plane)
        return projections, planes


def _common_plane(pose: _Standing, names: Sequence[str]) -> Array:
    """(3,): gamma is this times (x, y, 1) on the plane that the cameras' homographies share, as well as may be."""
    at = np.column_stack([pose.points[:, :2], np.ones(len(pose.points))])
    rows, right = [], []
    for name in names:
        projection, size = pose.projections[name], pose.pose.aligned.camera_sizes[name]
        seen = at @ pose.planes[name].T
        seen = seen[:, :2] / seen[:, 2:]
        base, t = at @ projection[:, :3].T, projection[:, 3]
        along = (t[:2] - seen * t[2]) / (base[:, 2:] * size[0])
        rows.append((along[..., None] * at[:, None]).reshape(-1, 3))
        right.append(((seen * base[:, 2:] - base[:, :2]) / (base[:, 2:] * size[0])).ravel())
    scale = np.abs(at).mean(axis=0)
    return np.asarray(np.linalg.lstsq(np.concatenate(rows) / scale, np.concatenate(right), rcond=1e-9)[0] / scale)


def _through(projection: Array, plane: Array) -> Homography:
    """(3, 3): programme pixel -> camera pixel, of what lies on the plane."""
    return projection[:, :3] + np.outer(projection[:, 3], plane)


def _homography(a: Array, b: Array) -> Homography:
    found, _ = cv2.findHomography(a, b, 0)
    return np.eye(3) if found is None else np.asarray(found, np.float64)  # pyright: ignore[reportUnnecessaryComparison]


def _few(
    frames: Sequence[int], views: Sequence[Places], points: Array, sizes: Mapping[str, tuple[int, int]]
) -> list[int]:
    """The views that are kept: those between which the others lie on a line, to `_BEND`."""

    def seen(place: Places) -> Array:
        return np.stack([project(place[0][n] / place[0][n][2, 2], points) / sizes[n][0] for n in sorted(place[0])])

    def line(a: int, b: int, i: int) -> Places:
        part = (frames[i] - frames[a]) / (frames[b] - frames[a])
        mixed = {
            n: (1 - part) * views[a][0][n] / views[a][0][n][2, 2] + part * views[b][0][n] / views[b][0][n][2, 2]
            for n in views[a][0]
        }
        return mixed, {}

    there = [seen(view) for view in views]
    kept, last = [0], 0
    while last < len(views) - 1:
        to = last + 1
        while to + 1 < len(views):
            between = range(last + 1, to + 1)
            if any(np.abs(seen(line(last, to + 1, i)) - there[i]).max() > _BEND for i in between):
                break
            to += 1
        kept.append(to)
        last = to
    return kept
