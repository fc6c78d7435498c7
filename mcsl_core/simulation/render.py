"""The pictures of one camera, one after another, and how much of the field each of them shows.

Pixel centres lie at integers.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.imaging.planes import Planes

from .backdrop import Backdrop
from .clocks import Clock
from .ground import Ground
from .layers import Box, Overlay, Picture, layer_of
from .rig import PinholeCamera, cross, unit
from .scenario import Scenario
from .scene import Placement, Scene
from .solids import Sprite

FLAT = np.array([1.0, 1.0, 0.0])


def sensor(scenario: Scenario, camera: int) -> tuple[np.random.Generator, NDArray, float]:
    """The chance that is left for a camera's grain, its gains (B, G, R), and how much darker its corners are."""
    rng = scenario.stream("sensor", camera)
    gains = rng.uniform(0.93, 1.07, 3) * rng.uniform(0.9, 1.08)
    return rng, gains, rng.uniform(0.06, 0.16)


def vignette(size: tuple[int, int], corner: float, shift: tuple[float, float] = (0.0, 0.0)) -> NDArray:
    """(H, W) uint8 shares of 255; ``shift``: how far the optical axis lies from the middle, in pixels."""
    width, height = size
    x = np.linspace(-1, 1, width) - 2 * shift[0] / (width - 1)
    y = (np.linspace(-1, 1, height) - 2 * shift[1] / (height - 1))[:, None]
    dark = corner * (x * x + y * y * (height / width) ** 2) / 1.3
    return np.clip(255 * (1 - dark), 0, 255).astype(np.uint8)


class CameraPictures:
    """Draws what one camera sees. Asking for frames in rising order is quick; any order is right."""

    def __init__(self, scene: Scene, ground: Ground, camera: int, clock: Clock) -> None:
        self._scene, self._clock = scene, clock
        scenario = scene.scenario
        self._size = width, height = scenario.size
        rng, gains, corner = sensor(scenario, camera)
        self._gains = gains
        self._backdrop = Backdrop(scene, ground, camera, gains)
        self._sprites: dict[int, tuple[NDArray, NDArray, NDArray, NDArray]] = {}
        # Arms and heads are near the camera and out of focus: they are put together small and enlarged once.
        self._arms = Overlay(self._size, 2)
        self._shades = Overlay(self._size, 8)
        self._heads = Overlay(self._size, 4 if width >= 640 else 2)
        self._vignette = vignette(self._size, corner)
        grain = rng.normal(0, scenario.noise, (height + 64, width + 64))
        self._brighter = np.clip(np.round(grain), 0, 255).astype(np.uint8)
        self._darker = np.clip(np.round(-grain), 0, 255).astype(np.uint8)

    def frame(self, k: int) -> tuple[Planes, tuple[float, float]]:
        """The camera's own frame ``k`` and the visible fraction of the field, with and without counting hands."""
        t = self._clock.programme(k / float(self._scene.scenario.rate))
        background, pinhole = self._backdrop.at(t)
        picture = background.copy()
        seen = FieldCount(pinhole.project(self._scene.surface.visibility_points_mm), self._size)
        placements = list(self._scene.placements(t))
        for placement in placements:
            if placement.kind != "head":
                self._shade(placement, pinhole)
        self._shades.into(self._arms)
        for placement in placements:
            if placement.kind == "sleeve":
                seen.hide(self._draw(self._arms, placement, pinhole), self._arms.scale, True)
        self._arms.onto(picture)
        for placement in placements:
            if placement.kind == "hand":
                seen.hide(self._draw(picture, placement, pinhole), 1, True)
        for placement in placements:
            if placement.kind == "head":
                seen.hide(self._draw(self._heads, placement, pinhole), self._heads.scale, False)
        self._heads.onto(picture)
        return self._develop(picture, k), seen.fractions()

    def _sprite(self, sprite: Sprite) -> tuple[NDArray, NDArray, NDArray, NDArray]:
        """The sprite as a layer in this camera's colours and the soft shade it throws, small; each with its plane."""
        key = id(sprite)
        if key not in self._sprites:
            pad = int(14 / sprite.pitch_mm)
            alpha = cv2.copyMakeBorder(sprite.bgra[..., 3], pad, pad, pad, pad, cv2.BORDER_CONSTANT, value=0)
            soft = cv2.GaussianBlur(alpha, (0, 0), 7 / sprite.pitch_mm)
            small = cv2.resize(soft, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
            black = np.zeros((*small.shape, 4), np.uint8)
            black[..., 3] = small * 0.5
            ox, oy = sprite.origin_px
            origin = ((ox + pad + 0.5) / 4 - 0.5, (oy + pad + 0.5) / 4 - 0.5)
            shade = Sprite(black, origin, sprite.pitch_mm * 4)
            layers = (layer_of(s.bgra, self._gains) for s in (sprite, shade))
            self._sprites[key] = next(layers), sprite.to_plane, next(layers), shade.to_plane
        return self._sprites[key]

    def _draw(
        self, target: Picture | Overlay, placement: Placement, pinhole: PinholeCamera
    ) -> tuple[Box, NDArray] | None:
        """Where the sprite was drawn and its opacity there, in the target's pixels."""
        layer, to_plane, _, _ = self._sprite(placement.sprite)
        ahead, aside = placement.ahead, placement.aside
        if placement.facing:
            sight = unit(placement.origin - pinhole.centre_mm)
            ahead = unit(ahead - (ahead @ sight) * sight)
            aside = cross(-sight, ahead)
        return target.draw(layer, plane_to_picture(pinhole, placement.origin, ahead, aside) @ to_plane)

    def _shade(self, placement: Placement, pinhole: PinholeCamera) -> None:
        """Soft darkness on the surface right below."""
        _, _, shade, to_plane = self._sprite(placement.sprite)
        below = placement.origin * FLAT + (0, 0, placement.ground_z)
        matrix = plane_to_picture(pinhole, below, placement.ahead * FLAT, placement.aside * FLAT)
        self._shades.draw(shade, matrix @ to_plane)

    def _develop(self, picture: Picture, k: int) -> Planes:
        """Vignette and grain."""
        height, width = picture.y.shape
        luma = cv2.multiply(picture.y, self._vignette, scale=1 / 255)
        # One large field of grain, looked at somewhere else in every frame.
        dx, dy = (k * 29) % 64, (k * 47 + k // 64 * 13) % 64
        luma = cv2.add(luma, self._brighter[dy : dy + height, dx : dx + width])
        luma = cv2.subtract(luma, self._darker[dy : dy + height, dx : dx + width])
        return Picture(luma, picture.u, picture.v).planes()


class FieldCount:
    """Counts which of the field's points are still to be seen as things are drawn over them."""

    def __init__(self, px: NDArray, size: tuple[int, int]) -> None:
        whole = np.rint(px).astype(np.intp)
        inside = ((whole >= 0) & (whole < size)).all(1)
        self._total = len(px)
        self._x, self._y = whole[inside].T
        xy = (self._x, self._y)
        self._box = (*(v.min(initial=1 << 20) for v in xy), *(v.max(initial=-1) for v in xy))
        self._clear = np.ones((2, int(inside.sum())), np.float32)

    def hide(self, drawn: tuple[Box, NDArray] | None, scale: int, is_hand: bool) -> None:
        if drawn is None:
            return
        (x0, y0, x1, y1), alpha = drawn
        left, top, right, bottom = self._box
        if right < x0 * scale or bottom < y0 * scale or left >= x1 * scale or top >= y1 * scale:
            return
        x, y = self._x // scale, self._y // scale
        under = (x >= x0) & (x < x1) & (y >= y0) & (y < y1)
        shows = 1 - alpha[y[under] - y0, x[under] - x0] / np.float32(255)
        self._clear[0, under] *= shows
        if not is_hand:
            self._clear[1, under] *= shows

    def fractions(self) -> tuple[float, float]:
        """Visible fractions: everything counted, and without hands."""
        clear, clear_of_heads = (self._clear > 0.5).sum(1) / self._total
        return float(clear), float(clear_of_heads)


def plane_to_picture(pinhole: PinholeCamera, origin: NDArray, ahead: NDArray, aside: NDArray) -> NDArray:
    """3x3: plane coordinates (mm) to pixels; the third row gives depth in mm."""
    return pinhole.K @ np.stack([pinhole.R @ ahead, pinhole.R @ aside, pinhole.R @ origin + pinhole.t], 1)
