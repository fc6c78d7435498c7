"""Every camera's picture as the programme shows it: decoded once, warped to its position by one resampling."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Hashable, Sequence
from contextlib import ExitStack, closing
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.alignment.colour_match import apply_colour, drift_at
from mcsl_core.edl import Edl, MovementView, Pose, Relief
from mcsl_core.edl.following import followed_movement, placed_pose
from mcsl_core.edl.placement import placement_matrix, still_range
from mcsl_core.filling.protocol import CELL
from mcsl_core.filling.viewpoint import viewpoint_difference
from mcsl_core.imaging.geometry import Homography, translation
from mcsl_core.imaging.planes import U8, Planes
from mcsl_core.imaging.rect import Rect
from mcsl_core.imaging.warp import (
    RemapTables,
    Resampling,
    WarpField,
    footprint,
    remap_planes,
    warp_field_footprint,
    warp_field_maps,
    warp_planes,
    warp_planes_by_field,
)
from mcsl_core.lru_cache import LruCache

from .parallax import Parallax
from .picture_source import PicturePlayer, PictureSource
from .placement import has_relief, programme_matrix, surface_of

# Of what comes again frame after frame while the programme stands still, at 1080p; more of a larger programme.
_PICTURES_BYTES = 50_000_000  # warped medians: 16 of the whole frame
_MAPS_BYTES = 60_000_000  # tables for remapping: 3 of the whole frame
_MEDIANS_BYTES = 5_000_000  # medians by cell, 24 kB each
_EDGES_BYTES = 5_000_000  # tapered warp fields, 80 kB each
_PLACES_BYTES = 200_000  # of cameras in poses and single frames
_EDGE = 1 / 15  # of the programme's width: over so much the chosen camera's picture goes over into the others'
_MOVING = 2.0  # times as far apart the nodes of a surface lie that serves one frame; the field is .02 px off by it
_FOLLOWED = 16  # poses of single frames that are kept
_TO_CELL = np.array([[1 / CELL, 0, 0.5 / CELL - 0.5], [0, 1 / CELL, 0.5 / CELL - 0.5], [0, 0, 1]])
Laid = Literal["plane", "surface", "parallax", "edge"]  # see `CameraWarper.warped`
Offset = tuple[float, float]  # the centering's, in programme pixels


class CameraWarper:
    """Warps the cameras' pictures into the programme's. For one thread; close it when done.

    Parameters
    ----------
    edl : Edl
        The programme.
    pictures : PictureSource
        The cameras' own pictures.
    resampling : {"linear", "lanczos"}
        How a picture is resampled.
    parallax : Parallax, optional
        Its own without.

    Attributes
    ----------
    still : tuple of FrameRange
        By pose: the range in which the lamp stands still.
    geometry : int
        Equal for EDLs whose cameras' pictures lie alike.

    Notes
    -----
    Beside the EDL's poses there is one more for every frame of a movement that is followed; `pose_at` has its index.
    """

    def __init__(
        self, edl: Edl, pictures: PictureSource, resampling: Resampling, parallax: Parallax | None = None
    ) -> None:
        self.edl, self.parallax = edl, parallax or Parallax(edl, pictures)
        self._pictures = pictures
        self._resampling: Resampling = resampling
        self.still = tuple(still_range(edl, pose) for pose in edl.poses)
        sizes = tuple((camera.name, camera.size) for camera in edl.cameras)
        matrices = tuple(placement_matrix(edl, pose, name) for pose in edl.poses for name, _ in sizes)
        reliefs = tuple(_facts(pose.relief) for pose in edl.poses)
        moving = tuple(_places(view) for movement in edl.movements for view in movement.views)
        self.geometry = hash((edl.size, edl.rate, edl.reference, sizes, self.still, matrices, reliefs, moving))
        self._followed: dict[int, Pose] = {}
        self._forget()
        self._stack = ExitStack()
        self._players: dict[str, PicturePlayer] = {}

    def close(self) -> None:
        """Close the decoders and let go of what was kept; pictures handed out stay valid."""
        self._players.clear()
        self._forget()
        self._stack.close()

    def _forget(self) -> None:
        width, height = self.edl.size
        larger = max(1, width * height / (1920 * 1080))
        self.patches: LruCache[Planes | None] = LruCache(round(larger * _PICTURES_BYTES))
        self._maps: LruCache[RemapTables] = LruCache(round(larger * _MAPS_BYTES))
        self._medians: LruCache[list[U8] | None] = LruCache(round(larger * _MEDIANS_BYTES))
        self._edges: LruCache[WarpField | None] = LruCache(_EDGES_BYTES)
        self._placements: LruCache[tuple[Homography, bool]] = LruCache(_PLACES_BYTES)
        self._others: LruCache[tuple[str, ...]] = LruCache(_PLACES_BYTES)

    def own_picture(self, camera: str, frame: int) -> Planes | None:
        """The camera's own picture at programme frame ``frame``, decoded once; None where it has none."""
        if camera not in self._players:
            self._players[camera] = self._stack.enter_context(closing(self._pictures.player(camera)))
        return self._players[camera].at(frame)

    def median(self, camera: str, median_of: Sequence[int]) -> Planes | None:
        """The median of the camera's own pictures near the programme frames ``median_of`` of one pose, or None."""
        return self._pictures.median(camera, median_of, self.still[self.standing_at(median_of[0])])

    def standing_at(self, frame: int) -> int:
        """Index of the EDL's pose whose range a programme frame lies in."""
        return bisect_right(self.edl.poses, frame, key=lambda pose: pose.range.start) - 1

    def pose_at(self, frame: int) -> int:
        """Index of the pose by which pictures of a programme frame are laid; see the class."""
        followed = followed_movement(self.edl, frame) is not None
        return len(self.edl.poses) + frame if followed else self.standing_at(frame)

    def pose(self, pose_index: int) -> Pose:
        """The pose of that index."""
        count = len(self.edl.poses)
        if pose_index < count:
            return self.edl.poses[pose_index]
        if pose_index not in self._followed:
            while len(self._followed) >= _FOLLOWED:
                self._followed.pop(next(iter(self._followed)))
            self._followed[pose_index] = placed_pose(self.edl, pose_index - count)
        return self._followed[pose_index]

    def is_placed(self, pose_index: int, camera: str) -> bool:
        """Whether it is known where the camera's picture lies in pose ``pose_index``."""
        return self._placement(pose_index, camera)[1]

    def others(self, pose_index: int, camera: str) -> tuple[str, ...]:
        """The cameras that may stand in for ``camera`` in a pose: the reference, then by nearness of viewpoint."""
        return self._others.get((pose_index, camera), lambda: self._in_order(pose_index, camera))

    def _in_order(self, pose_index: int, camera: str) -> tuple[str, ...]:
        front, size = self._placement(pose_index, camera)[0], self.edl.camera(camera).size
        known = [c.name for c in self.edl.cameras if c.name != camera and self.is_placed(pose_index, c.name)]

        def apart(name: str) -> tuple[bool, float]:
            other = self._placement(pose_index, name)[0]
            return name != self.edl.reference, viewpoint_difference(front, other, size)

        return tuple(sorted(known, key=apart))

    def has_relief(self, pose_index: int, camera: str) -> bool:
        """Whether the pose's relief says where the camera's picture lies."""
        return has_relief(self.edl, self.pose(pose_index), camera)

    def warped(
        self,
        planes: Planes,
        pose_index: int,
        camera: str,
        offset: Offset,
        rect: Rect,
        *,
        laid: Laid = "plane",
        again: bool = False,
    ) -> Planes:
        """A camera's picture as it lies in the programme, by one resampling.

        Parameters
        ----------
        planes : Planes
            The camera's own picture.
        pose_index : int
            Index of the pose in the EDL.
        camera : str
            The camera's name.
        offset : (float, float)
            The centering's, in programme pixels.
        rect : Rect
            The part of the programme to make.
        laid : {"plane", "surface", "parallax", "edge"}
            By its homography alone; by the pose's relief; with the residual parallax taken out, everywhere or only
            towards the picture's edge, over 1/15 of the programme's width.
        again : bool
            The same warp will be asked for once more: its remap tables are kept.

        Returns
        -------
        Planes
            Of the size of ``rect``; black outside the picture.
        """
        warp_field = self._warp_field(pose_index, camera, laid)
        if warp_field is None:
            return warp_planes(planes, self._matrix(pose_index, camera, offset), rect, self._resampling)
        matrix = self._placement(pose_index, camera)[0]
        if not again:
            return warp_planes_by_field(planes, matrix, warp_field, rect, offset, self._resampling)
        key = pose_index, camera, laid, offset, rect
        tables = self._maps.get(key, lambda: warp_field_maps(matrix, warp_field, rect, offset))
        return remap_planes(planes, tables, self._resampling)

    def change(
        self, pose_index: int, camera: str, offset: Offset, frame: int, median_of: tuple[int, ...], *, laid: Laid
    ) -> NDArray[np.float32]:
        """How much a camera's picture differs from a median; see `FillContext.change`.

        Parameters
        ----------
        pose_index, camera, offset, laid
            As of `warped`.
        frame : int
            The programme frame of the picture.
        median_of : tuple of int
            Programme frames of one pose.

        Returns
        -------
        (ceil(height / 16), ceil(width / 16)) float32
            In 8-bit codes, by cell of the programme.
        """
        size = (-(-self.edl.size[0] // CELL), -(-self.edl.size[1] // CELL))
        now, before = self._level(camera, (frame,)), self._median_cells(camera, median_of)
        moving = pose_index >= len(self.edl.poses)  # everything differs from a median of the lamp at rest
        if now is None or before is None or moving or not self.is_placed(pose_index, camera):
            return np.zeros(size[::-1], np.float32)
        difference = np.max([cv2.absdiff(a, b) for a, b in zip(_cell_means(now), before, strict=True)], axis=0)
        difference = difference.astype(np.float32)
        warp_field = self._warp_field(pose_index, camera, laid)
        if warp_field is None:
            matrix = _TO_CELL @ self._matrix(pose_index, camera, offset) @ np.linalg.inv(_TO_CELL)
            return np.asarray(cv2.warpPerspective(difference, matrix, size), np.float32)
        middles = ((np.arange(n, dtype=np.float32) + 0.5) * CELL - 0.5 - by for n, by in zip(size, offset, strict=True))
        in_cells = self._placement(pose_index, camera)[0] @ np.linalg.inv(_TO_CELL)
        at = warp_field.source(in_cells, *(m.astype(np.float32) for m in np.meshgrid(*middles)))
        return np.asarray(cv2.remap(difference, at, None, cv2.INTER_LINEAR), np.float32)  # pyright: ignore

    def footprint(self, pose_index: int, camera: str, offset: Offset, laid: Laid) -> U8:
        """Which programme pixels lie inside the picture that `warped` makes.

        Parameters
        ----------
        pose_index, camera, offset, laid
            As of `warped`.

        Returns
        -------
        (height / 2, width / 2) uint8
            255 inside, less at the very edge.
        """
        width, height = self.edl.size
        if not self.is_placed(pose_index, camera):
            return np.zeros((height // 2, width // 2), np.uint8)
        size = self.edl.camera(camera).size
        warp_field = self._warp_field(pose_index, camera, laid)
        if warp_field is None:
            return footprint(size, self._matrix(pose_index, camera, offset), self.edl.size)
        return warp_field_footprint(size, self._placement(pose_index, camera)[0], warp_field, (width, height), offset)

    def _level(self, camera: str, frames: tuple[int, ...]) -> Planes | None:
        """Its own picture, or the median of several, without drift: light that changes is nobody who moves."""
        planes = self.own_picture(camera, frames[0]) if len(frames) == 1 else self.median(camera, frames)
        drift = drift_at(self.edl.poses[self.standing_at(frames[0])], camera, frames)
        return planes if planes is None or drift is None else apply_colour(planes, drift)

    def _median_cells(self, camera: str, median_of: tuple[int, ...]) -> list[U8] | None:
        def make() -> list[U8] | None:
            planes = self._level(camera, median_of)
            return None if planes is None else _cell_means(planes)

        return self._medians.get((camera, median_of), make)

    def _warp_field(self, pose_index: int, camera: str, laid: Laid) -> WarpField | None:
        """What is added to the camera's homography."""
        if laid == "plane":
            return None
        moving = pose_index >= len(self.edl.poses)
        if laid == "surface" and moving:
            pose = self.pose(pose_index)
            return self._edges.get((pose_index, camera), lambda: surface_of(self.edl, pose, camera, coarser=_MOVING))
        if laid == "surface":
            return self.parallax.by_relief(pose_index, camera)
        if moving:  # flow is between medians, and there is none of a lamp that moves
            return None
        if laid == "parallax":
            return self.parallax.of(pose_index, camera)

        def make() -> WarpField | None:
            warp_field, matrix = self.parallax.of(pose_index, camera), self._placement(pose_index, camera)[0]
            return warp_field and warp_field.tapered(self.edl.camera(camera).size, matrix, _EDGE * self.edl.size[0])

        return self._edges.get((pose_index, camera), make)

    def _matrix(self, pose_index: int, camera: str, offset: Offset) -> Homography:
        """As `programme_matrix`, each worked out once: a frame asks for some dozens."""
        matrix, known = self._placement(pose_index, camera)
        return translation(*offset) @ matrix if known else matrix

    def _placement(self, pose_index: int, camera: str) -> tuple[Homography, bool]:
        """Where a camera's picture lies before centering, and whether that is known."""

        def make() -> tuple[Homography, bool]:
            pose = self.pose(pose_index)
            known = placement_matrix(self.edl, pose, camera) is not None
            return programme_matrix(self.edl, pose, camera), known

        return self._placements.get((pose_index, camera), make)


def _facts(relief: Relief | None) -> Hashable:
    return relief and (tuple(sorted(relief.projections.items())), relief.gamma, relief.confidence)


def _places(view: MovementView) -> Hashable:
    return view.frame, tuple(sorted(view.homographies.items())), tuple(sorted(view.projections.items()))


def _cell_means(planes: Planes) -> list[U8]:
    """Each plane's means over 16 x 16 pixels, of every fourth or eighth sample: motion is no noise."""
    size = (-(-planes.size[0] // CELL), -(-planes.size[1] // CELL))
    parts = (planes.y[::8, ::8], planes.u[::4, ::4], planes.v[::4, ::4])
    return [np.asarray(cv2.resize(part, size, interpolation=cv2.INTER_AREA), np.uint8) for part in parts]
