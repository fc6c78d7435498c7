"""How unlike the cameras are at every pixel and for every gamma that is tried: a plane sweep about a base surface."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.imaging.geometry import scaling

from .corroboration import weights_of
from .protocol import ReliefCamera

Field = NDArray[np.float32]
"""(H, W), a number a working pixel."""

# One of each two opposite neighbours of a 7x7 window: the other says the same, shifted.
_CENSUS = tuple((dy, dx) for dy in range(4) for dx in range(-3, 4) if (dy, dx) > (0, 0))
_RADIUS = 3
_BOX = 5
_LEAST_PAIRS = 0.2
_FINEST = 1.4  # a picture's columns for one of the working picture's: what lies between two pixels would only be noise
RANDOM = 0.5
"""The cost of pictures that have nothing to do with each other; 0 is perfect."""


@frozen(eq=False)
class SweptCamera:
    """A camera as the sweep reads it.

    Attributes
    ----------
    pictures : (V, h, w) uint8 array
        Grey.
    weights : (V, h, w) uint8 array
        How much each counts; see `weights_of`.
    projection : (3, 4) array
        (x, y, 1, gamma), x and y in working pixels -> pixel of the pictures, homogeneous.
    plane : (3, 4) array
        The same by its plane.
    """

    pictures: NDArray[np.uint8]
    weights: NDArray[np.uint8]
    projection: NDArray[np.floating]
    plane: NDArray[np.floating]

    @classmethod
    def of(cls, camera: ReliefCamera) -> SweptCamera:
        """A camera whose working pixels are the perspective's."""
        greys = np.stack([cv2.cvtColor(view.picture, cv2.COLOR_BGR2GRAY) for view in camera.views]).astype(np.uint8)
        to_picture = scaling(camera.size, (greys.shape[2], greys.shape[1]))
        plane = np.column_stack([camera.plane, np.zeros(3)])
        return cls(greys, weights_of(camera.views), to_picture @ camera.projection, to_picture @ plane)

    def reduced(self, perspective: tuple[int, int], size: tuple[int, int]) -> SweptCamera:
        """For working pixels of the ``size`` (width, height) that the perspective is reduced to."""
        before = (self.pictures.shape[2], self.pictures.shape[1])
        small = max(1.0, before[0] / (_FINEST * size[0]))
        after = (round(before[0] / small), round(before[1] / small))
        to_picture, from_working = scaling(before, after), np.eye(4)
        from_working[:3, :3] = scaling(size, perspective)
        return SweptCamera(
            _resized(self.pictures, after, cv2.INTER_AREA),
            _resized(self.weights, after, cv2.INTER_NEAREST),
            *((to_picture @ matrix @ from_working).astype(np.float32) for matrix in (self.projection, self.plane)),
        )

    def laid(self, gamma: Field, matrix: NDArray[np.floating]) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        """(V, H, W) pictures and weights, laid over the working picture by a surface and one of the two matrices."""
        x, y = np.arange(gamma.shape[1], dtype=np.float32), np.arange(gamma.shape[0], dtype=np.float32)[:, None]
        column, row, depth = (m[0] * x + (m[1] * y + m[2]) + m[3] * gamma for m in matrix)
        depth = np.maximum(depth, 1e-3)
        at, part = cv2.convertMaps(column / depth, row / depth, cv2.CV_16SC2)
        edge = cv2.BORDER_REPLICATE
        pictures = [cv2.remap(p, at, part, cv2.INTER_LINEAR, borderMode=edge) for p in self.pictures]
        nearest = cv2.INTER_NEAREST
        weights = [cv2.remap(w, at, None, nearest) for w in self.weights]  # pyright: ignore[reportCallIssue,reportArgumentType]
        return np.stack(pictures), np.stack(weights)  # pyright: ignore[reportReturnType]


@frozen(eq=False)
class Volume:
    """Costs by level and working pixel.

    Attributes
    ----------
    cost : (levels, H, W) float32 array
        Share of comparisons in which two cameras differ; `RANDOM` where there is nothing to compare.
    pairs : (levels, H, W) float32 array
        The weight of the pairs of pictures that were compared.
    """

    cost: NDArray[np.float32]
    pairs: NDArray[np.float32]


def swept(cameras: Sequence[SweptCamera], base: Field, levels: NDArray[np.float64]) -> Volume:
    """Compares all cameras with each other, at every level above a base surface.

    Parameters
    ----------
    cameras : sequence of SweptCamera
        For these working pixels.
    base : (H, W) float32 array
        Gamma of every working pixel.
    levels : (N,) array
        What is added to it, in turn.

    Returns
    -------
    Volume

    Notes
    -----
    By the census transform (Zabih & Woodfill 1994) in 7x7 windows on the base surface, so that a slope is as good as a
    level place. All pairs of pictures vote alike but those of one camera, which agree on every level: of n pictures
    that k find a neighbour brighter, k (n - k) pairs differ. What one shows otherwise is outvoted.
    """
    cost = np.full((len(levels), *base.shape), RANDOM, np.float32)
    pairs = np.zeros_like(cost)
    inner = (slice(_RADIUS, -_RADIUS),) * 2
    for n, level in enumerate(levels):
        surface = base + np.float32(level)
        differing, possible = _disagreement([camera.laid(surface, camera.projection) for camera in cameras])
        whole, of = cv2.blur(differing, (_BOX, _BOX)), cv2.blur(possible, (_BOX, _BOX))
        share = whole / np.maximum(of * len(_CENSUS), 1e-6)
        cost[n][inner] = np.where(of > _LEAST_PAIRS, share, RANDOM)
        pairs[n][inner] = of
    return Volume(cost, pairs)


def _disagreement(laid: Sequence[tuple[NDArray[np.uint8], NDArray[np.uint8]]]) -> tuple[Field, Field]:
    """(H - 6, W - 6): weight of the pairs that differ, over all comparisons, and of all pairs, in each of them."""
    r = _RADIUS
    height, width = laid[0][0].shape[1:]
    known = [np.ascontiguousarray(weights[:, r:-r, r:-r]) for _, weights in laid]
    own = [weights.sum(axis=0, dtype=np.uint16) for weights in known]
    total = np.sum(own, axis=0, dtype=np.uint16)
    differing = np.zeros(total.shape, np.float32)
    for dy, dx in _CENSUS:
        there = slice(r + dy, height - r + dy), slice(r + dx, width - r + dx)
        all_up, same_camera = np.zeros_like(total), np.zeros_like(total)
        for (pictures, _), weights, all_own in zip(laid, known, own, strict=True):
            brighter = pictures[:, *there] > pictures[:, r:-r, r:-r]
            up = (brighter.view(np.uint8) * weights).sum(axis=0, dtype=np.uint16)
            all_up += up
            same_camera += up * (all_own - up)
        differing += all_up * (total - all_up) - same_camera
    squares = np.sum([weights.astype(np.float32) ** 2 for weights in own], axis=0)
    return differing, (total.astype(np.float32) ** 2 - squares) / 2


def _resized(stack: NDArray[np.uint8], size: tuple[int, int], how: int) -> NDArray[np.uint8]:
    if stack.shape[:0:-1] == size:
        return stack
    return np.stack([cv2.resize(one, size, interpolation=how) for one in stack])  # pyright: ignore[reportReturnType]
