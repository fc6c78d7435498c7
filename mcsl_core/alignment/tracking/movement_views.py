"""How the cameras lie while the lamp moves, for the EDL: every movement between two poses of one perspective."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs
import numpy as np

from mcsl_core.edl import Movement, MovementView
from mcsl_core.imaging.geometry import Array, Homography, inverse, project, to_edl_matrix, to_edl_projection
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore

from ..observations import SolvedPose
from .lamp import Lamp, LampView
from .protocol import Tracker
from .standing_poses import StandingPose, calibrated, instants_between

_MARGIN_S = 0.3  # before and after: the lamp starts a little earlier than it is seen to
_LOST_S = 1.0  # with a longer gap nobody knows where the lamp went
_BEND = 0.15 / 960  # of the width: views between which a line leads so near are left out


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
    rigs: dict[int, tuple[Lamp, dict[int, StandingPose]] | None] = {}
    for movement in movements:
        made.append(movement)
        at = next((i for i, pose in enumerate(solved) if pose.pose.range.start == movement.middle), 0)
        if at and solved[at - 1].pose.perspective == solved[at].pose.perspective:
            perspective = solved[at].pose.perspective
            if perspective not in rigs:
                rigs[perspective] = calibrated(solved, perspective, reference, footage)
            known = rigs[perspective]
            if known is not None and at - 1 in known[1] and at in known[1]:
                beside = known[1][at - 1], known[1][at]
                views = _views(known[0], beside, movement, samples, movements, footage, tracker)
                made[-1] = attrs.evolve(movement, views=views)
        if not made[-1].views:
            progress.note(f"frames {movement.range}: the lamp cannot be followed; the programme holds its camera")
        progress.advance(len(made))
    return tuple(made)


def _views(
    lamp: Lamp,
    beside: tuple[StandingPose, StandingPose],
    movement: Movement,
    samples: SampleStore,
    movements: Sequence[Movement],
    footage: Footage,
    tracker: Tracker,
) -> tuple[MovementView, ...]:
    """Empty where the lamp is lost."""
    ends = [pose.end(lamp, samples, movements, movement) for pose in beside]
    first, last = _about(movement, movements, footage)
    instants = instants_between(footage, first, last)
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


def _about(movement: Movement, movements: Sequence[Movement], footage: Footage) -> tuple[int, int]:
    """First and last frame of a movement with its margins, which reach half-way to the movements beside at most."""
    margin, at = max(2, round(_MARGIN_S * float(footage.rate))), movements.index(movement)
    low = (movements[at - 1].range.stop + movement.range.start) // 2 if at else 0
    high = footage.frames - 1
    if at + 1 < len(movements):
        high = (movement.range.stop + movements[at + 1].range.start) // 2 - 1
    return max(low, movement.range.start - margin), min(high, movement.range.stop - 1 + margin)


Places = tuple[dict[str, Array], dict[str, Homography]]  # camera -> projection, and -> programme pixel to its by plane


class _Places:
    """How the cameras lie between two poses: by relief and by plane, at both ends as the poses have it."""

    def __init__(
        self, lamp: Lamp, beside: tuple[StandingPose, StandingPose], bends: Sequence[Mapping[str, Homography]]
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


def _common_plane(pose: StandingPose, names: Sequence[str]) -> Array:
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
