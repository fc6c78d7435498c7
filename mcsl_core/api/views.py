"""The pictures of one EDL as arrays, and the places in them: what the programme and its cameras show at a frame.

Pictures are (H, W, 3) uint8, RGB. Places are (x, y), pixel centres at integers.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator
from functools import cached_property
from operator import index
from typing import Protocol, TypedDict

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mcsl_core.alignment.colour_match import apply_colour, colour_at
from mcsl_core.compositing.compositor import Compositor
from mcsl_core.compositing.placement import laid, programme_matrix, surface_of
from mcsl_core.edl import Edl
from mcsl_core.edl.following import placed_pose
from mcsl_core.edl.placement import placement_matrix
from mcsl_core.edl.resolve import Decision, resolve_by_pose, shift_at
from mcsl_core.errors import Fault, MediaError, UsageError
from mcsl_core.hooks.registry import filler_of
from mcsl_core.imaging.geometry import Array
from mcsl_core.imaging.planes import U8, Planes, planes_to_bgr
from mcsl_core.imaging.relief import Placement
from mcsl_core.imaging.warp import WarpField
from mcsl_core.lru_cache import kept
from mcsl_core.recording.footage import Footage
from mcsl_core.timing import FrameRange


class Aids(TypedDict, total=False):
    """The visual aids, each on or off; None decides nothing."""

    centering: bool | None
    fill: bool | None
    colour: bool | None
    surface: bool | None
    see_through: bool | None


class Views:
    """Looks at one EDL and its footage; see `Programme`, whose methods these are. where: its file, for errors."""

    def __init__(self, edl: Edl, footage: Footage, where: str) -> None:
        self.edl, self.footage, self.where = edl, footage, where
        self._stretches = resolve_by_pose(edl)

    def close(self) -> None:
        if (compositor := self.__dict__.get("_compositor")) is not None:
            compositor.close()

    def frames(self, piece: FrameRange) -> Iterator[U8]:
        self.check_frame(piece.stop - 1)
        return (_rgb(planes) for planes in self._compositor.frames(piece))

    def decision_at(self, frame: int) -> tuple[Decision, int]:
        """The decision that holds at a frame, and the index of its pose."""
        at = self.check_frame(frame)
        _, decision, pose_index = self._stretches[bisect_right(self._stretches, at, key=lambda s: s[0].start) - 1]
        return decision, pose_index

    def placement(self, camera: str, frame: int) -> Placement:
        """Where the compositor lays a camera's picture at a frame."""
        self.check_camera(camera)
        decision, pose_index = self.decision_at(frame)
        pose = placed_pose(self.edl, index(frame))
        matrix = programme_matrix(self.edl, pose, camera)
        if placement_matrix(self.edl, pose, camera) is None:
            return Placement(matrix)
        surface = None
        if decision.surface:
            stands = pose is self.edl.poses[pose_index]
            surface = self._surface(pose_index, camera) if stands else surface_of(self.edl, pose, camera)
        return Placement(matrix, surface, shift_at(self.edl, decision, index(frame)))

    @kept
    def _surface(self, pose_index: int, camera: str) -> WarpField | None:
        return surface_of(self.edl, self.edl.poses[pose_index], camera)

    def camera_frame(self, camera: str, frame: int) -> U8:
        """What the camera sees, in its own size."""
        return _rgb(self._own(camera, frame))

    def aligned_frame(self, camera: str, frame: int) -> U8:
        """The camera's picture where the programme would show it, nothing filled."""
        planes = laid(self._own(camera, frame), self.placement(camera, frame), self.edl.size)
        decision, _ = self.decision_at(frame)
        match = colour_at(placed_pose(self.edl, index(frame)), camera, (index(frame),)) if decision.colour else None
        return _rgb(planes if match is None else apply_colour(planes, match))

    def check_camera(self, camera: str) -> None:
        names = [c.name for c in self.edl.cameras]
        if camera not in names:
            remedy = f"Cameras are {', '.join(names)}"
            raise UsageError(f"there is no camera {camera!r}", where=self.where, remedy=remedy)

    def check_frame(self, frame: int) -> int:
        try:
            at = index(frame)
        except TypeError:
            raise UsageError(f"a frame is a whole number, got {frame!r}", where=self.where) from None
        if not 0 <= at < self.edl.frames:
            remedy = f"Frames are 0 to {self.edl.frames - 1}"
            raise UsageError(f"there is no frame {at}", where=self.where, remedy=remedy)
        return at

    def piece_of(self, frames: FrameRange | tuple[int, int]) -> FrameRange:
        """A range of frames as people write it; UsageError where it is none, or not inside the programme."""
        try:
            piece = frames if isinstance(frames, FrameRange) else FrameRange(*frames)
        except (Fault, TypeError) as error:
            what = error.what if isinstance(error, Fault) else f"a range is its first frame and its end, got {frames!r}"
            raise UsageError(what, where=self.where, remedy="Give it as (900, 1100)") from None
        self.check_frame(piece.stop - 1)
        return piece

    @cached_property
    def _compositor(self) -> Compositor:
        return Compositor(self.edl, self.footage, filler=filler_of(self.edl))

    def _own(self, camera: str, frame: int) -> Planes:
        self.check_camera(camera)
        at = self.check_frame(frame)
        planes = next(self.footage.planes(camera, FrameRange(at, at + 1)))
        if planes is None:
            remedy = "Choose another frame, or another camera"
            raise MediaError("has no picture then", where=f"{camera} at frame {at}", remedy=remedy)
        return planes


def moved(way: Callable[[Array], Array], points: ArrayLike) -> NDArray[np.float64]:
    """Points (N, 2) or (2,) taken ``way``, which takes (N, 2); UsageError where they are no points."""
    try:
        given = np.asarray(points, np.float64)
    except (TypeError, ValueError):
        raise UsageError(f"points are numbers, got {points!r}"[:200], remedy="Give [[x, y], ...]") from None
    if given.ndim not in (1, 2) or given.shape[-1] != 2:
        raise UsageError(f"points are (N, 2) or (2,), got an array of shape {given.shape}", remedy="Give [[x, y], ...]")
    return way(given.reshape(-1, 2)).reshape(given.shape)


def _rgb(planes: Planes) -> U8:
    return np.asarray(cv2.cvtColor(planes_to_bgr(planes), cv2.COLOR_BGR2RGB), np.uint8)


class Document(Protocol):
    """What of a `Programme` is needed in its parts."""

    edl: Edl

    @property
    def _views(self) -> Views: ...
