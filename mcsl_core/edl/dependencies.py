"""What the picture of a programme frame depends on, as far as the EDL tells it.

Said once, for whoever asks whether a picture that was made still holds: the keys of conformed chunks
(`delivery.chunk_keys`, which add what only the files tell) and the add-on (`blender_addon/core/stale.py`). Over each
stretch of `resolve_by_pose` all frames depend on the same, but for the centering. Plain values, no numpy: Blender's
side uses it too.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from attrs import frozen

from mcsl_core.timing import FrameRange

from .colour import ColourKey, Matrix34, keys_over
from .following import followed_over, poses_beside
from .placement import correction_of, first_of_perspective, other_poses, placement_matrix, still_range
from .resolve import Decision, offset_at
from .schema import Camera, Edl, Matrix, Pose

Offset = tuple[float, float]
_LATE = 2  # frames: a first picture that is late by no more stands from the beginning


@frozen
class View:
    """One camera's part in the pictures of a pose: its files on its clock, where it is laid, in which colours.

    placement: camera pixel -> programme pixel before centering; None where that is not known. colour: None where its
    colours stay as they are. colour_keys: of all of the pose, none where the camera does not drift.
    """

    camera: Camera
    placement: Matrix | None
    colour: Matrix34 | None
    colour_keys: tuple[ColourKey, ...] = ()

    @property
    def clock(self) -> list[float]:
        return [self.camera.clock.offset_s, self.camera.clock.drift_ppm]

    @property
    def gaps(self) -> list[list[int]]:
        return [[gap.start, gap.stop] for gap in self.camera.gaps]


@frozen
class FillViews:
    """What the fill may look at of one pose: when the lamp stands still in it, and the cameras whose place is known."""

    still: FrameRange
    views: tuple[View, ...]


def views_of(edl: Edl, pose: Pose, decision: Decision) -> tuple[View, ...]:
    """The cameras that may be looked at under ``decision``, in the EDL's order.

    They are the shot's, the reference, which stands in where the shot's has no picture, any other where that has none
    either, and for the fill and for seeing through all that can be laid somewhere.
    """
    first = decision.camera, edl.reference
    any_other = all(_may_lack_pictures(edl, name) for name in first)
    laid = decision.fill or sees_through(pose, decision)
    found = []
    for camera in edl.cameras:
        placement = placement_matrix(edl, pose, camera.name)
        if camera.name in first or any_other or (laid and placement is not None):
            found.append(_view(pose, camera, placement, coloured=decision.colour))
    return tuple(found)


def _view(pose: Pose, camera: Camera, placement: Matrix | None, *, coloured: bool) -> View:
    colour = pose.colour[camera.name].matrix if coloured and camera.name in pose.colour else None
    return View(camera, placement, colour, pose.colour_keys.get(camera.name, ()) if coloured else ())


def relief_of(edl: Edl, pose: Pose, *, surface: bool) -> list[Any] | None:
    """What the pictures of a pose depend on where they are laid by its relief; None where they are not."""
    if not surface or pose.relief is None:
        return None
    corrections = {camera.name: correction_of(edl, pose, camera.name) for camera in edl.cameras}
    by_hand = {name: matrix for name, matrix in corrections.items() if matrix is not None}
    return [pose.relief.projections, pose.relief.gamma, pose.relief.confidence, by_hand]


def sees_through(pose: Pose, decision: Decision) -> bool:
    """Whether other cameras show what heads hide from the chosen one: that takes a relief to lay them by."""
    return decision.see_through and decision.surface and pose.relief is not None


def _may_lack_pictures(edl: Edl, name: str) -> bool:
    """Whether a camera has gaps, or as far as the EDL knows begins after the programme or ends before it."""
    camera = edl.camera(name)
    length_s = sum(media.frames for media in camera.media) / camera.rate
    begin, end = (camera.clock.programme_time(time_s) * float(edl.rate) for time_s in (0, length_s))
    return bool(camera.gaps) or begin > _LATE or end < edl.frames - _LATE


def fill_views(edl: Edl, pose_index: int) -> FillViews:
    """What the fill may look at of a pose; in its colours, whether they are matched or not."""
    pose = edl.poses[pose_index]
    placed = [(camera, placement_matrix(edl, pose, camera.name)) for camera in edl.cameras]
    views = [_view(pose, camera, placement, coloured=True) for camera, placement in placed if placement is not None]
    return FillViews(still_range(edl, pose), tuple(views))


def poses_filled_from(edl: Edl, pose_index: int, *, alone: bool) -> tuple[int, ...]:
    """The poses that the fill of a pose looks at beside itself.

    The first of its perspective, whose parallax is the perspective's; and unless the pose's own cameras fill it
    ``alone``, the others of the perspective, the nearest earlier ones first.
    """
    return first_of_perspective(edl, pose_index), *(() if alone else other_poses(edl, pose_index))


def follows_centering(decision: Decision) -> bool:
    """Whether the picture's place depends on the EDL's centering keys: where it follows them, or glides to or from."""
    return decision.centering and (decision.offset is None or any(ease.other is None for ease in decision.eases))


def offsets_over(edl: Edl, part: FrameRange) -> list[tuple[int, float, float]]:
    """The automatic centering over ``part``: frame, x and y at its ends and the keys between.

    That is all that linear motion depends on.
    """
    inside = [frame for frame, _, _ in edl.centering if part.start < frame < part.stop - 1]
    return [(frame, *offset_at(edl.centering, frame)) for frame in (part.start, *inside, part.stop - 1)]


def drifting(views: Iterable[View]) -> dict[str, tuple[ColourKey, ...]]:
    """The cameras whose colours drift, with the keys of all of the pose."""
    return {view.camera.name: view.colour_keys for view in views if view.colour_keys}


def drift_over(edl: Edl, pose_index: int, cameras: Iterable[str], part: FrameRange) -> dict[str, list[ColourKey]]:
    """How the colours of these cameras drift over ``part`` of a pose."""
    return {name: keys_over(edl.poses[pose_index].colour_keys[name], part) for name in cameras}


def movement_over(edl: Edl, part: FrameRange) -> list[Any]:
    """What the pictures of ``part`` depend on where the lamp moves and is followed: nothing elsewhere."""
    found = []
    for movement in followed_over(edl, part):
        beside = poses_beside(edl, movement)
        colours = [{name: colour.matrix for name, colour in pose.colour.items()} for pose in beside]
        reliefs = [pose.relief and [pose.relief.gamma, pose.relief.confidence] for pose in beside]
        goes_over = list(zip(colours, reliefs, strict=True))
        views = [[v.frame, v.homographies, v.projections] for v in movement.views]
        lasts = FrameRange(movement.views[0].frame, movement.views[-1].frame + 1)
        by_hand = [
            [c.camera, c.range.start, c.range.stop, c.matrix] for c in edl.corrections if lasts.intersection(c.range)
        ]
        found.append([views, goes_over, *([by_hand] if by_hand else [])])
    return found


def offset_bounds(edl: Edl, part: FrameRange) -> tuple[Offset, Offset]:
    """The least and the greatest offsets of the automatic centering over ``part``."""
    _, x, y = zip(*offsets_over(edl, part), strict=True)
    return (min(x), min(y)), (max(x), max(y))
