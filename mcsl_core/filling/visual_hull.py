"""Where a camera's rays lead in the other cameras' pictures, from the relief up to hand height.

Heights are parallax: how far the camera moved most by it sees a point so high beside the relief below it, as a share of
the picture's width. Half a metre of the field wide, a metre below cameras 45 cm apart, 15 cm make a sixth of the width,
and heads, 30 to 45 cm up, 0.4 to 0.7. (Self-calibration would tell centimetres, but with five nearly coplanar cameras
it found focal lengths from a tenth to nine tenths of the true ones.)
"""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.imaging.geometry import Array
from mcsl_core.imaging.relief import ReliefMap

COLUMNS = 160  # cells of a row, of the programme's picture and of every camera's: 4 pixels of 640
HANDS = 0.16  # height up to which hands and instruments work
_BELOW = -0.02  # a relief that is not known well may be too high
_STEP = 2.5  # cells from one height to the next, for the camera moved most
_AGREED = 0.2  # of the cameras' leaning towards each other, by sum over the sum of sizes, from which it tells upward
_NEAR = 2.0  # cells: so far from a cell that shows one of the programme's, one shows it too

Cells = NDArray[np.float32]  # (rows, columns), or with 3 channels
Index = NDArray[np.intp]  # of cells, row by row; one past the last where there is none


def grid_size(size: tuple[int, int]) -> tuple[int, int]:
    """(columns, rows) of the cells of a picture of ``size`` (width, height)."""
    return COLUMNS, max(1, round(COLUMNS * size[1] / size[0]))


def taken(values: Cells, at: Index, outside: float = 0.0) -> Cells:
    """``values`` of a grid's cells ``at`` an index, ``outside`` where that has none."""
    flat = values.reshape(-1, *values.shape[2:])
    return np.concatenate([flat, np.full((1, *flat.shape[1:]), outside, flat.dtype)])[at]


@frozen(eq=False)
class Rays:
    """Of one camera.

    Attributes
    ----------
    own : (rows, columns) intp
        By cell of the programme before centering: the cell of the camera's own picture that shows the relief there.
    programme : (rows, columns) intp
        The other way round.
    along : mapping of str to (heights, rows, columns) intp
        By other camera and cell of the programme: its cell that shows the point so high on this camera's ray.
    """

    own: Index
    programme: Index
    along: Mapping[str, Index]


def rays_of(
    camera: str, projections: Mapping[str, Array], sizes: Mapping[str, tuple[int, int]], relief: ReliefMap
) -> Rays | None:
    """The rays of ``camera``.

    Parameters
    ----------
    camera
        One that the relief has a projection of.
    projections
        (3, 4), of every camera that it has.
    sizes
        (width, height) of every camera's picture.
    relief
        Of the pose.

    Returns
    -------
    Rays or None
        None where nothing tells which way is up.
    """
    columns, rows = grid_size(relief.size)
    x, y = np.meshgrid((np.arange(columns) + 0.5) / columns, (np.arange(rows) + 0.5) / rows)
    places = np.stack([x, y], axis=-1).reshape(-1, 2) * np.array(relief.size) - 0.5
    gamma, _ = relief.at(places)
    scene = np.column_stack([places, np.ones(len(places)), gamma])
    usual = float(np.median(gamma))
    upward = _upward(projections, usual)
    others = {name: p for name, p in projections.items() if name != camera}
    if not upward or not others:
        return None
    towards = _centre(projections[camera], usual) * upward
    middle = np.array([*(np.array(relief.size) - 1) / 2, 1.0, usual])
    by = _rises(middle, towards, others, sizes)
    if by is None:
        return None
    own = _cells(projections[camera], scene, sizes[camera])
    along = {name: np.stack([_cells(p, scene + s * towards, sizes[name]) for s in by]) for name, p in others.items()}
    return Rays(
        own.reshape(rows, columns),
        _back(own, grid_size(sizes[camera])),
        {name: cells.reshape(len(by), rows, columns) for name, cells in along.items()},
    )


def _centre(projection: Array, gamma: float) -> Array:
    """(4,): the camera's centre, scaled so that from a relief of height ``gamma`` towards it gamma rises by 1."""
    centre = np.array([(-1) ** k * np.linalg.det(np.delete(projection, k, axis=1)) for k in range(4)])
    rise = centre[3] - gamma * centre[2]
    return centre / rise if abs(rise) > 1e-9 * np.abs(centre).max() else centre


def _upward(projections: Mapping[str, Array], gamma: float) -> int:
    """1 where gamma rises towards the cameras, -1 where it falls, 0 where they do not say.

    A lamp's cameras lean towards each other: each has the others in front of it.
    """
    ahead = []
    for name, projection in projections.items():
        centre = _centre(projection, gamma)
        ahead += [float((p @ centre)[2]) for other, p in projections.items() if other != name]
    total, sizes = sum(ahead), sum(abs(a) for a in ahead)
    return 0 if abs(total) <= _AGREED * sizes else int(np.sign(total))


def _rises(
    middle: Array, towards: Array, others: Mapping[str, Array], sizes: Mapping[str, tuple[int, int]]
) -> Array | None:
    """How much of ``towards`` leads from ``middle`` to each height, from the lowest on; None where none leads there."""

    def height(by: Array) -> Array:
        points = middle + by[:, None] * towards
        far = []
        for name, p in others.items():
            at, start = points @ p.T, p @ middle
            ahead = at[:, 2] > 1e-6
            apart = at[:, :2] / np.where(ahead, at[:, 2], 1.0)[:, None] - start[:2] / start[2]
            far.append(np.where(ahead, np.hypot(*apart.T) / sizes[name][0], np.inf))
        return np.maximum.accumulate(np.max(far, axis=0))

    by = np.concatenate([[0.0], np.geomspace(1e-3, 1e6, 600)])
    up, down = height(by), height(-by)
    if not (up > HANDS).any() or not (down > -_BELOW).any():
        return None
    heights = np.arange(_BELOW, HANDS + 1e-9, _STEP / COLUMNS)
    top, bottom = (slice(int(np.argmax(way > most)) + 1) for way, most in ((up, HANDS), (down, -_BELOW)))
    above, below = np.interp(heights, up[top], by[top]), np.interp(-heights, down[bottom], by[bottom])
    return np.where(heights >= 0, above, -below)


def _cells(projection: Array, scene: Array, size: tuple[int, int]) -> Index:
    """(N,) cells of a picture of ``size`` that show scene points (N, 4)."""
    columns, rows = grid_size(size)
    at = scene @ projection.T
    ahead = at[:, 2] > 1e-6
    x, y = ((at[:, :2] / np.where(ahead, at[:, 2], 1.0)[:, None] + 0.5) / np.array(size)).T
    inside = ahead & (x >= 0) & (x < 1) & (y >= 0) & (y < 1)
    row, column = (np.where(inside, share, 0) * n for share, n in ((y, rows), (x, columns)))
    return np.where(inside, row.astype(np.intp) * columns + column.astype(np.intp), columns * rows)


def _back(own: Index, size: tuple[int, int]) -> Index:
    """(rows, columns): by cell of a camera's picture of ``size`` (columns, rows), the programme's that shows it."""
    columns, rows = size
    found = np.full(rows * columns + 1, len(own), np.intp)
    found[own] = np.arange(len(own))
    found[-1] = len(own)
    empty = (found[:-1] == len(own)).reshape(rows, columns).astype(np.uint8)
    if empty.all():
        return found[:-1].reshape(rows, columns)
    away, label = cv2.distanceTransformWithLabels(empty, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL)
    of_label = np.zeros(int(label.max()) + 1, np.intp)
    of_label[label[empty == 0]] = found[:-1].reshape(rows, columns)[empty == 0]
    return np.where(np.asarray(away) <= _NEAR, of_label[label], len(own))
