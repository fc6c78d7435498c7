"""Where every spot of the surgical field lies in every view: optical flow between views that already lie close.

Distinctive points crowd where the texture is; the plane that serves the field best needs its spots evenly. So views
laid over each other by their first homographies are compared spot by spot at many moments, and what the flow says the
same of at several moments is the patient; hands and heads never agree with themselves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import cv2
import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.imaging.geometry import scaling, transform_points
from mcsl_core.imaging.masks import Mask, hue_mask

from .aligned_views import Picture
from .correspondences import Correspondences

Array = NDArray[np.float64]


@frozen(eq=False)
class PlacedCamera:
    """One camera's pictures over the moments, and where they lie.

    pictures: reduced BGR, None where there is none. to_scene: 3x3, full-size camera pixel -> scene pixel.
    size: full (width, height).
    """

    pictures: Sequence[Picture | None]
    to_scene: Array
    size: tuple[int, int]


@frozen
class DenseSettings:
    """grid_px: distance of the spots in scene pixels. likeness: correlation of a 15-pixel patch after the flow.

    reach: how far the flow may lead, in diagonals (a relief, or homographies still some way off). loop_px: there and
    back again must meet. moments: so many must agree, within ``spread_px`` of their median. other_hue: weight of a spot
    that never shows the field's hue.
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
    views: Mapping[str, PlacedCamera], place: Mask, settings: DenseSettings | None = None
) -> dict[tuple[str, str], Correspondences]:
    """Correspondences of every pair of ``views`` (sorted names), in full-size pixels, evenly over ``place``.

    place: (H, W) bool in scene pixels. Pairs with fewer than 20 spots are left out. Weight 1 where the spot has the
    field's hue whenever it is seen; seen: moments that agree.
    """
    settings = settings or DenseSettings()
    if not place.any():
        return {}
    crop = _Crop.around(place)
    spots = crop.spots(place, settings.grid_px)
    flows = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    bound = settings.reach * float(np.hypot(*place.shape))
    pairs = list(combinations(sorted(views), 2))
    found: dict[tuple[str, str], list[tuple[Array, NDArray[np.bool_]]]] = {pair: [] for pair in pairs}
    for moment in range(max((len(v.pictures) for v in views.values()), default=0)):
        laid = {name: crop.lay(view, moment) for name, view in views.items()}
        for a, b in pairs:
            first, second = laid[a], laid[b]
            if first is not None and second is not None:
                found[a, b].append(_compare(first, second, spots, flows, bound, settings))
    made = {}
    for (a, b), moments in found.items():
        matches = _agreed(moments, spots, settings)
        if matches is not None:
            here, there, weight, seen = matches
            made[a, b] = Correspondences(crop.to_camera(here, views[a]), crop.to_camera(there, views[b]), weight, seen)
    return made


@frozen(eq=False)
class _Laid:
    """A view in the crop: grey, and where it has the field's hue (with two pixels around)."""

    grey: NDArray[np.uint8]
    hue: NDArray[np.uint8]


@frozen(eq=False)
class _Crop:
    """The part of the scene about the field. shift: 3x3, scene pixel -> its own. size: (width, height)."""

    shift: Array
    size: tuple[int, int]

    @classmethod
    def around(cls, place: Mask) -> _Crop:
        """The bounding box with a margin of 4 % of the width, so that the flow sees what comes in."""
        rows, columns = np.nonzero(place)
        margin = round(0.04 * place.shape[1])
        x, y = max(int(columns.min()) - margin, 0), max(int(rows.min()) - margin, 0)
        stop_x = min(int(columns.max()) + margin + 1, place.shape[1])
        stop_y = min(int(rows.max()) + margin + 1, place.shape[0])
        return cls(np.array([[1.0, 0, -x], [0, 1, -y], [0, 0, 1]]), (stop_x - x, stop_y - y))

    def spots(self, place: Mask, grid_px: int) -> NDArray[np.int64]:
        """(N, 2) pixels of the crop on a grid inside ``place``."""
        x, y = np.meshgrid(*(np.arange(grid_px // 2, length, grid_px) for length in self.size))
        at = np.stack([x.ravel(), y.ravel()], axis=1)
        corner = -self.shift[:2, 2].astype(int)
        return at[place[at[:, 1] + corner[1], at[:, 0] + corner[0]]]

    def lay(self, view: PlacedCamera, moment: int) -> _Laid | None:
        picture = view.pictures[moment] if moment < len(view.pictures) else None
        if picture is None:
            return None
        warp = self.shift @ view.to_scene @ scaling((picture.shape[1], picture.shape[0]), view.size)
        laid = cv2.warpPerspective(picture, warp, self.size, flags=cv2.INTER_LINEAR)
        near = cv2.dilate(hue_mask(laid), np.ones((5, 5), np.uint8))  # pyright: ignore[reportArgumentType]
        return _Laid(cv2.cvtColor(laid, cv2.COLOR_BGR2GRAY), near)  # pyright: ignore[reportArgumentType]

    def to_camera(self, points: Array, view: PlacedCamera) -> Array:
        back: Array = np.asarray(np.linalg.inv(self.shift @ view.to_scene), np.float64)
        return transform_points(back, points)


def _compare(
    a: _Laid, b: _Laid, spots: NDArray[np.int64], flows: cv2.DISOpticalFlow, bound: float, settings: DenseSettings
) -> tuple[Array, NDArray[np.bool_]]:
    """((N, 2) displacement of every spot from a to b, NaN where it is not to be believed; (N,) field's hue in both)."""
    there = flows.calc(a.grey, b.grey, None)  # pyright: ignore[reportCallIssue, reportArgumentType]
    back = flows.calc(b.grey, a.grey, None)  # pyright: ignore[reportCallIssue, reportArgumentType]
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
    hue = (a.hue > 0) & (cv2.remap(b.hue, to_x, to_y, cv2.INTER_NEAREST) > 0)
    at = (spots[:, 1], spots[:, 0])
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
    moments: Sequence[tuple[Array, NDArray[np.bool_]]], spots: NDArray[np.int64], settings: DenseSettings
) -> tuple[Array, Array, Array, NDArray[np.int64]] | None:
    """(spots kept, where they lie in the other view, weight, moments that agree), or None if fewer than 20."""
    if not moments:
        return None
    moved = np.stack([m[0] for m in moments])  # (moments, N, 2)
    known = ~np.isnan(moved[..., 0])
    seen = known.sum(axis=0)
    some = seen >= min(settings.moments, len(moments))
    if some.sum() < 20:
        return None
    moved, known, hue = moved[:, some], known[:, some], np.stack([m[1] for m in moments])[:, some]
    median = np.nanmedian(moved, axis=0)
    spread = np.nanmedian(np.hypot(*np.moveaxis(moved - median, 2, 0)), axis=0)
    keep = spread < settings.spread_px
    if keep.sum() < 20:
        return None
    share = (hue & known).sum(axis=0) / known.sum(axis=0)
    weight = settings.other_hue + (1 - settings.other_hue) * share
    here = spots[some][keep].astype(np.float64)
    return here, here + median[keep], weight[keep], seen[some][keep].astype(np.int64)
