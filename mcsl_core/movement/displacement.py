"""Displacement of a picture's background against a template: patch by patch, to a fraction of a pixel.

Displacements are (x, y) in pixels of a picture of 360 rows, the samples' size, whatever the size worked at.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import cv2
import numpy as np
from attrs import evolve, field, frozen
from numpy.typing import NDArray

Grey = NDArray[np.float32]
Array = NDArray[np.float64]

TEXTURE_HEIGHT = 180  # rows: a quarter of the cost of 360 rows, and 0.02 px are still seen over all cameras
UNIT_PX = 2.0  # pixels of a picture of 360 rows in one of TEXTURE_HEIGHT
PATCH_PX = 12  # at TEXTURE_HEIGHT: some 390 patches in a 16:9 picture
MAX_SHIFT_PX = 2.4  # up to here one linear step is right to a tenth; the fine structure is 3 to 6 px wide
LEAST_EXPLAINED = 0.5  # share of a patch's structure that the displaced template must explain (correlation 0.7)

# Right down to waves of 5 px. Sobel's derivative smooths across: it told 0.45 px where fine weave had moved by 0.3.
DERIVATIVE = np.array([1, -8, 0, 8, -1], np.float32) / 12
IDENTITY_KERNEL = np.ones(1, np.float32)


@frozen(eq=False)
class Displacement:
    """Displacement of a picture against a template, patch by patch.

    Attributes
    ----------
    textured
        (rows, columns): patches with structure in both.
    matched
        (rows, columns): of those, the ones found again within `MAX_SHIFT_PX`.
    shift_px
        (rows, columns, 2): their displacement, x and y.
    """

    textured: NDArray[np.bool_]
    matched: NDArray[np.bool_]
    shift_px: Array

    def share(self, within_px: float = math.inf) -> float:
        """The share of textured patches that are found again within ``within_px`` of their position.

        0..1; NaN (no data) where fewer than 40 patches have texture.
        """
        total = int(self.textured.sum())
        if total < 40:
            return math.nan
        return float(
            (self.matched & (np.hypot(self.shift_px[..., 0], self.shift_px[..., 1]) < within_px)).sum() / total
        )

    def common(self) -> Array | None:
        """The similarity that the matched patches have in common.

        Returns
        -------
        Array or None
            (4,): x, y, zoom and rotation, each in pixels and so scaled that the vector's length is the rms displacement
            over the picture. None where fewer than 8 patches are matched.

        Notes
        -----
        Iteratively reweighted least squares with Cauchy weights (0.15 px): what a head or a hand does in some of the
        patches does not count.
        """
        if self.matched.sum() < 8:
            return None
        rows, columns = self.matched.shape
        y, x = np.mgrid[:rows, :columns].astype(np.float64)
        x, y = x - x.mean(), y - y.mean()
        scale = math.sqrt(float((x * x + y * y).mean()))
        x, y, shift_px = x[self.matched] / scale, y[self.matched] / scale, self.shift_px[self.matched]
        one, zero = np.ones_like(x), np.zeros_like(x)
        design = np.concatenate([np.stack([one, zero, x, -y], 1), np.stack([zero, one, y, x], 1)])
        target = shift_px.T.reshape(-1)
        found = np.array([*np.median(shift_px, axis=0), 0.0, 0.0])
        for _ in range(6):
            residual = (target - design @ found).reshape(2, -1)
            weight = np.tile(1 / (1 + (residual**2).sum(axis=0) / 0.15**2), 2)
            normal = design.T * weight
            found = np.linalg.solve(normal @ design + 1e-6 * np.eye(4), normal @ target)
        return np.asarray(found, np.float64)


@frozen(eq=False)
class Template:
    """A texture to compare later ones with, its normal equations prepared.

    Notes
    -----
    A later patch c is explained by the template's patch t, brighter or darker and displaced: c = g (t - d . grad t),
    solved for g and d by least squares.

    References
    ----------
    Lucas and Kanade, "An iterative image registration technique with an application to stereo vision", IJCAI 1981;
    here with a gain.
    """

    texture: Grey
    _dx: Grey = field(repr=False)
    _dy: Grey = field(repr=False)
    _inverse: Array = field(repr=False)
    _textured: NDArray[np.bool_] = field(repr=False)

    @classmethod
    def of(cls, textures: Sequence[Grey]) -> Template:
        """The template of one texture, or of the median of several while the lamp stands: what passes is not in it."""
        one = textures[0] if len(textures) == 1 else np.median(np.stack(textures), axis=0).astype(np.float32)
        dx, dy = (
            cv2.sepFilter2D(one, -1, DERIVATIVE, IDENTITY_KERNEL),
            cv2.sepFilter2D(one, -1, IDENTITY_KERNEL, DERIVATIVE),
        )
        parts = (one, dx, dy)
        normal = np.empty((*_patch_means(one).shape, 3, 3))
        for i, a in enumerate(parts):
            for j, b in enumerate(parts[: i + 1]):
                normal[..., i, j] = normal[..., j, i] = _patch_means(a * b)  # pyright: ignore[reportArgumentType]
        xx, yy, xy = normal[..., 1, 1], normal[..., 2, 2], normal[..., 1, 2]
        weakest = (xx + yy) / 2 - np.sqrt(((xx - yy) / 2) ** 2 + xy**2)  # eigenvalue: an edge shows no motion along it
        textured = (normal[..., 0, 0] > 0.6) & (weakest > 0.03)
        return cls(one, dx, dy, np.linalg.inv(normal + 1e-3 * np.eye(3)), textured)  # pyright: ignore[reportArgumentType]

    def background_only(self, textures: Sequence[Grey], within_px: float) -> Template:
        """The template with the patches only that lie within ``within_px`` in most of ``textures``: no heads.

        Parameters
        ----------
        textures
            Of other frames while the lamp stands where it stood.
        within_px
            How far a patch of the background may seem to move.
        """
        displacements = [self.displacement(later) for later in textures]
        in_place = [
            d.matched & (np.hypot(d.shift_px[..., 0], d.shift_px[..., 1]) < within_px)
            for d in displacements
            if d is not None
        ]
        if not in_place:
            return self
        return evolve(self, textured=self._textured & (np.mean(in_place, axis=0) > 0.7))

    def displacement(self, later: Grey) -> Displacement | None:
        """Displacement of the texture ``later`` against the template.

        None when it is the very same picture (a frozen stream proves nothing) or of another size.
        """
        if later.shape != self.texture.shape or float(cv2.norm(later, self.texture, cv2.NORM_L1)) < 0.01 * later.size:
            return None
        seen = np.stack([_patch_means(later * part) for part in (self.texture, self._dx, self._dy)], axis=-1)
        structure = _patch_means(later * later)
        solved = np.einsum("hwij,hwj->hwi", self._inverse, seen)
        explained = (solved * seen).sum(axis=-1)
        shift_px = -UNIT_PX * solved[..., 1:] / np.maximum(solved[..., :1], 1e-3)
        textured = self._textured & (structure > 0.3)
        matched = (explained > LEAST_EXPLAINED * structure) & (solved[..., 0] > 0.3)
        matched &= np.hypot(shift_px[..., 0], shift_px[..., 1]) < MAX_SHIFT_PX
        return Displacement(textured, textured & matched, shift_px)


def common_sizes(displacements: Iterable[Displacement], *, least_share: float) -> list[float]:
    """Lengths in pixels of the common displacements of those that find more than ``least_share`` of their patches."""
    found = [d.common() for d in displacements if d.share() > least_share]
    return [float(np.linalg.norm(common)) for common in found if common is not None]


def texture(picture: NDArray[np.uint8]) -> Grey:
    """The fine structure of a picture: a difference of Gaussians at `TEXTURE_HEIGHT` rows.

    Free of noise and of slow shading, so that neither coding nor a change of light counts as motion.

    Parameters
    ----------
    picture
        (H, W, 3), BGR.

    Returns
    -------
    Grey
        (h, w) grey levels about 0, cropped to whole patches.
    """
    grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
    width = max(PATCH_PX, round(grey.shape[1] * TEXTURE_HEIGHT / grey.shape[0]))
    small = cv2.resize(grey, (width, TEXTURE_HEIGHT), interpolation=cv2.INTER_AREA).astype(np.float32)
    fine = cv2.GaussianBlur(small, (0, 0), 0.8) - cv2.GaussianBlur(small, (0, 0), 3)
    return np.ascontiguousarray(fine[: TEXTURE_HEIGHT // PATCH_PX * PATCH_PX, : width // PATCH_PX * PATCH_PX])  # pyright: ignore[reportReturnType]


def _patch_means(values: Grey) -> Array:
    size = (values.shape[1] // PATCH_PX, values.shape[0] // PATCH_PX)
    return np.asarray(cv2.resize(values, size, interpolation=cv2.INTER_AREA), np.float64)
