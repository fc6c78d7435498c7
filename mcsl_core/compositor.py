"""One programme frame: one single resampling from camera pixel to programme pixel, colour, fill.

Everything that makes programme pictures comes through here. Pictures are `Planes` (4:2:0, BT.709 limited) and each
plane is warped by itself: half the pixels of BGR, and no conversion. Matrices map camera pixel to programme pixel:
translate(centering offset) @ anchor @ homography, composed in float64.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import ExitStack, closing
from itertools import chain
from typing import Literal

import attrs
import cv2
import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from .colour import apply
from .decisions import Decision, fitted, placed, resolve, shift_at
from .edl import Edl, Look, Pose
from .filling import Filler, FootprintFiller, Rect, ShowOrigin, viewpoint_difference
from .footage import Footage, Player
from .images import BLACK, U8, Planes, black, blurred, median_planes
from .timing import FrameRange

VERSION = 3  # rises when the same EDL and media come out differently: conformed chunks are then made again
# Chroma sample (i, j) lies at luma (2i, 2j + 1/2): MPEG-2's siting, which H.264 and HEVC have by default.
_CHROMA = np.array([[2.0, 0, 0], [0, 2.0, 0.5], [0, 0, 1]])
_FROM_CHROMA = np.linalg.inv(_CHROMA)
BLOCK_S = 10  # conformed chunks, and what a filler that remembers begins anew, lie on one grid
_GRID = 4.0  # while the centering moves, footprints are worked out anew every so many pixels
_KEPT_BYTES = 48_000_000  # of warped looks at other moments, which come again frame after frame

Matrix = NDArray[np.float64]
Resampling = Literal["linear", "lanczos"]  # Lanczos-4 is sharper, at ten times the cost
_WHITE = (235, 240, 240)  # limited range


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


def warp_planes(planes: Planes, matrix: Matrix, rect: Rect, resampling: Resampling = "linear") -> Planes:
    """What lies in ``rect`` of the programme, black outside the picture.

    A plane that only moves by whole samples is not resampled: it keeps every bit, and the identity is ``planes``
    itself.
    """
    m = np.array(matrix)
    m[0] -= rect.x * m[2]
    m[1] -= rect.y * m[2]
    m /= m[2, 2]
    size, half = (rect.width, rect.height), (rect.width // 2, rect.height // 2)
    shift = _shift(m)
    if shift == (0, 0) and planes.size == size:
        return planes
    if shift is not None and shift[0] % 2 == 0 and shift[1] % 2 == 0:
        dx, dy = shift
        return Planes(
            _moved(planes.y, dx, dy, size, BLACK[0]),
            _moved(planes.u, dx // 2, dy // 2, half, BLACK[1]),
            _moved(planes.v, dx // 2, dy // 2, half, BLACK[2]),
        )
    chroma = _FROM_CHROMA @ m @ _CHROMA
    return Planes(
        _moved(planes.y, *shift, size, BLACK[0]) if shift else _warped(planes.y, m, size, 0, resampling),
        _warped(planes.u, chroma, half, 1, resampling),
        _warped(planes.v, chroma, half, 2, resampling),
    )


def _shift(m: Matrix) -> tuple[int, int] | None:
    """(dx, dy) of a matrix that moves by whole pixels, to a millionth, and does nothing else."""
    (a, b, x), (c, d, y), (e, f, _) = m.tolist()
    if max(abs(a - 1), abs(b), abs(c), abs(d - 1), 1000 * abs(e), 1000 * abs(f)) > 1e-9:
        return None
    dx, dy = round(x), round(y)
    return (dx, dy) if max(abs(x - dx), abs(y - dy)) < 1e-6 else None


def _moved(plane: U8, dx: int, dy: int, size: tuple[int, int], black: int) -> U8:
    """``plane`` moved by whole samples on a (width, height) of ``black``; a view of it where it reaches everywhere."""
    width, height = size
    if dx <= 0 and dy <= 0 and width - dx <= plane.shape[1] and height - dy <= plane.shape[0]:
        return plane[-dy : height - dy, -dx : width - dx]
    out = np.full((height, width), black, np.uint8)
    left, top = max(dx, 0), max(dy, 0)
    part = plane[top - dy : max(height - dy, 0), left - dx : max(width - dx, 0)]
    out[top : top + part.shape[0], left : left + part.shape[1]] = part
    return out


def _warped(plane: U8, matrix: Matrix, size: tuple[int, int], index: int, resampling: Resampling) -> U8:
    """The plane with that ``index`` (Y', Cb, Cr) resampled through ``matrix``, between its own samples."""
    flags = cv2.INTER_LINEAR if resampling == "linear" else cv2.INTER_LANCZOS4
    black = BLACK[index]
    warped: U8 = cv2.warpPerspective(  # pyright: ignore[reportAssignmentType]
        plane, matrix, size, flags=flags, borderMode=cv2.BORDER_CONSTANT, borderValue=black
    )
    if resampling == "linear":
        return warped
    # Lanczos overshoots at edges: to no code outside limited range that the source has not itself.
    low, high, *_ = cv2.minMaxLoc(plane)
    return warped.clip(min(16, int(low)), max(_WHITE[index], int(high)), out=warped)


def footprint(size: tuple[int, int], matrix: Matrix, programme: tuple[int, int]) -> U8:
    """(height / 2, width / 2) of the ``programme``: 255 where a camera of ``size`` sees it, on the chroma grid.

    Between at its edge: a mask of ones and nothings has steps of two pixels, which show.
    """
    inside = np.full((size[1] // 2, size[0] // 2), 255, np.uint8)
    chroma = _FROM_CHROMA @ matrix @ _CHROMA
    half = (programme[0] // 2, programme[1] // 2)
    return cv2.warpPerspective(inside, chroma, half, flags=cv2.INTER_LINEAR)  # pyright: ignore[reportReturnType]


def stretches(edl: Edl) -> tuple[tuple[FrameRange, Decision, int], ...]:
    """What the viewer gets, cut also where poses meet: range, decision, number of the pose. They tile [0, frames)."""
    found, number = [], 0
    for piece, decision in resolve(edl):
        while edl.poses[number].range.stop <= piece.start:
            number += 1
        for at in range(number, len(edl.poses)):
            part = piece.intersection(edl.poses[at].range)
            if part is None:
                break
            found.append((part, decision, at))
    return tuple(found)


def still_range(edl: Edl, pose: Pose) -> FrameRange:
    """The stretch of ``pose`` in which the lamp stands still; all of it where it never does."""
    start, stop = pose.range.start, pose.range.stop
    for movement in edl.movements:
        if start in movement.range:
            start = movement.range.stop
        if stop - 1 in movement.range:
            stop = movement.range.start
    return FrameRange(start, stop) if start < stop else pose.range


def elsewhere(edl: Edl, number: int) -> tuple[int, ...]:
    """The other poses of the perspective of pose ``number``: earlier ones, the latest first, then later ones."""
    same = [i for i, pose in enumerate(edl.poses) if pose.perspective == edl.poses[number].perspective]
    return (*(i for i in reversed(same) if i < number), *(i for i in same if i > number))


def covered(edl: Edl, pose: Pose, offsets: Sequence[tuple[float, float]]) -> bool:
    """Whether some camera of ``pose`` sees every programme pixel, under all ``offsets`` and what lies between them."""
    scale = 1 / 8
    (left, right), (top, bottom) = ((min(v), max(v)) for v in zip(*offsets, strict=True))
    size = tuple(int((v + b - a) * scale) + 2 for v, a, b in zip(edl.size, (left, top), (right, bottom), strict=True))
    to_grid = np.diag([scale, scale, 1.0]) @ translation(right, bottom)
    seen = np.zeros(size[::-1], np.uint8)
    for camera in edl.cameras:
        if placed(edl, pose, camera.name) is not None:
            ones = np.full((camera.size[1] // 8, camera.size[0] // 8), 255, np.uint8)
            matrix = to_grid @ programme_matrix(edl, pose, camera.name) @ np.diag([8.0, 8.0, 1.0])
            mask = cv2.warpPerspective(ones, matrix, size, flags=cv2.INTER_NEAREST)
            seen |= np.asarray(cv2.erode(mask, np.ones((3, 3), np.uint8), borderType=cv2.BORDER_REPLICATE), np.uint8)
    return bool(seen.all())


def remembered(start: int) -> tuple[int, ...]:
    """The frames by which the memory of a block from ``start`` on is made: 1, 2, 4, 8, ... before it, in order.

    What was seen long ago stays, at the cost of a handful of frames, and wherever one begins the memory is the same.
    """
    return tuple(start - (1 << k) for k in reversed(range(start.bit_length())))


def block_frames(edl: Edl) -> int:
    """Frames in a block of the programme: a conformed chunk, or what a filler that remembers makes in one go."""
    return max(1, round(BLOCK_S * edl.rate))


@frozen(eq=False)
class _View:
    """One programme frame before filling; see `filling.View`. Looks at other cameras only when asked to."""

    compositor: Compositor
    frame: int
    camera: str
    front: Planes
    number: int
    offset: tuple[float, float]
    colour: bool
    steady: bool  # the centering stands still
    previous: Planes | None = field(default=None)

    @property
    def rate(self) -> float:
        return float(self.compositor.edl.rate)

    @property
    def size(self) -> tuple[int, int]:
        return self.compositor.edl.size

    @property
    def others(self) -> Sequence[str]:
        return self.compositor.others(self.number, self.camera)

    @property
    def still(self) -> FrameRange:
        return self.compositor.still[self.number]

    @property
    def elsewhere(self) -> Sequence[FrameRange]:
        return [self.compositor.still[i] for i in elsewhere(self.compositor.edl, self.number)]

    @property
    def geometry(self) -> Hashable:
        return self.compositor.geometry, self.number, self.camera, self.steady, *self._about()

    def _about(self) -> tuple[float, float]:
        if self.steady:
            return self.offset
        dx, dy = (round(v / _GRID) * _GRID for v in self.offset)
        return dx, dy

    def footprint(self, camera: str, frame: int | None = None) -> U8:
        edl = self.compositor.edl
        number = self.number if frame is None else self.compositor.pose_number(frame)
        if not self.compositor.knows(number, camera):
            return np.zeros((edl.size[1] // 2, edl.size[0] // 2), np.uint8)
        mask = footprint(edl.camera(camera).size, self.compositor.matrix(number, camera, self._about()), edl.size)
        if not self.steady:  # shared by offsets up to half the grid away: seen by all of them
            mask = cv2.erode(mask, np.ones((3, 3), np.uint8), borderType=cv2.BORDER_REPLICATE)
        return mask  # pyright: ignore[reportReturnType]

    def look(self, camera: str, rect: Rect, moments: Sequence[int] = (), blur_px: float = 0.0) -> Planes | None:
        if not moments:
            planes = self._look(camera, rect, self.compositor.picture(camera, self.frame), self.number)
            return planes if planes is None or not blur_px else blurred(planes, blur_px)
        key = camera, rect, tuple(moments), blur_px, self.offset, self.colour
        return self.compositor.patches.of(key, lambda: self._median(camera, rect, moments, blur_px))

    def _median(self, camera: str, rect: Rect, moments: Sequence[int], blur_px: float) -> Planes | None:
        number = self.compositor.pose_number(moments[0])
        if not self.compositor.knows(number, camera):
            return None
        border = 2 * round(1.5 * blur_px)
        wide = rect.grown(border)
        pictures = (self.compositor.footage.moment(camera, frame) for frame in moments)
        looks = [look for picture in pictures if (look := self._look(camera, wide, picture, number)) is not None]
        if not looks:
            return None
        planes = looks[0] if len(looks) == 1 else median_planes(looks)
        return Rect(border, border, rect.width, rect.height).of(blurred(planes, blur_px)) if border else planes

    def _look(self, camera: str, rect: Rect, planes: Planes | None, number: int) -> Planes | None:
        if planes is None:
            return None
        patch = self.compositor.warped(planes, number, camera, self.offset, rect)
        match = self.compositor.edl.poses[number].colour.get(camera) if self.colour else None
        return patch if match is None else apply(patch, match)


class _Patches:
    """Looks at other moments: while the programme stands still they are the same for every frame."""

    def __init__(self) -> None:
        self._kept: dict[Hashable, Planes | None] = {}
        self._bytes = 0

    def of(self, key: Hashable, make: Callable[[], Planes | None]) -> Planes | None:
        if key not in self._kept:
            if self._bytes > _KEPT_BYTES:
                self._kept.clear()
                self._bytes = 0
            found = self._kept[key] = make()
            self._bytes += 0 if found is None else found.y.size * 3 // 2
        return self._kept[key]


@frozen(eq=False)
class _Made:
    """A finished frame, and the perspective it is laid for."""

    perspective: int
    planes: Planes


class Compositor:
    """Makes programme frames from an EDL and its footage. For one thread; close it, or use it as a context manager.

    A frame depends on its number and the EDL alone, not on the stretch it is made in. filler: fills what the chosen
    camera does not reach (`FootprintFiller` by default). look: in place of the EDL's look and of the overrides' looks,
    for a comparison with or without the aids.
    """

    def __init__(
        self,
        edl: Edl,
        footage: Footage,
        *,
        filler: Filler | None = None,
        look: Look | None = None,
        resampling: Resampling = "linear",
    ) -> None:
        self.edl, self.footage, self.filler = edl, footage, filler or FootprintFiller()
        self._resampling: Resampling = resampling
        self._stretches = tuple((part, _looked(decision, look), number) for part, decision, number in stretches(edl))
        self._matrices: dict[tuple[int, str], tuple[Matrix, bool]] = {}
        self.still = tuple(still_range(edl, pose) for pose in edl.poses)
        sizes = tuple((camera.name, camera.size) for camera in edl.cameras)
        places = tuple(placed(edl, pose, name) for pose in edl.poses for name, _ in sizes)
        self.geometry = hash((edl.size, edl.rate, edl.reference, sizes, self.still, places))
        self.patches = _Patches()
        self._others: dict[tuple[int, str], tuple[str, ...]] = {}
        self._stack = ExitStack()
        self._players: dict[str, Player] = {}

    def __enter__(self) -> Compositor:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Closes the decoders and forgets what was looked at; frames handed out stay valid."""
        self._players.clear()
        self.patches = _Patches()
        self._stack.close()

    def picture(self, camera: str, frame: int) -> Planes | None:
        """The camera's own picture at programme frame ``frame``, decoded once."""
        if camera not in self._players:
            self._players[camera] = self._stack.enter_context(closing(self.footage.player(camera)))
        return self._players[camera].at(frame)

    def pose_number(self, frame: int) -> int:
        return bisect_right(self.edl.poses, frame, key=lambda pose: pose.range.start) - 1

    def knows(self, number: int, camera: str) -> bool:
        """Whether it is known where the camera's picture lies in pose ``number``."""
        return self._placed(number, camera)[1]

    def matrix(self, number: int, camera: str, offset: tuple[float, float]) -> Matrix:
        """As `programme_matrix`, each worked out once: a frame asks for some dozens."""
        matrix, known = self._placed(number, camera)
        return translation(*offset) @ matrix if known else matrix

    def _placed(self, number: int, camera: str) -> tuple[Matrix, bool]:
        key = number, camera
        if key not in self._matrices:
            pose = self.edl.poses[number]
            matrix = programme_matrix(self.edl, pose, camera)
            self._matrices[key] = matrix, placed(self.edl, pose, camera) is not None
        return self._matrices[key]

    def warped(self, planes: Planes, number: int, camera: str, offset: tuple[float, float], rect: Rect) -> Planes:
        """What a picture of ``camera`` shows in ``rect`` of the programme in pose ``number``."""
        return warp_planes(planes, self.matrix(number, camera, offset), rect, self._resampling)

    def others(self, number: int, camera: str) -> tuple[str, ...]:
        """Who may stand in for ``camera`` in a pose: the reference, then by closeness of viewpoint."""
        key = number, camera
        if key not in self._others:
            front, size = self._placed(number, camera)[0], self.edl.camera(camera).size
            known = [c.name for c in self.edl.cameras if c.name != camera and self.knows(number, c.name)]

            def apart(name: str) -> tuple[bool, float]:
                return name != self.edl.reference, viewpoint_difference(front, self._placed(number, name)[0], size)

            self._others[key] = tuple(sorted(known, key=apart))
        return self._others[key]

    def frames(self, piece: FrameRange) -> Iterator[Planes]:
        """The programme's pictures over ``piece``, of the programme's size. Treat as read-only."""
        made: _Made | None = None
        block = block_frames(self.edl)
        try:
            for frame in piece:
                if self.filler.remembers and (frame == piece.start or frame % block == 0):
                    made = None
                    start = frame - frame % block
                    for before in chain(remembered(start), range(start, frame)):
                        made = self._at(before, made)
                made = self._at(frame, made if self.filler.remembers else None)
                yield made.planes
        finally:
            self.close()

    def _at(self, frame: int, before: _Made | None) -> _Made:
        _, decision, number = self._stretches[bisect_right(self._stretches, frame, key=lambda s: s[0].start) - 1]
        perspective = self.edl.poses[number].perspective
        # In another perspective the frame before lies elsewhere: nothing in it belongs here.
        known = before.planes if before is not None and before.perspective == perspective else None
        return _Made(perspective, self._frame(frame, decision, number, known))

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
        front = self.warped(planes, number, camera, offset, Rect(0, 0, *edl.size))
        steady = all(shift_at(edl, decision, near) == offset for near in (frame - 1, frame + 1))
        view = _View(self, frame, camera, front, number, offset, decision.colour, steady, previous)
        if decision.fill and self.knows(number, camera):
            return self.filler.fill(view)
        return self.filler.bare(view) if isinstance(self.filler, ShowOrigin) else front


def _looked(decision: Decision, look: Look | None) -> Decision:
    if look is None:
        return decision
    return attrs.evolve(decision, centering=look.centering, fill=look.fill, colour=look.colour)
