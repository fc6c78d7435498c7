"""From camera pixel to programme pixel by one single resampling, each of a picture's planes by itself.

Half the pixels of BGR, and no conversion. Matrices are 3x3 and map camera pixel to programme pixel.
"""

from __future__ import annotations

from typing import Literal

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from .geometry import Homography, translation
from .planes import BLACK, U8, Planes
from .rect import Rect

# Chroma sample (i, j) lies at luma (2i, 2j + 1/2): MPEG-2's siting, which H.264 and HEVC have by default.
_CHROMA = np.array([[2.0, 0, 0], [0, 2.0, 0.5], [0, 0, 1]])
_FROM_CHROMA = np.linalg.inv(_CHROMA)
_WHITE = (235, 240, 240)  # limited range
_NODE = 8
Resampling = Literal["linear", "lanczos"]  # Lanczos-4 is sharper, at ten times the cost


def warp_planes(planes: Planes, matrix: Homography, rect: Rect, resampling: Resampling = "linear") -> Planes:
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


def _shift(m: Homography) -> tuple[int, int] | None:
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


def _warped(plane: U8, matrix: Homography, size: tuple[int, int], index: int, resampling: Resampling) -> U8:
    """The plane with that ``index`` (Y', Cb, Cr) resampled through ``matrix``, between its own samples."""
    flags = cv2.INTER_LINEAR if resampling == "linear" else cv2.INTER_LANCZOS4
    black = BLACK[index]
    warped: U8 = cv2.warpPerspective(  # pyright: ignore[reportAssignmentType]
        plane, matrix, size, flags=flags, borderMode=cv2.BORDER_CONSTANT, borderValue=black
    )
    return warped if resampling == "linear" else _limited(warped, plane, index)


def _limited(warped: U8, plane: U8, index: int) -> U8:
    """Lanczos overshoots at edges: to no code outside limited range that the source has not itself."""
    low, high, *_ = cv2.minMaxLoc(plane)
    return warped.clip(min(16, int(low)), max(_WHITE[index], int(high)), out=warped)


def footprint(size: tuple[int, int], matrix: Homography, programme: tuple[int, int]) -> U8:
    """(height / 2, width / 2) of the ``programme``: 255 where a camera of ``size`` sees it, on the chroma grid.

    Between at its edge: a mask of ones and nothings has steps of two pixels, which show.
    """
    inside = np.full((size[1] // 2, size[0] // 2), 255, np.uint8)
    chroma = _FROM_CHROMA @ matrix @ _CHROMA
    half = (programme[0] // 2, programme[1] // 2)
    return cv2.warpPerspective(inside, chroma, half, flags=cv2.INTER_LINEAR)  # pyright: ignore[reportReturnType]


# --------------------------------------------------------------------------------------------------------- bending


@frozen(eq=False)
class WarpField:
    """Where a picture, warped by its homography, has what belongs at a programme pixel: so many pixels beside it.

    shift: (h, w, 2) float32, x and y in programme pixels, at nodes ``step`` pixels apart from ``corner`` on; linear in
    between, and beyond the outermost nodes as at them.
    """

    shift: NDArray[np.float32]
    corner: tuple[float, float]
    step: float

    def at(self, x: NDArray[np.float32], y: NDArray[np.float32]) -> NDArray[np.float32]:
        """(..., 2) at programme pixels ``x``, ``y`` of one 2-D shape."""
        columns, rows = ((v - c) / self.step for v, c in zip((x, y), self.corner, strict=True))
        found = cv2.remap(self.shift, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(found, np.float32)

    def tapered(self, size: tuple[int, int], matrix: Homography, width_px: float) -> WarpField:
        """Whole where a camera of ``size`` sees nothing, fading out over ``width_px`` towards its picture's middle."""
        x, y = self.corner
        to_nodes = np.diag([1 / self.step, 1 / self.step, 1.0]) @ translation(-x, -y)
        ones = np.full((size[1], size[0]), 255, np.uint8)
        inside = cv2.warpPerspective(ones, to_nodes @ matrix, self.shift.shape[1::-1], flags=cv2.INTER_NEAREST)
        depth = cv2.distanceTransform(inside, cv2.DIST_L2, 5) * (self.step / width_px)
        left = np.clip(1 - depth, 0, 1)
        return WarpField(
            self.shift * (left * left * (3 - 2 * left))[..., None].astype(np.float32), self.corner, self.step
        )


@frozen(eq=False)
class RemapTables:
    """Where in the camera's planes each luma and each chroma sample of a rectangle lies: (h, w, 2) float32, x and y."""

    luma: NDArray[np.float32]
    chroma: NDArray[np.float32]


def warp_field_maps(
    matrix: Homography, warp_field: WarpField, rect: Rect, offset: tuple[float, float] = (0.0, 0.0)
) -> RemapTables:
    """The inverse of ``matrix`` after ``warp_field``, for the programme shifted by ``offset``.

    Worked out at every eighth pixel and linear between: a homography of a lamp's camera bends by 0.01 pixels there.
    """
    left, top = rect.x - offset[0], rect.y - offset[1]
    luma = _map(matrix, warp_field, (left, top), (rect.width, rect.height), _NODE)
    # In chroma samples, of which (i, j) lies at luma (2 i, 2 j + 1/2): half a luma pixel left of its cell's middle.
    half = (rect.width // 2, rect.height // 2)
    return RemapTables(luma, _map(matrix @ _CHROMA, warp_field, (left - 0.5, top), half, _NODE // 2))


def _map(
    matrix: Homography, warp_field: WarpField, corner: tuple[float, float], size: tuple[int, int], samples: int
) -> NDArray[np.float32]:
    """(h, w, 2): where in the camera's plane lies what is seen at nodes `_NODE` pixels apart; ``samples`` a node."""
    # `cv2.resize` sets node k in the middle of its samples and ends with the outermost: one more each side.
    columns, rows = (-(-n // samples) + 2 for n in size)
    x, y = np.meshgrid(
        *(
            (np.arange(n, dtype=np.float32) - 0.5) * _NODE - 0.5 + c
            for n, c in zip((columns, rows), corner, strict=True)
        )
    )
    x, y = x.astype(np.float32), y.astype(np.float32)
    at = (np.stack([x, y], axis=-1) + warp_field.at(x, y)).astype(np.float64)
    nodes = cv2.perspectiveTransform(at, np.linalg.inv(matrix)).astype(np.float32)
    wide = cv2.resize(nodes, (samples * columns, samples * rows), interpolation=cv2.INTER_LINEAR)
    return np.asarray(wide[samples : samples + size[1], samples : samples + size[0]], np.float32)


def remap_planes(planes: Planes, maps: RemapTables, resampling: Resampling = "linear") -> Planes:
    """What lies in the rectangle of ``maps``, black outside the picture."""
    flags = cv2.INTER_LINEAR if resampling == "linear" else cv2.INTER_LANCZOS4
    found = []
    for index, (plane, at) in enumerate(zip(planes, (maps.luma, maps.chroma, maps.chroma), strict=True)):
        out = _remapped(plane, at, flags, BLACK[index])
        found.append(out if resampling == "linear" else _limited(out, plane, index))
    return Planes(*found)


def warp_field_footprint(size: tuple[int, int], maps: RemapTables) -> U8:
    """As `footprint`, where the picture is bent."""
    inside = np.full((size[1] // 2, size[0] // 2), 255, np.uint8)
    return _remapped(inside, maps.chroma, cv2.INTER_LINEAR, 0)


def _remapped(plane: U8, at: NDArray[np.float32], flags: int, black: int) -> U8:
    # Fixed-point maps, which older OpenCVs liked best, take twice as long as these.
    return cv2.remap(plane, at, None, flags, borderMode=cv2.BORDER_CONSTANT, borderValue=black)  # pyright: ignore
