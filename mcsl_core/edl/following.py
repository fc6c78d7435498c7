"""Where pictures lie while the lamp moves: a movement's views, between them, as a pose of one frame.

Plain tuples, no numpy: Blender's side uses it too. Conventions as in `edl.schema`.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import floor
from typing import TypeVar

import attrs

from mcsl_core.timing import FrameRange

from .checks import IDENTITY, Matrix
from .colour import Colour
from .movement import Movement
from .relief import Relief
from .schema import Camera, Edl, Pose

M = TypeVar("M", bound=tuple[tuple[float, ...], ...])


def followed_movement(edl: Edl, frame: int) -> Movement | None:
    """The movement whose views say how the cameras lie at ``frame``; None where the lamp stands or is not followed."""
    for movement in edl.movements:
        if movement.views and movement.views[0].frame <= frame <= movement.views[-1].frame:
            return movement
    return None


def followed_over(edl: Edl, part: FrameRange) -> tuple[Movement, ...]:
    """The movements whose views say how the cameras lie at any frame of ``part``."""
    known = (movement for movement in edl.movements if movement.views)
    return tuple(m for m in known if m.views[0].frame < part.stop and part.start <= m.views[-1].frame)


def placed_pose(edl: Edl, frame: int) -> Pose:
    """The pose that programme frame ``frame`` lies in, or how the cameras lie at that frame alone: `followed_pose`.

    Raises
    ------
    IndexError
        Where it lies outside the programme.
    """
    movement = followed_movement(edl, frame)
    return edl.pose_at(frame) if movement is None else followed_pose(edl, movement, frame)


def followed_pose(edl: Edl, movement: Movement, frame: int) -> Pose:
    """How the cameras lie at a frame of a movement that is followed, as a pose of that frame.

    Its anchor is the identity: homographies lead to programme pixels at once. Relief and colours go over from those of
    the pose before the movement to those of the pose after it.

    Parameters
    ----------
    edl : Edl
        The programme.
    movement : Movement
        Of the frame, with views.
    frame : int
        One between its first and last views.
    """
    first, last = movement.views[0].frame, movement.views[-1].frame
    before, after = poses_beside(edl, movement)
    way = _smooth((frame - first) / max(last - first, 1))
    shown = {camera.name: shown_at(camera, frame, edl.rate) for camera in edl.cameras}
    projections = _at(movement, shown, [view.projections for view in movement.views])
    return Pose(
        range=FrameRange(frame, frame + 1),
        homographies=homographies_at(movement, shown),
        anchor=IDENTITY,
        perspective=before.perspective,
        colour=_colours(before.colour, after.colour, way),
        colour_keys=before.colour_keys if frame < after.range.start else after.colour_keys,
        relief=_relief(before.relief, after.relief, projections, way),
    )


def poses_beside(edl: Edl, movement: Movement) -> tuple[Pose, Pose]:
    """The poses before and after a movement, which meet in its middle; one twice where no other is."""
    return edl.pose_at(max(0, movement.middle - 1)), edl.pose_at(min(movement.middle, edl.frames - 1))


def homographies_at(movement: Movement, shown: Mapping[str, float]) -> dict[str, Matrix]:
    """How cameras lie in a movement that is followed.

    Parameters
    ----------
    movement : Movement
        With views.
    shown : mapping of str to float
        Camera -> when its picture was taken, in programme frames; see `shown_at`.

    Returns
    -------
    dict of str to Matrix
        Camera pixel -> programme pixel, of the cameras that are known then.
    """
    return _at(movement, shown, [view.homographies for view in movement.views])


def shown_at(camera: Camera, frame: int, rate: Fraction) -> float:
    """When the picture that a camera shows at ``frame`` was taken, in programme frames: no later, less than one of its
    own before; by its clock and its nominal rate.
    """
    shown = floor(camera.clock.camera_time(frame / rate) * float(camera.rate) + 1e-6)
    return camera.clock.programme_time(shown / float(camera.rate)) * float(rate)


def _at(movement: Movement, shown: Mapping[str, float], parts: Sequence[Mapping[str, M]]) -> dict[str, M]:
    """Of each camera between the views on either side; the first's or last's beyond."""
    found, views = {}, movement.views
    for name, at in shown.items():
        after = min(max(bisect_right(views, at, key=lambda view: view.frame), 1), len(views) - 1)
        a, b = parts[max(after - 1, 0)], parts[after]
        span = views[after].frame - views[after - 1].frame if after else 1
        part = min(max((at - views[max(after - 1, 0)].frame) / span, 0.0), 1.0)
        if name in a and name in b:
            found[name] = _between(a[name], b[name], part)
    return found


def _between(a: M, b: M, part: float) -> M:
    rows = zip(a, b, strict=True)
    return tuple(tuple(x + part * (y - x) for x, y in zip(*row, strict=True)) for row in rows)  # pyright: ignore


def _smooth(part: float) -> float:
    part = min(max(part, 0.0), 1.0)
    return part * part * (3 - 2 * part)


def _colours(before: Mapping[str, Colour], after: Mapping[str, Colour], way: float) -> dict[str, Colour]:
    found = {**after, **before} if way < 0.5 else {**before, **after}
    both = before.keys() & after.keys()
    return found | {name: Colour(_between(before[name].matrix, after[name].matrix, way)) for name in both}


def _relief(before: Relief | None, after: Relief | None, projections: Mapping, way: float) -> Relief | None:
    """The poses' reliefs on the way from one to the other, as the cameras see them then; beside a plane one fades."""
    known = [relief for relief in (before, after) if relief is not None]
    if not projections or not known:
        return None
    a, b = known[0], known[-1]
    if (len(a.gamma), len(a.gamma[0])) != (len(b.gamma), len(b.gamma[0])):
        return attrs.evolve(a if way < 0.5 else b, projections=projections)
    first, last = (relief.confidence if relief is not None else _nothing(a) for relief in (before, after))
    rounded = tuple(tuple(round(v) for v in row) for row in _between(first, last, way))
    return Relief(projections, _between(a.gamma, b.gamma, way), rounded)


def _nothing(relief: Relief) -> tuple[tuple[int, ...], ...]:
    """No confidence at the nodes of a relief."""
    return tuple((0,) * len(row) for row in relief.confidence)
