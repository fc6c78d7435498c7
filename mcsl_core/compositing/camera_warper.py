"""Every camera as the programme sees it: decoded once, in its place, warped by one resampling."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from contextlib import ExitStack, closing
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.edl import Edl
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
)
from mcsl_core.lru_cache import LruCache
from mcsl_core.recording.footage import Footage, Player

from .parallax import Parallax
from .placement import programme_matrix

# Of what comes again frame after frame while the programme stands still, at 1080p; more of a larger programme.
_PICTURES_BYTES = 50_000_000  # warped looks at medians: 16 of the whole frame
_MAPS_BYTES = 60_000_000  # tables for remapping: 3 of the whole frame
_MEDIANS_BYTES = 5_000_000  # medians by cell, 24 kB each
_EDGES_BYTES = 5_000_000  # tapered warp fields, 80 kB each
_EDGE = 1 / 15  # of the programme's width: over so much the chosen camera's picture goes over into the others'
_TO_CELL = np.array([[1 / CELL, 0, 0.5 / CELL - 0.5], [0, 1 / CELL, 0.5 / CELL - 0.5], [0, 0, 1]])
Offset = tuple[float, float]  # the centering's, in programme pixels


class CameraWarper:
    """Looks at the footage through the programme's frame. For one thread; close it when done."""

    def __init__(self, edl: Edl, footage: Footage, resampling: Resampling, parallax: Parallax | None = None) -> None:
        self.edl, self.footage, self.parallax = edl, footage, parallax or Parallax(edl, footage)
        self._resampling: Resampling = resampling
        self.still = tuple(still_range(edl, pose) for pose in edl.poses)
        sizes = tuple((camera.name, camera.size) for camera in edl.cameras)
        places = tuple(placement_matrix(edl, pose, name) for pose in edl.poses for name, _ in sizes)
        self.geometry = hash((edl.size, edl.rate, edl.reference, sizes, self.still, places))
        self._edges: LruCache[WarpField | None] = LruCache(_EDGES_BYTES)
        self.others, self._placed = cache(self._others), cache(self._place)
        self._forget()
        self._stack = ExitStack()
        self._players: dict[str, Player] = {}

    def close(self) -> None:
        """Closes the decoders and forgets what was looked at; pictures handed out stay valid."""
        self._players.clear()
        self._forget()
        self._stack.close()

    def _forget(self) -> None:
        width, height = self.edl.size
        larger = max(1, width * height / (1920 * 1080))
        self.patches: LruCache[Planes | None] = LruCache(round(larger * _PICTURES_BYTES))
        self._maps: LruCache[RemapTables] = LruCache(round(larger * _MAPS_BYTES))
        self._medians: LruCache[list[U8] | None] = LruCache(round(larger * _MEDIANS_BYTES))

    def own_picture(self, camera: str, frame: int) -> Planes | None:
        """The camera's own picture at programme frame ``frame``, decoded once."""
        if camera not in self._players:
            self._players[camera] = self._stack.enter_context(closing(self.footage.player(camera)))
        return self._players[camera].at(frame)

    def median(self, camera: str, median_of: Sequence[int]) -> Planes | None:
        """The median of the camera's own pictures near ``median_of`` of one pose."""
        return self.footage.median(camera, median_of, self.still[self.pose_at(median_of[0])])

    def pose_at(self, frame: int) -> int:
        return bisect_right(self.edl.poses, frame, key=lambda pose: pose.range.start) - 1

    def knows(self, pose_index: int, camera: str) -> bool:
        """Whether it is known where the camera's picture lies in pose ``pose_index``."""
        return self._placed(pose_index, camera)[1]

    def _others(self, pose_index: int, camera: str) -> tuple[str, ...]:
        """Who may stand in for ``camera`` in a pose: the reference, then by closeness of viewpoint."""
        front, size = self._placed(pose_index, camera)[0], self.edl.camera(camera).size
        known = [c.name for c in self.edl.cameras if c.name != camera and self.knows(pose_index, c.name)]

        def apart(name: str) -> tuple[bool, float]:
            return name != self.edl.reference, viewpoint_difference(front, self._placed(pose_index, name)[0], size)

        return tuple(sorted(known, key=apart))

    def warped(self, planes: Planes, pose_index: int, camera: str, offset: Offset, rect: Rect) -> Planes:
        """What a picture of ``camera`` shows in ``rect`` of the programme in pose ``pose_index``."""
        return warp_planes(planes, self._matrix(pose_index, camera, offset), rect, self._resampling)

    def parallax_corrected(
        self, planes: Planes, pose_index: int, camera: str, offset: Offset, rect: Rect, *, edge: bool, again: bool
    ) -> Planes:
        """As `warped`, without parallax.

        edge: only towards its picture's edge. again: the same place will be asked for once more, so it is kept.
        """
        warp_field = self._warp_field(pose_index, camera, edge)
        if warp_field is None:
            return self.warped(planes, pose_index, camera, offset, rect)

        def make() -> RemapTables:
            return warp_field_maps(self._placed(pose_index, camera)[0], warp_field, rect, offset)

        key = pose_index, camera, edge, offset, rect
        return remap_planes(planes, self._maps.get(key, make) if again else make(), self._resampling)

    def change(
        self, pose_index: int, camera: str, offset: Offset, frame: int, median_of: tuple[int, ...]
    ) -> NDArray[np.float32]:
        """By how many codes a picture differs from a median in each cell of the programme; see `filling.View`."""
        size = (-(-self.edl.size[0] // CELL), -(-self.edl.size[1] // CELL))
        now, before = self.own_picture(camera, frame), self._median_cells(camera, median_of)
        if now is None or before is None or not self.knows(pose_index, camera):
            return np.zeros(size[::-1], np.float32)
        difference = np.max([cv2.absdiff(*pair) for pair in zip(_cells(now), before, strict=True)], axis=0)
        matrix = _TO_CELL @ self._matrix(pose_index, camera, offset) @ np.linalg.inv(_TO_CELL)
        return np.asarray(cv2.warpPerspective(difference.astype(np.float32), matrix, size), np.float32)

    def _median_cells(self, camera: str, median_of: tuple[int, ...]) -> list[U8] | None:
        def make() -> list[U8] | None:
            planes = self.median(camera, median_of)
            return None if planes is None else _cells(planes)

        return self._medians.get((camera, median_of), make)

    def _warp_field(self, pose_index: int, camera: str, edge: bool) -> WarpField | None:
        if not edge:
            return self.parallax.of(pose_index, camera)

        def make() -> WarpField | None:
            warp_field, matrix = self.parallax.of(pose_index, camera), self._placed(pose_index, camera)[0]
            return warp_field and warp_field.tapered(self.edl.camera(camera).size, matrix, _EDGE * self.edl.size[0])

        return self._edges.get((pose_index, camera), make)

    def footprint(self, pose_index: int, camera: str, offset: Offset, *, parallax_corrected: bool, edge: bool) -> U8:
        """(height / 2, width / 2): 255 where `warped` or `parallax_corrected` shows something."""
        width, height = self.edl.size
        if not self.knows(pose_index, camera):
            return np.zeros((height // 2, width // 2), np.uint8)
        size, warp_field = (
            self.edl.camera(camera).size,
            self._warp_field(pose_index, camera, edge) if parallax_corrected else None,
        )
        if warp_field is None:
            return footprint(size, self._matrix(pose_index, camera, offset), self.edl.size)
        return warp_field_footprint(
            size, warp_field_maps(self._placed(pose_index, camera)[0], warp_field, Rect(0, 0, width, height), offset)
        )

    def _matrix(self, pose_index: int, camera: str, offset: Offset) -> Homography:
        """As `programme_matrix`, each worked out once: a frame asks for some dozens."""
        matrix, known = self._placed(pose_index, camera)
        return translation(*offset) @ matrix if known else matrix

    def _place(self, pose_index: int, camera: str) -> tuple[Homography, bool]:
        """Where a camera's picture lies before centering, and whether that is known."""
        pose = self.edl.poses[pose_index]
        matrix = programme_matrix(self.edl, pose, camera)
        return matrix, placement_matrix(self.edl, pose, camera) is not None


def _cells(planes: Planes) -> list[U8]:
    """Each plane's means over 16 x 16 pixels, of every fourth or eighth sample: noise is not what is looked for."""
    size = (-(-planes.size[0] // CELL), -(-planes.size[1] // CELL))
    parts = (planes.y[::8, ::8], planes.u[::4, ::4], planes.v[::4, ::4])
    return [np.asarray(cv2.resize(part, size, interpolation=cv2.INTER_AREA), np.uint8) for part in parts]
