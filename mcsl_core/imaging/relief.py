"""Places by the relief: where each camera sees what the programme shows at a pixel, and the way back.

A pose's relief (`edl.relief`) says how high the scene stands over the plane at a programme pixel before centering, and
every camera's projection what that does to its picture. As for what fills, the camera's picture is laid by its
homography with a `WarpField` added; so a pixel is resampled once, and without a relief nothing changes.

Where the relief is less than half confident the field goes over softly to 0, which is the plane; so it does beyond the
programme's picture, over a quarter of its width. It never changes by more than `STEEPEST` pixels a pixel, so that there
is no tear, no fold, and a way back from every pixel: nothing is stretched more than (1 + STEEPEST) / (1 - STEEPEST) = 3
times as much in one direction as in another, and what crosses a place straight, an instrument above it, is bent by no
more than 27 degrees. Only the walls of a wound are steeper, seen from the side (a hundredth of a simulated picture);
there it is smoothed little by little until it fits.
"""

from __future__ import annotations

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.edl import Relief

from .geometry import Array, Homography, depths, inverse, project, transform_points
from .warp import WarpField

# With the true relief of a simulated wound its points are off by 0.9 pixels rms of 960 without a bound, where a needle
# holder above its wall is bent like a hook; by 1.5 at 0.8, 2.4 at 0.5 and 3.4 at 1/3; by 6.2 by the plane.
STEEPEST = 0.5
_STEP = 1 / 192  # of the programme's width: between nodes
_BEYOND = 1 / 4  # of the width: so far the field reaches outside the programme's picture, fading
# Confidence from which the relief holds: by its own value, points of a photographed limb were off by 2.2 px of 960 in
# the median, by twice that 1.9; of a simulated wound by 1.7 and 0.95. From 0.3 the rms grew.
_CONFIDENT = 0.5
_SOFT = 1 / 96  # sigma of the confidence, of the width
_ROUNDS = 200  # of smoothing; 93 were needed by a photographed limb from the side
_STEPS = 60  # back to the programme
_EXACT = 1e-10  # pixels
_LEAST = 0.01  # pixels: less moves nothing
_LEAST_DEPTH = 1e-6  # of that of the picture's corner
_FAR = 1 / 4  # of the width: what a projection moves farther than that is no place


@frozen(eq=False)
class ReliefMap:
    """A relief as arrays.

    Attributes
    ----------
    gamma : (rows, columns) float32
        Height over the plane at the nodes.
    confidence : (rows, columns) float32
        0..1.
    size : (int, int)
        Width and height of the programme.
    """

    gamma: NDArray[np.float32]
    confidence: NDArray[np.float32]
    size: tuple[int, int]

    @classmethod
    def of(cls, relief: Relief, size: tuple[int, int]) -> ReliefMap:
        """The EDL's relief in a programme of ``size``."""
        confidence = np.array(relief.confidence, np.float32) / np.float32(100)
        return cls(np.array(relief.gamma, np.float32), np.asarray(confidence, np.float32), size)

    def at(self, points: Array) -> tuple[Array, Array]:
        """Gamma and confidence at (N, 2) programme pixels, linear between nodes; outside as at the picture's edge."""
        gamma, confidence = between_nodes(np.stack([self.gamma, self.confidence], axis=-1), self.size, points).T
        return gamma, confidence


def node_pixels(shape: tuple[int, ...], size: tuple[int, int]) -> Array:
    """(rows * columns, 2): the pixels at which (rows, columns) nodes lie, row by row, as `between_nodes` has them."""
    x, y = np.meshgrid(np.linspace(0, size[0] - 1, shape[1]), np.linspace(0, size[1] - 1, shape[0]))
    return np.stack([x.ravel(), y.ravel()], axis=1)


def between_nodes(values: NDArray, size: tuple[int, int], points: Array) -> Array:
    """Values at nodes, between them: linear, constant beyond.

    Parameters
    ----------
    values
        (rows, columns, C); the nodes reach from the first to the last pixel centre.
    size
        Width and height of the picture that they lie over.
    points
        (N, 2) of its pixels.

    Returns
    -------
    Array
        (N, C).
    """
    rows, columns, _ = values.shape
    return _sampled(values, points * np.array([columns - 1, rows - 1]) / np.maximum(np.array(size) - 1, 1))


def surface_field(
    relief: ReliefMap,
    projection: Array,
    matrix: Homography,
    correction: Homography | None = None,
    *,
    coarser: float = 1.0,
) -> WarpField | None:
    """What the relief adds to a camera's plane.

    Parameters
    ----------
    relief
        Of the pose.
    projection
        (3, 4), the camera's.
    matrix
        (3, 3), camera pixel -> programme pixel before centering, by the plane and ``correction``.
    correction
        (3, 3), programme pixel -> programme pixel, by hand, which moves the surface as it does the plane.
    coarser
        Times the distance between nodes, for a field that serves a single frame: twice costs a quarter.

    Returns
    -------
    WarpField or None
        What belongs at pixel p lies at p + shift(p) after ``matrix``; None where that is p, to a hundredth pixel.
    """
    width, height = relief.size
    step, margin = coarser * _STEP * width, _BEYOND * width
    columns, rows = (int(np.ceil((n + 2 * margin) / step)) + 1 for n in (width, height))
    x, y = np.meshgrid(np.arange(columns) * step - margin, np.arange(rows) * step - margin)
    nodes = np.asarray(np.stack([x, y], axis=-1).reshape(-1, 2), np.float64)
    correct = np.eye(3) if correction is None else correction
    before = transform_points(inverse(correct), nodes)
    gamma, confidence = relief.at(before)
    scene = np.column_stack([before, gamma])
    scene[depths(projection, scene) < _LEAST_DEPTH] = np.nan
    there = transform_points(matrix, project(projection, scene))
    known = np.isfinite(there).all(axis=1) & (np.linalg.norm(there - nodes, axis=1) < _FAR * width)
    outside = np.maximum(np.maximum(-before, before - (np.array(relief.size) - 1)), 0)
    inside = np.clip(1 - np.hypot(*outside.T) / (0.9 * margin), 0, 1)
    sure = np.minimum(1, confidence / _CONFIDENT)
    weight = (sure * known * inside * inside * (3 - 2 * inside)).reshape(rows, columns).astype(np.float32)
    weight = cv2.GaussianBlur(weight, (0, 0), _SOFT / _STEP / coarser, borderType=cv2.BORDER_REPLICATE)
    shift = np.where(known[:, None], there - nodes, 0).reshape(rows, columns, 2) * weight[..., None]
    shift = _bounded(shift.astype(np.float32), step)
    return WarpField(shift, (-margin, -margin), step) if np.abs(shift).max() > _LEAST else None


def _bounded(shift: NDArray[np.float32], step: float) -> NDArray[np.float32]:
    """``shift`` changing by no more than `STEEPEST`: smoothed little by little about where it does, nowhere else."""
    for n in range(_ROUNDS):
        steep = _steepness(shift, step)
        if steep.max() <= STEEPEST:
            return shift
        over = np.pad(np.clip(3 * (steep / (0.97 * STEEPEST) - 1), 0, 1), 1)
        place = cv2.dilate(over, np.ones((2, 2), np.uint8), anchor=(1, 1))[1:, 1:]  # the corners of its cells
        # Narrower, or slower to widen, it goes round in circles where much is steep, and all is weakened in the end.
        part = np.minimum(2 * cv2.GaussianBlur(place, (0, 0), 2.0), 1)[..., None]
        smooth = cv2.GaussianBlur(shift, (0, 0), 1 + n / 20, borderType=cv2.BORDER_REPLICATE)
        shift = np.asarray(shift + part * (smooth - shift), np.float32)
    return shift * np.float32(min(1.0, STEEPEST / float(_steepness(shift, step).max())))


def _steepness(shift: NDArray[np.float32], step: float) -> NDArray[np.float32]:
    """(rows - 1, columns - 1): within each cell, no less than the norm of the shift's derivative."""
    right = np.linalg.norm(np.diff(shift, axis=1), axis=2) / step
    down = np.linalg.norm(np.diff(shift, axis=0), axis=2) / step
    return np.hypot(np.maximum(right[:-1], right[1:]), np.maximum(down[:, :-1], down[:, 1:])).astype(np.float32)


# ------------------------------------------------------------------------------------------------------------ points


@frozen(eq=False)
class Placement:
    """Where a camera's picture lies in the programme, point by point.

    Attributes
    ----------
    matrix : (3, 3) float64
        Camera pixel -> programme pixel before centering.
    field : WarpField, optional
        What the relief adds.
    offset : (float, float)
        The centering's, in programme pixels.
    """

    matrix: Homography
    field: WarpField | None = None
    offset: tuple[float, float] = (0.0, 0.0)

    def to_camera(self, points: Array) -> Array:
        """(N, 2) camera pixels that the programme shows at (N, 2) pixels."""
        points = points - np.array(self.offset)
        return transform_points(inverse(self.matrix), points + self._shift_at(points))

    def to_programme(self, points: Array) -> Array:
        """(N, 2) programme pixels at which (N, 2) camera pixels are shown: the inverse of `to_camera`."""
        laid = found = transform_points(self.matrix, points)
        for _ in range(_STEPS if self.field is not None else 0):  # each is nearer by STEEPEST at least
            before, found = found, laid - self._shift_at(found)
            if not (np.abs(found - before) > _EXACT).any():
                break
        return found + np.array(self.offset)

    def _shift_at(self, points: Array) -> Array:
        if self.field is None:
            return np.zeros_like(points)
        return _sampled(self.field.shift, (points - np.array(self.field.corner)) / self.field.step)


def _sampled(values: NDArray, at: Array) -> Array:
    """(N, C) of (rows, columns, C) values at (N, 2) places in nodes, linear between them, constant beyond.

    Exactly: `cv2.remap` knows places to a 32nd of a node, which is a tenth of a pixel where the relief is steep.
    """
    rows, columns, _ = values.shape
    at = np.clip(np.nan_to_num(at), 0, [columns - 1, rows - 1])
    first = np.minimum(at.astype(int), [max(columns - 2, 0), max(rows - 2, 0)])
    (x, y), (u, v) = first.T, (at - first).T[..., None]
    x1, y1 = np.minimum(x + 1, columns - 1), np.minimum(y + 1, rows - 1)
    top = (1 - u) * values[y, x] + u * values[y, x1]
    return (1 - v) * top + v * ((1 - u) * values[y1, x] + u * values[y1, x1])
