"""How far a picture's background lies from where it lay: patch by patch, to a fraction of a pixel.

Displacements are (x, y) in pixels of a picture of 360 rows, the samples' size, whatever the size looked at.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np
from attrs import evolve, field, frozen
from numpy.typing import NDArray

Grey = NDArray[np.float32]
Array = NDArray[np.float64]

LOOK_HEIGHT = 180  # rows looked at: a quarter of the cost of 360 rows, and 0.02 px are still seen over all cameras
UNIT_PX = 2.0  # pixels of a picture of 360 rows in one of LOOK_HEIGHT
PATCH_PX = 12  # at LOOK_HEIGHT: some 390 patches in a 16:9 picture
REACH_PX = 2.4  # displacement up to which one linear step is right to a tenth; the fine structure is 3 to 6 px wide
LIKENESS = 0.5  # share of a patch's structure that the displaced patch before must explain (correlation 0.7)

# Right down to waves of 5 px. Sobel's derivative smooths across: it told 0.45 px where fine weave had moved by 0.3.
SLOPE = np.array([1, -8, 0, 8, -1], np.float32) / 12
UNIT = np.ones(1, np.float32)


def texture(picture: NDArray[np.uint8]) -> Grey:
    """The fine structure of a (H, W, 3) BGR picture at `LOOK_HEIGHT` rows: free of noise and of slow shading, so
    that neither coding nor a change of light counts as motion. Cropped to whole patches."""
    grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
    width = max(PATCH_PX, round(grey.shape[1] * LOOK_HEIGHT / grey.shape[0]))
    small = cv2.resize(grey, (width, LOOK_HEIGHT), interpolation=cv2.INTER_AREA).astype(np.float32)
    fine = cv2.GaussianBlur(small, (0, 0), 0.8) - cv2.GaussianBlur(small, (0, 0), 3)
    return np.ascontiguousarray(fine[: LOOK_HEIGHT // PATCH_PX * PATCH_PX, : width // PATCH_PX * PATCH_PX])  # pyright: ignore[reportReturnType]


def _patch_means(values: Grey) -> Array:
    size = (values.shape[1] // PATCH_PX, values.shape[0] // PATCH_PX)
    return np.asarray(cv2.resize(values, size, interpolation=cv2.INTER_AREA), np.float64)


@frozen(eq=False)
class Shift:
    """How a later picture lies to a standing one, patch by patch (rows, columns).

    textured: patches with structure in both pictures. near: of those, the ones found again within `REACH_PX`.
    moved: (rows, columns, 2) their displacement in pixels.
    """

    textured: NDArray[np.bool_]
    near: NDArray[np.bool_]
    moved: Array

    def share(self, within_px: float = math.inf) -> float:
        """The share of textured patches that are found again ``within_px`` of their place: 0..1; NaN (no data) where
        fewer than 40 patches have texture."""
        total = int(self.textured.sum())
        if total < 40:
            return math.nan
        return float((self.near & (np.hypot(self.moved[..., 0], self.moved[..., 1]) < within_px)).sum() / total)

    def common(self) -> Array | None:
        """The displacement that the near patches have in common, as (4,): x, y, zoom and turn, each in pixels, so
        scaled that the vector's length is the rms displacement over the picture. None where fewer than 8 are near.

        Robust (Cauchy weights, 0.15 px): what a head or a hand does in some of the patches does not count.
        """
        if self.near.sum() < 8:
            return None
        rows, columns = self.near.shape
        y, x = np.mgrid[:rows, :columns].astype(np.float64)
        x, y = x - x.mean(), y - y.mean()
        scale = math.sqrt(float((x * x + y * y).mean()))
        x, y, moved = x[self.near] / scale, y[self.near] / scale, self.moved[self.near]
        one, zero = np.ones_like(x), np.zeros_like(x)
        design = np.concatenate([np.stack([one, zero, x, -y], 1), np.stack([zero, one, y, x], 1)])
        target = moved.T.reshape(-1)
        found = np.array([*np.median(moved, axis=0), 0.0, 0.0])
        for _ in range(6):
            off = (target - design @ found).reshape(2, -1)
            weight = np.tile(1 / (1 + (off**2).sum(axis=0) / 0.15**2), 2)
            normal = design.T * weight
            found = np.linalg.solve(normal @ design + 1e-6 * np.eye(4), normal @ target)
        return np.asarray(found, np.float64)


@frozen(eq=False)
class Standing:
    """A view to compare later ones with, prepared for that.

    A later patch c is explained by the standing one t, brighter or darker and displaced: c = g (t - d . grad t), solved
    for g and d by least squares (Lucas and Kanade 1981, with a gain).
    """

    texture: Grey
    _across: Grey = field(repr=False)
    _down: Grey = field(repr=False)
    _inverse: Array = field(repr=False)
    _textured: NDArray[np.bool_] = field(repr=False)

    @classmethod
    def of(cls, textures: Sequence[Grey]) -> Standing:
        """From one texture, or the median of several of one standing view: what passes is not in it."""
        one = textures[0] if len(textures) == 1 else np.median(np.stack(textures), axis=0).astype(np.float32)
        across, down = cv2.sepFilter2D(one, -1, SLOPE, UNIT), cv2.sepFilter2D(one, -1, UNIT, SLOPE)
        parts = (one, across, down)
        normal = np.empty((*_patch_means(one).shape, 3, 3))
        for i, a in enumerate(parts):
            for j, b in enumerate(parts[: i + 1]):
                normal[..., i, j] = normal[..., j, i] = _patch_means(a * b)  # pyright: ignore[reportArgumentType]
        xx, yy, xy = normal[..., 1, 1], normal[..., 2, 2], normal[..., 1, 2]
        weakest = (xx + yy) / 2 - np.sqrt(((xx - yy) / 2) ** 2 + xy**2)  # a lone edge does not show motion along it
        textured = (normal[..., 0, 0] > 0.6) & (weakest > 0.03)
        return cls(one, across, down, np.linalg.inv(normal + 1e-3 * np.eye(3)), textured)  # pyright: ignore[reportArgumentType]

    def at_rest(self, views: Sequence[Grey], within_px: float) -> Standing:
        """Only with the patches that most of ``views``, all at rest, show ``within_px`` of their place: no heads."""
        shifts = [s for view in views if (s := self.shift(view)) is not None]
        if not shifts:
            return self
        lying = [s.near & (np.hypot(s.moved[..., 0], s.moved[..., 1]) < within_px) for s in shifts]
        return evolve(self, textured=self._textured & (np.mean(lying, axis=0) > 0.7))

    def shift(self, later: Grey) -> Shift | None:
        """How ``later`` lies to this view. None when it is the very same picture (a frozen stream proves nothing) or
        of another size."""
        if later.shape != self.texture.shape or float(cv2.norm(later, self.texture, cv2.NORM_L1)) < 0.01 * later.size:
            return None
        seen = np.stack([_patch_means(later * part) for part in (self.texture, self._across, self._down)], axis=-1)
        structure = _patch_means(later * later)
        solved = np.einsum("hwij,hwj->hwi", self._inverse, seen)
        explained = (solved * seen).sum(axis=-1)
        moved = -UNIT_PX * solved[..., 1:] / np.maximum(solved[..., :1], 1e-3)
        textured = self._textured & (structure > 0.3)
        near = (explained > LIKENESS * structure) & (solved[..., 0] > 0.3)
        near &= np.hypot(moved[..., 0], moved[..., 1]) < REACH_PX
        return Shift(textured, textured & near, moved)
