"""Dense matching: a grid of points all over the surgical field, found in every view by optical flow.

Distinctive points crowd where the texture is; the plane that serves the field best needs its points evenly. So views
laid over each other by their first homographies are compared at every point of a grid in many samples, and what the
flow says the same of in several samples is the patient; hands and heads never agree with themselves.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence, Set
from concurrent.futures import ThreadPoolExecutor
from itertools import combinations

import cv2
import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.imaging.geometry import Array, inverse, scaling, transform_points
from mcsl_core.imaging.masks import Mask, hue_mask

from .aligned_views import Picture
from .correspondences import Correspondences

_LEAST_POINTS = 20  # of a pair of cameras


@frozen(eq=False)
class AlignedCamera:
    """One camera's pictures in some samples, and how they are laid.

    Attributes
    ----------
    pictures : sequence of (h, w, 3) uint8 array or None
        One a sample, BGR, reduced; None where there is none.
    to_camera : (H, W, 2) float32 array
        Where every aligned pixel lies in the camera, in its full-size pixels.
    size : (int, int)
        The camera's full width and height.
    steady : sequence of (h, w) bool array, optional
        Where the pictures may be believed; everywhere without.
    """

    pictures: Sequence[Picture | None]
    to_camera: NDArray[np.float32]
    size: tuple[int, int]
    steady: Sequence[Mask] | None = None

    @classmethod
    def by_plane(
        cls,
        pictures: Sequence[Picture | None],
        to_aligned: Array,
        size: tuple[int, int],
        aligned: tuple[int, int],
        steady: Sequence[Mask] | None = None,
    ) -> AlignedCamera:
        """Laid by a homography, full-size camera pixel -> pixel of the ``aligned`` size (width, height)."""
        places = transform_points(inverse(to_aligned), pixels_of(aligned))
        return cls(pictures, places.reshape(aligned[1], aligned[0], 2).astype(np.float32), size, steady)


def pixels_of(size: tuple[int, int]) -> Array:
    """(H * W, 2): all pixels of a picture of that width and height, row by row."""
    x, y = np.meshgrid(np.arange(size[0], dtype=np.float64), np.arange(size[1], dtype=np.float64))
    return np.stack([x.ravel(), y.ravel()], axis=1)


@frozen
class DenseSettings:
    """Of dense matching; the EDL keeps all of these under their names.

    Attributes
    ----------
    grid_px : int
        Distance of the grid's points in aligned pixels.
    likeness : float
        Least correlation of a patch of 15 pixels with what the flow brings there, -1..1.
    contrast : float
        Least standard deviation of that patch, in grey levels of 255.
    reach : float
        How far the flow may lead, in diagonals (a relief, or homographies still some way off).
    loop_px : float
        Flow there and back again must meet to so many aligned pixels.
    moments : int
        In so many samples a point must be found ...
    spread_px : float
        ... within so many aligned pixels of the median, half of the time.
    other_hue : float
        Weight of a point that never shows the field's hue, 0..1.
    """

    grid_px: int = field(default=8)
    likeness: float = field(default=0.7)
    contrast: float = field(default=2.0)
    reach: float = field(default=0.02)
    loop_px: float = field(default=1.0)
    moments: int = field(default=3)
    spread_px: float = field(default=1.0)
    other_hue: float = field(default=0.3)


def match_densely(
    cameras: Mapping[str, AlignedCamera],
    area: Mask,
    settings: DenseSettings | None = None,
    wanted: Set[str] | None = None,
) -> dict[tuple[str, str], Correspondences]:
    """Matches every pair of cameras evenly over an area.

    Parameters
    ----------
    cameras : mapping of str to AlignedCamera
        Those that are tied in, each with its pictures of the same samples.
    area : (H, W) bool array
        Where to match, in aligned pixels.
    settings : DenseSettings, optional
        The defaults without.
    wanted : set of str, optional
        Only pairs with one of these cameras; all without.

    Returns
    -------
    dict of (str, str) to Correspondences
        Pair of names, in the order given -> matches in full-size pixels; without pairs of fewer than 20. Weight is 1
        where a point has the field's hue whenever it is seen, `DenseSettings.other_hue` where it never has; ``seen``
        counts samples.

    References
    ----------
    Kroeger et al., "Fast optical flow using dense inverse search", ECCV 2016.
    """
    settings = settings or DenseSettings()
    if not area.any():
        return {}
    crop = _Crop.around(area)
    grid = crop.grid(area, settings.grid_px)
    bound = settings.reach * float(np.hypot(*area.shape))
    pairs = [pair for pair in combinations(cameras, 2) if wanted is None or not wanted.isdisjoint(pair)]
    found: dict[tuple[str, str], list[tuple[Array, NDArray[np.bool_]]]] = {pair: [] for pair in pairs}
    with ThreadPoolExecutor(os.cpu_count()) as workers:
        for sample in range(max((len(camera.pictures) for camera in cameras.values()), default=0)):
            laid = {n: own for n, camera in cameras.items() if (own := crop.lay(camera, sample)) is not None}
            both = [(a, b) for a, b in pairs if a in laid and b in laid]
            displaced = workers.map(
                lambda pair, laid=laid: _displacement(laid[pair[0]], laid[pair[1]], grid, bound, settings), both
            )
            for pair, displacement in zip(both, displaced, strict=True):
                found[pair].append(displacement)
    matches = {}
    for (a, b), displacements in found.items():
        agreed = _agreed(displacements, grid, settings)
        if agreed is not None:
            points_a, points_b = crop.to_camera(agreed.a, cameras[a]), crop.to_camera(agreed.b, cameras[b])
            matches[a, b] = Correspondences(points_a, points_b, agreed.weight, agreed.seen)
    return matches


@frozen(eq=False)
class _Laid:
    """A picture laid in the crop: its grey, where it is near the field's hue, where it may be believed."""

    grey: NDArray[np.uint8]
    hue: NDArray[np.uint8]
    steady: NDArray[np.uint8] | None


@frozen(eq=False)
class _Crop:
    """The part of the aligned picture about an area: its first column and row, its width and height."""

    corner: tuple[int, int]
    size: tuple[int, int]

    @classmethod
    def around(cls, area: Mask) -> _Crop:
        """The bounding box with a margin of 4 % of the width, so that the flow sees what comes in."""
        rows, columns = np.nonzero(area)
        margin = round(0.04 * area.shape[1])
        x, y = max(int(columns.min()) - margin, 0), max(int(rows.min()) - margin, 0)
        stop_x = min(int(columns.max()) + margin + 1, area.shape[1])
        stop_y = min(int(rows.max()) + margin + 1, area.shape[0])
        return cls((x, y), (stop_x - x, stop_y - y))

    def grid(self, area: Mask, grid_px: int) -> NDArray[np.int64]:
        """(N, 2) pixels of the crop on a grid inside ``area``."""
        width, height = self.size
        x, y = np.meshgrid(np.arange(grid_px // 2, width, grid_px), np.arange(grid_px // 2, height, grid_px))
        points = np.stack([x.ravel(), y.ravel()], axis=1)
        return points[area[points[:, 1] + self.corner[1], points[:, 0] + self.corner[0]]]

    def lay(self, camera: AlignedCamera, sample: int) -> _Laid | None:
        """The camera's picture of a sample in the crop, None where there is none."""
        picture = camera.pictures[sample] if sample < len(camera.pictures) else None
        if picture is None:
            return None
        (x, y), (width, height) = self.corner, self.size
        reduced = scaling(camera.size, (picture.shape[1], picture.shape[0]))
        places = camera.to_camera[y : y + height, x : x + width]
        at = (places @ reduced[:2, :2].T + reduced[:2, 2]).astype(np.float32)
        laid = cv2.remap(picture, at[..., 0], at[..., 1], cv2.INTER_LINEAR)
        near = cv2.dilate(hue_mask(laid), np.ones((5, 5), np.uint8))  # pyright: ignore[reportArgumentType]
        steady = None
        if camera.steady is not None:
            steady = cv2.remap(camera.steady[sample].view(np.uint8), at[..., 0], at[..., 1], cv2.INTER_NEAREST)
        return _Laid(cv2.cvtColor(laid, cv2.COLOR_BGR2GRAY), near, steady)  # pyright: ignore[reportArgumentType]

    def to_camera(self, points: Array, camera: AlignedCamera) -> Array:
        """(N, 2) pixels of the crop -> full-size pixels of the camera."""
        x, y = (points + self.corner).astype(np.float32).T
        at = cv2.remap(camera.to_camera, x[None], y[None], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return at[0].astype(np.float64)


def _displacement(
    a: _Laid, b: _Laid, grid: NDArray[np.int64], bound: float, settings: DenseSettings
) -> tuple[Array, NDArray[np.bool_]]:
    """((N, 2) displacement of the grid's points from a to b, NaN where not believed; (N,) field's hue in both)."""
    flow = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)  # one object is not for many threads
    there = flow.calc(a.grey, b.grey, None)  # pyright: ignore[reportCallIssue, reportArgumentType]
    back = flow.calc(b.grey, a.grey, None)  # pyright: ignore[reportCallIssue, reportArgumentType]
    height, width = a.grey.shape
    x, y = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
    to_x, to_y = x + there[..., 0], y + there[..., 1]
    moved = cv2.remap(b.grey, to_x, to_y, cv2.INTER_LINEAR)
    loop = there + cv2.remap(back, to_x, to_y, cv2.INTER_LINEAR)
    like, contrast = _likeness(a.grey.astype(np.float32), moved.astype(np.float32))
    believed = (
        (like > settings.likeness)
        & (contrast > settings.contrast)
        & (np.hypot(loop[..., 0], loop[..., 1]) < settings.loop_px)
        & (np.hypot(there[..., 0], there[..., 1]) < bound)
    )
    if a.steady is not None and b.steady is not None:
        believed &= (a.steady > 0) & (cv2.remap(b.steady, to_x, to_y, cv2.INTER_NEAREST) > 0)
    hue = (a.hue > 0) & (cv2.remap(b.hue, to_x, to_y, cv2.INTER_NEAREST) > 0)
    at = (grid[:, 1], grid[:, 0])
    displacement = there[at].astype(np.float64)
    displacement[~believed[at]] = np.nan
    return displacement, hue[at]


def _likeness(a: NDArray[np.float32], b: NDArray[np.float32], box: int = 15) -> tuple[NDArray, NDArray]:
    """(normalised correlation of the patch around every pixel, standard deviation of ``a`` in it)."""
    mean_a, mean_b = cv2.blur(a, (box, box)), cv2.blur(b, (box, box))
    var_a = np.maximum(cv2.blur(a * a, (box, box)) - mean_a * mean_a, 0)
    var_b = np.maximum(cv2.blur(b * b, (box, box)) - mean_b * mean_b, 0)
    together = cv2.blur(a * b, (box, box)) - mean_a * mean_b
    return together / np.sqrt(np.maximum(var_a * var_b, 1e-3)), np.sqrt(var_a)


def _agreed(
    displacements: Sequence[tuple[Array, NDArray[np.bool_]]], grid: NDArray[np.int64], settings: DenseSettings
) -> Correspondences | None:
    """The grid's points, in pixels of the crop, that several samples agree of; None if fewer than 20."""
    if not displacements:
        return None
    moved = np.stack([displacement for displacement, _ in displacements])  # (samples, N, 2)
    hue = np.stack([hue for _, hue in displacements])
    known = ~np.isnan(moved[..., 0])
    seen = known.sum(axis=0)
    some = seen >= min(settings.moments, len(displacements))
    if some.sum() < _LEAST_POINTS:
        return None
    moved, known, hue = moved[:, some], known[:, some], hue[:, some]
    median = np.nanmedian(moved, axis=0)
    off = moved - median
    spread = np.nanmedian(np.hypot(off[..., 0], off[..., 1]), axis=0)
    keep = spread < settings.spread_px
    if keep.sum() < _LEAST_POINTS:
        return None
    share = (hue & known).sum(axis=0) / known.sum(axis=0)
    weight = settings.other_hue + (1 - settings.other_hue) * share
    points = grid[some][keep].astype(np.float64)
    return Correspondences(points, points + median[keep], weight[keep], seen[some][keep].astype(np.int64))
