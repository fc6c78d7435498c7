"""One programme frame: one single resampling from camera pixel to programme pixel, colour, fill.

Everything that makes programme pictures comes through here. Pictures are `Planes` (4:2:0, BT.709 limited) and each
plane is warped by itself: half the pixels of BGR, and no conversion. Matrices map camera pixel to programme pixel:
translate(centering offset) @ anchor @ homography, composed in float64.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from contextlib import ExitStack, closing

import attrs
import cv2
import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from .colour import apply
from .decisions import Decision, fitted, placed, resolve, shift_at
from .edl import Edl, Look, Pose
from .filling import Filler, FootprintFiller, Rect
from .footage import Footage, Player
from .images import BLACK, U8, Planes, black
from .timing import FrameRange

VERSION = 1  # rises when the same EDL and media come out differently: conformed chunks are then made again
# Chroma sample (i, j) lies at luma (2i, 2j + 1/2): MPEG-2's siting, which H.264 and HEVC have by default.
_CHROMA = np.array([[2.0, 0, 0], [0, 2.0, 0.5], [0, 0, 1]])
_FROM_CHROMA = np.linalg.inv(_CHROMA)
_GRID = 4.0  # footprints are worked out anew when the centering has moved by this many pixels

Matrix = NDArray[np.float64]


def translation(dx: float, dy: float) -> Matrix:
    return np.array([[1.0, 0, dx], [0, 1.0, dy], [0, 0, 1]])


def programme_matrix(edl: Edl, pose: Pose, camera: str, offset: tuple[float, float] = (0.0, 0.0)) -> Matrix:
    """Camera pixel -> programme pixel in ``pose``, shifted by the centering ``offset`` in programme pixels.

    A camera that the pose has no homography for (a weak one an editor chose) fills the frame as it is: where its
    picture lies is not known, so neither the anchor nor the centering means anything for it.
    """
    known = placed(edl, pose, camera)
    if known is None:
        return np.array(fitted(edl.camera(camera).size, edl.size))
    matrix = translation(*offset) @ np.array(known, np.float64)
    return matrix / matrix[2, 2]


def warp_planes(planes: Planes, matrix: Matrix, rect: Rect) -> Planes:
    """What lies in ``rect`` of the programme, bilinear, black outside the picture; the identity changes no bit."""
    matrix = translation(-rect.x, -rect.y) @ matrix
    size = (rect.width, rect.height)
    if planes.size == size and np.abs(matrix / matrix[2, 2] - np.eye(3)).max() < 1e-9:
        return planes
    chroma = _FROM_CHROMA @ matrix @ _CHROMA
    half = (rect.width // 2, rect.height // 2)
    y, u, v = (
        cv2.warpPerspective(plane, m, s, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=edge)
        for plane, m, s, edge in zip(planes, (matrix, chroma, chroma), (size, half, half), BLACK, strict=True)
    )
    return Planes(y, u, v)  # pyright: ignore[reportArgumentType]


def footprint(size: tuple[int, int], matrix: Matrix, programme: tuple[int, int]) -> U8:
    """(height / 2, width / 2) of the ``programme``: 255 where a camera of ``size`` sees it, on the chroma grid."""
    inside = np.full((size[1] // 2, size[0] // 2), 255, np.uint8)
    chroma = _FROM_CHROMA @ matrix @ _CHROMA
    half = (programme[0] // 2, programme[1] // 2)
    return cv2.warpPerspective(inside, chroma, half, flags=cv2.INTER_NEAREST)  # pyright: ignore[reportReturnType]


@frozen(eq=False)
class _View:
    """One programme frame before filling; see `filling.View`. Looks at other cameras only when asked to."""

    compositor: Compositor
    frame: int
    camera: str
    front: Planes
    others: Sequence[str]
    geometry: Hashable
    pose: Pose
    offset: tuple[float, float]
    colour: bool
    previous: Planes | None = field(default=None)

    @property
    def size(self) -> tuple[int, int]:
        return self.compositor.edl.size

    def footprint(self, camera: str) -> U8:
        edl = self.compositor.edl
        dx, dy = (round(v / _GRID) * _GRID for v in self.offset)
        mask = footprint(edl.camera(camera).size, programme_matrix(edl, self.pose, camera, (dx, dy)), edl.size)
        if (dx, dy) != self.offset:  # shared by offsets up to half the grid away: seen by all of them
            mask = cv2.erode(mask, np.ones((3, 3), np.uint8), borderType=cv2.BORDER_REPLICATE)
        return mask  # pyright: ignore[reportReturnType]

    def look(self, camera: str, rect: Rect) -> Planes | None:
        planes = self.compositor.picture(camera, self.frame)
        if planes is None:
            return None
        patch = warp_planes(planes, programme_matrix(self.compositor.edl, self.pose, camera, self.offset), rect)
        match = self.pose.colour.get(camera) if self.colour else None
        return patch if match is None else apply(patch, match)


class Compositor:
    """Makes programme frames from an EDL and its footage. For one thread; close it, or use it as a context manager.

    filler: fills what the chosen camera does not reach (`FootprintFiller` by default). look: in place of the EDL's
    look and of the overrides' looks, for a comparison with or without the aids.
    """

    def __init__(self, edl: Edl, footage: Footage, *, filler: Filler | None = None, look: Look | None = None) -> None:
        self.edl, self.footage, self.filler = edl, footage, filler or FootprintFiller()
        self._stretches = tuple(
            (part, _looked(decision, look), number)
            for piece, decision in resolve(edl)
            for number, pose in enumerate(edl.poses)
            if (part := piece.intersection(pose.range))
        )
        self._stack = ExitStack()
        self._players: dict[str, Player] = {}

    def __enter__(self) -> Compositor:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Closes the decoders; frames handed out stay valid."""
        self._players.clear()
        self._stack.close()

    def picture(self, camera: str, frame: int) -> Planes | None:
        """The camera's own picture at programme frame ``frame``, decoded once."""
        if camera not in self._players:
            self._players[camera] = self._stack.enter_context(closing(self.footage.player(camera)))
        return self._players[camera].at(frame)

    def frames(self, piece: FrameRange) -> Iterator[Planes]:
        """The programme's pictures over ``piece``, of the programme's size. Treat as read-only."""
        previous: Planes | None = None
        first = max(0, piece.start - self.filler.memory_frames)
        try:
            for stretch, decision, pose in self._stretches:
                part = stretch.intersection(FrameRange(first, piece.stop))
                for frame in part or ():
                    planes = self._frame(frame, decision, pose, previous)
                    if self.filler.memory_frames:
                        previous = planes
                    if frame >= piece.start:
                        yield planes
        finally:
            self.close()

    def _frame(self, frame: int, decision: Decision, number: int, previous: Planes | None) -> Planes:
        edl, pose = self.edl, self.edl.poses[number]
        camera = decision.camera
        planes = self.picture(camera, frame)
        if planes is None and camera != edl.reference:
            camera = edl.reference
            planes = self.picture(camera, frame)
        if planes is None:
            return black(edl.size)
        offset = shift_at(edl, decision, frame)
        match = pose.colour.get(camera) if decision.colour else None
        if match is not None:
            planes = apply(planes, match)
        whole = Rect(0, 0, *edl.size)
        front = warp_planes(planes, programme_matrix(edl, pose, camera, offset), whole)
        known = [c.name for c in edl.cameras if placed(edl, pose, c.name) is not None]
        if not decision.fill or camera not in known:
            return front
        others = sorted((name for name in known if name != camera), key=lambda name: name != edl.reference)
        grid = (round(offset[0] / _GRID), round(offset[1] / _GRID))
        geometry = (number, camera, grid)
        view = _View(self, frame, camera, front, others, geometry, pose, offset, decision.colour, previous)
        return self.filler.fill(view)


def _looked(decision: Decision, look: Look | None) -> Decision:
    if look is None:
        return decision
    return attrs.evolve(decision, centering=look.centering, fill=look.fill, colour=look.colour)
