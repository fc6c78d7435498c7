"""From camera pixel to programme pixel by one single resampling: homographies, warp fields, footprints.

Each of a picture's planes is warped by itself: half the samples of BGR, and no conversion. Matrices are 3x3 and map
camera pixel to programme pixel.
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
_BAND = 16  # nodes' rows of a table that is made for once
Resampling = Literal["linear", "lanczos"]  # Lanczos-4 is sharper, at ten times the cost


def warp_planes(planes: Planes, matrix: Homography, rect: Rect, resampling: Resampling = "linear") -> Planes:
    """A camera's picture warped by a homography, as it lies in ``rect`` of the programme; black outside the picture.

    Parameters
    ----------
    planes
        The camera's picture.
    matrix
        (3, 3), camera pixel -> programme pixel.
    rect
        The part of the programme to make.
    resampling
        "linear", or "lanczos" at ten times the cost.

    Notes
    -----
    A plane that only moves by whole samples is not resampled: it keeps every bit, and the identity returns ``planes``
    itself.
    """
    m = np.array(matrix)
    m[0] -= rect.x * m[2]
    m[1] -= rect.y * m[2]
    if abs(m[2, 2]) > 1e-12:  # else the corner lies at infinity, which resampling takes as it is
        m /= m[2, 2]
    size, half = (rect.width, rect.height), (rect.width // 2, rect.height // 2)
    shift = _whole_shift(m)
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


def _whole_shift(m: Homography) -> tuple[int, int] | None:
    """(dx, dy) of a matrix that translates by whole pixels, to a millionth, and does nothing else; else None."""
    (a, b, x), (c, d, y), (e, f, _) = m.tolist()
    if max(abs(a - 1), abs(b), abs(c), abs(d - 1), 1000 * abs(e), 1000 * abs(f)) > 1e-9:
        return None
    dx, dy = round(x), round(y)
    return (dx, dy) if max(abs(x - dx), abs(y - dy)) < 1e-6 else None


def _moved(plane: U8, dx: int, dy: int, size: tuple[int, int], black: int) -> U8:
    """``plane`` moved by whole samples on ``size`` (width, height) of ``black``; a slice where it fills all of it."""
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
    """``warped`` without Lanczos's overshoot at edges beyond limited range and beyond the source's own codes."""
    low, high, *_ = cv2.minMaxLoc(plane)
    return warped.clip(min(16, int(low)), max(_WHITE[index], int(high)), out=warped)


def footprint(size: tuple[int, int], matrix: Homography, programme: tuple[int, int]) -> U8:
    """The part of the programme over which a camera's picture extends, whatever it shows there.

    Parameters
    ----------
    size
        (width, height) of the camera.
    matrix
        (3, 3), camera pixel -> programme pixel.
    programme
        (width, height) of the programme.

    Returns
    -------
    U8
        (height / 2, width / 2) on the programme's chroma grid: 255 inside, 0 outside, values between at its edge (a
        binary mask has steps of two pixels, which show).
    """
    inside = np.full((size[1] // 2, size[0] // 2), 255, np.uint8)
    chroma = _FROM_CHROMA @ matrix @ _CHROMA
    half = (programme[0] // 2, programme[1] // 2)
    return cv2.warpPerspective(inside, chroma, half, flags=cv2.INTER_LINEAR)  # pyright: ignore[reportReturnType]


# ------------------------------------------------------------------------------------- homography with a warp field


@frozen(eq=False)
class WarpField:
    """A displacement field in the programme: what belongs at pixel p lies at p + shift(p) after the homography.

    Attributes
    ----------
    shift
        (h, w, 2), x and y in programme pixels, at the nodes of a grid; linear between nodes, constant beyond them.
    corner
        (x, y) of the first node in programme pixels.
    step
        Pixels from one node to the next.
    """

    shift: NDArray[np.float32]
    corner: tuple[float, float]
    step: float

    def at(self, x: NDArray[np.float32], y: NDArray[np.float32]) -> NDArray[np.float32]:
        """(H, W, 2): the displacement at programme pixels ``x``, ``y``, both (H, W)."""
        columns, rows = (x - self.corner[0]) / self.step, (y - self.corner[1]) / self.step
        found = cv2.remap(self.shift, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(found, np.float32)

    def source(self, matrix: Homography, x: NDArray[np.float32], y: NDArray[np.float32]) -> NDArray[np.float32]:
        """(H, W, 2): the pixels of the camera laid by ``matrix`` that belong at programme pixels ``x``, ``y``."""
        at = (np.stack([x, y], axis=-1) + self.at(x, y)).astype(np.float64)
        return cv2.perspectiveTransform(at, np.linalg.inv(matrix)).astype(np.float32)

    def tapered(self, size: tuple[int, int], matrix: Homography, width_px: float) -> WarpField:
        """The field in full outside the footprint of a camera, fading to 0 within it.

        Parameters
        ----------
        size
            (width, height) of the camera.
        matrix
            (3, 3), camera pixel -> programme pixel.
        width_px
            How far inside the footprint's edge it has faded out, programme pixels.
        """
        x, y = self.corner
        to_nodes = np.diag([1 / self.step, 1 / self.step, 1.0]) @ translation(-x, -y)
        ones = np.full((size[1], size[0]), 255, np.uint8)
        inside = cv2.warpPerspective(ones, to_nodes @ matrix, self.shift.shape[1::-1], flags=cv2.INTER_NEAREST)
        depth = cv2.distanceTransform(inside, cv2.DIST_L2, 5) * (self.step / width_px)
        left = np.clip(1 - depth, 0, 1)
        return WarpField(
            self.shift * (left * left * (3 - 2 * left))[..., None].astype(np.float32), self.corner, self.step
        )


Table = tuple[NDArray[np.float32], NDArray[np.float32]]  # x and y: apart, a picture takes 5.1 ms, interleaved 6.0


@frozen(eq=False)
class RemapTables:
    """Where in the camera's planes each sample of a rectangle of the programme lies, as `cv2.remap` takes it.

    Attributes
    ----------
    luma
        x and y, each (h, w), in luma samples.
    chroma
        x and y, each (h/2, w/2), in chroma samples.
    """

    luma: Table
    chroma: Table


def warp_field_maps(
    matrix: Homography, warp_field: WarpField, rect: Rect, offset: tuple[float, float] = (0.0, 0.0)
) -> RemapTables:
    """Remap tables of a homography with a warp field.

    Parameters
    ----------
    matrix
        (3, 3), camera pixel -> programme pixel.
    warp_field
        What is added before the inverse of ``matrix``.
    rect
        The part of the programme to make.
    offset
        (dx, dy), the centering in programme pixels.

    Notes
    -----
    Worked out at every eighth pixel and linear between: a homography of a lamp's camera deviates by 0.01 pixels there.
    """
    luma, chroma = _grids(matrix, warp_field, rect, offset)
    return RemapTables(luma.table(0, rect.height), chroma.table(0, rect.height // 2))


@frozen(eq=False)
class _Grid:
    """Where a plane's samples come from: x and y at nodes that are ``samples`` apart, one more on each side."""

    nodes: Table
    samples: int
    size: tuple[int, int]  # width and height, in samples

    def table(self, top: int, rows: int) -> Table:
        """Of ``rows`` rows from ``top`` on, a multiple of `samples`."""
        n, first = self.samples, top // self.samples
        part = slice(first, first - (-rows // n) + 2)
        # `cv2.resize` sets node k in the middle of its samples and ends with the outermost.
        wide = (n * self.nodes[0].shape[1], n * (part.stop - part.start))
        inside = np.s_[n : n + rows, n : n + self.size[0]]
        x, y = (cv2.resize(values[part], wide, interpolation=cv2.INTER_LINEAR)[inside] for values in self.nodes)
        return np.asarray(x, np.float32), np.asarray(y, np.float32)


def _grids(matrix: Homography, warp_field: WarpField, rect: Rect, offset: tuple[float, float]) -> tuple[_Grid, _Grid]:
    """Of luma and chroma."""
    left, top = rect.x - offset[0], rect.y - offset[1]
    # In chroma samples, of which (i, j) lies at luma (2 i, 2 j + 1/2): half a luma pixel left of its cell's middle.
    half = (rect.width // 2, rect.height // 2)
    return (
        _grid(matrix, warp_field, (left, top), (rect.width, rect.height), _NODE),
        _grid(matrix @ _CHROMA, warp_field, (left - 0.5, top), half, _NODE // 2),
    )


def _grid(
    matrix: Homography, warp_field: WarpField, corner: tuple[float, float], size: tuple[int, int], samples: int
) -> _Grid:
    columns, rows = (-(-n // samples) + 2 for n in size)
    node_x = (np.arange(columns, dtype=np.float32) - 0.5) * _NODE - 0.5 + corner[0]
    node_y = (np.arange(rows, dtype=np.float32) - 0.5) * _NODE - 0.5 + corner[1]
    at = warp_field.source(matrix, *(grid.astype(np.float32) for grid in np.meshgrid(node_x, node_y)))
    x, y = cv2.split(at)
    return _Grid((np.asarray(x, np.float32), np.asarray(y, np.float32)), samples, size)


def warp_planes_by_field(
    planes: Planes,
    matrix: Homography,
    warp_field: WarpField,
    rect: Rect,
    offset: tuple[float, float] = (0.0, 0.0),
    resampling: Resampling = "linear",
) -> Planes:
    """`remap_planes` through `warp_field_maps`, to do once.

    Notes
    -----
    The tables are made in bands, which stay in the processor's cache: 8 ms a picture at 1080p, 15 by whole tables.
    """
    luma, chroma = _grids(matrix, warp_field, rect, offset)
    found = []
    for index, (plane, grid) in enumerate(zip(planes, (luma, chroma, chroma), strict=True)):
        out = np.empty(grid.size[::-1], np.uint8)
        for top in range(0, grid.size[1], _BAND * grid.samples):
            part = out[top : top + _BAND * grid.samples]
            _remapped(plane, grid.table(top, len(part)), resampling, index, part)
        found.append(out if resampling == "linear" else _limited(out, plane, index))
    return Planes(*found)


def remap_planes(planes: Planes, maps: RemapTables, resampling: Resampling = "linear") -> Planes:
    """A camera's picture resampled through ``maps``, as it lies in their rectangle; black outside the picture."""
    found = []
    for index, (plane, table) in enumerate(zip(planes, (maps.luma, maps.chroma, maps.chroma), strict=True)):
        out = _remapped(plane, table, resampling, index)
        found.append(out if resampling == "linear" else _limited(out, plane, index))
    return Planes(*found)


def warp_field_footprint(
    size: tuple[int, int],
    matrix: Homography,
    warp_field: WarpField,
    programme: tuple[int, int],
    offset: tuple[float, float] = (0.0, 0.0),
) -> U8:
    """As `footprint`, of a homography with a warp field; ``matrix`` and ``offset`` as of `warp_field_maps`."""
    inside = np.full((size[1] // 2, size[0] // 2), 255, np.uint8)
    _, chroma = _grids(matrix, warp_field, Rect(0, 0, *programme), offset)
    table = chroma.table(0, chroma.size[1])
    return cv2.remap(inside, *table, cv2.INTER_LINEAR)  # pyright: ignore[reportReturnType]


def _remapped(plane: U8, table: Table, resampling: Resampling, index: int, out: U8 | None = None) -> U8:
    # Fixed-point maps, which older OpenCVs liked best, take 1.6 times as long as these.
    flags = cv2.INTER_LINEAR if resampling == "linear" else cv2.INTER_LANCZOS4
    return cv2.remap(plane, *table, flags, out, cv2.BORDER_CONSTANT, BLACK[index])  # pyright: ignore
