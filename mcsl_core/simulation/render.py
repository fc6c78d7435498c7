"""Rendering: the pictures of one camera, and the fraction of the field that each of them shows.

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
from .optics import Optics
from .rig import PinholeCamera, cross, unit
from .scenario import Scenario
from .scene import Placement, Scene
from .solids import Sprite

FLAT = np.array([1.0, 1.0, 0.0])


def sensor(scenario: Scenario, camera: int) -> tuple[np.random.Generator, NDArray, float]:
    """A camera's sensor: the random generator of its grain, its gains (B, G, R), how much darker its corners are."""
    rng = scenario.stream("sensor", camera)
    gains = rng.uniform(0.93, 1.07, 3) * rng.uniform(0.9, 1.08)
    return rng, gains, rng.uniform(0.06, 0.16)


def vignette(size: tuple[int, int], corner: float, shift: tuple[float, float] = (0.0, 0.0)) -> NDArray:
    """The darkening towards a picture's corners.

    Parameters
    ----------
    size
        (width, height).
    corner
        By how much the corners are darker, 0..1.
    shift
        How far the optical axis lies from the middle, pixels.

    Returns
    -------
    NDArray
        (H, W) uint8, factors times 255.
    """
    width, height = size
    x = np.linspace(-1, 1, width) - 2 * shift[0] / (width - 1)
    y = (np.linspace(-1, 1, height) - 2 * shift[1] / (height - 1))[:, None]
    dark = corner * (x * x + y * y * (height / width) ** 2) / 1.3
    return np.clip(255 * (1 - dark), 0, 255).astype(np.uint8)


class CameraPictures:
    """Renders the frames of one camera. Rising order is quick; any order is right.

    Parameters
    ----------
    scene, ground
        What is filmed.
    camera
        Its index.
    clock
        The camera's.
    optics
        Its lens and electronics; as the scene's lamp moves without.
    """

    def __init__(self, scene: Scene, ground: Ground, camera: int, clock: Clock, optics: Optics | None = None) -> None:
        self._scene, self._clock = scene, clock
        scenario = scene.scenario
        self._size = width, height = scenario.size
        rng, gains, corner = sensor(scenario, camera)
        self._gains, self._k1 = gains, float(scene.rig.k1[camera])
        self._optics = optics or Optics(scenario, scene.path, camera)
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

    def frame(self, k: float) -> tuple[Planes, tuple[float, float]]:
        """The camera's own frame ``k`` and the field's visible fractions: everything counted, and without hands.

        Between two whole numbers it is a picture between two frames.
        """
        t = self._clock.programme(k / float(self._scene.scenario.rate))
        background, pinhole = self._backdrop.at(t)
        picture = background.copy()
        lens = pinhole.through_lens(self._k1)
        points = self._scene.surface.visibility_points_mm
        visible = FieldCount(pinhole.project(points), inside(lens.project(points), self._size))
        placements = list(self._scene.placements(t))
        for placement in placements:
            if placement.kind != "head":
                self._shade(placement, pinhole)
        self._shades.into(self._arms)
        for placement in placements:
            if placement.kind == "sleeve":
                visible.occlude(self._draw(self._arms, placement, pinhole), self._arms.scale, True)
        self._arms.onto(picture)
        for placement in placements:
            if placement.kind == "hand":
                visible.occlude(self._draw(picture, placement, pinhole), 1, True)
        for placement in placements:
            if placement.kind == "head":
                visible.occlude(self._draw(self._heads, placement, pinhole), self._heads.scale, False)
        self._heads.onto(picture)
        return self._develop(self._optics.seen(picture, pinhole, lens, t), int(k)), visible.fractions()

    def _sprite(self, sprite: Sprite) -> tuple[NDArray, NDArray, NDArray, NDArray]:
        """The sprite as a layer in this camera's colours, and the soft shade it casts, small; each with its plane."""
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
        """Soft shade on the surface right below."""
        _, _, shade, to_plane = self._sprite(placement.sprite)
        below = placement.origin * FLAT + (0, 0, placement.ground_z)
        matrix = plane_to_picture(pinhole, below, placement.ahead * FLAT, placement.aside * FLAT)
        self._shades.draw(shade, matrix @ to_plane)

    def _develop(self, picture: Picture, k: int) -> Planes:
        """Vignette and grain."""
        height, width = picture.y.shape
        luma = cv2.multiply(picture.y, self._vignette, scale=1 / 255)
        # One large field of grain, of which every frame takes another part.
        dx, dy = (k * 29) % 64, (k * 47 + k // 64 * 13) % 64
        luma = cv2.add(luma, self._brighter[dy : dy + height, dx : dx + width])
        luma = cv2.subtract(luma, self._darker[dy : dy + height, dx : dx + width])
        return Picture(luma, picture.u, picture.v).planes()


def inside(px: NDArray, size: tuple[int, int]) -> NDArray:
    """(M,) which of (M, 2) pixels lie inside a picture of (width, height)."""
    whole = np.rint(px).astype(np.intp)
    return np.asarray(((whole >= 0) & (whole < size)).all(1))


class FieldCount:
    """Counts which of the field's points are still visible as things are drawn over them.

    Parameters
    ----------
    px
        (M, 2) the points in the picture as it is drawn.
    shown
        (M,) which of them lie inside the picture.
    """

    def __init__(self, px: NDArray, shown: NDArray) -> None:
        self._total = len(px)
        self._x, self._y = np.rint(px).astype(np.intp)[shown].T
        xy = (self._x, self._y)
        self._box = (*(v.min(initial=1 << 20) for v in xy), *(v.max(initial=-1) for v in xy))
        self._visible = np.ones((2, int(shown.sum())), np.float32)

    def occlude(self, drawn: tuple[Box, NDArray] | None, scale: int, is_hand: bool) -> None:
        """Counts what was drawn as an occlusion.

        Parameters
        ----------
        drawn
            Its box and opacity, as `Picture.draw` returns them.
        scale
            Pixels of the picture to one of ``drawn``.
        is_hand
            Whether it is a hand at work.
        """
        if drawn is None:
            return
        (x0, y0, x1, y1), alpha = drawn
        left, top, right, bottom = self._box
        if right < x0 * scale or bottom < y0 * scale or left >= x1 * scale or top >= y1 * scale:
            return
        x, y = self._x // scale, self._y // scale
        under = (x >= x0) & (x < x1) & (y >= y0) & (y < y1)
        transparency = 1 - alpha[y[under] - y0, x[under] - x0] / np.float32(255)
        self._visible[0, under] *= transparency
        if not is_hand:
            self._visible[1, under] *= transparency

    def fractions(self) -> tuple[float, float]:
        """Visible fractions: everything counted, and without hands."""
        all_counted, without_hands = (self._visible > 0.5).sum(1) / self._total
        return float(all_counted), float(without_hands)


def plane_to_picture(pinhole: PinholeCamera, origin: NDArray, ahead: NDArray, aside: NDArray) -> NDArray:
    """(3, 3): plane coordinates (mm) -> homogeneous pixels, whose third coordinate is the depth in mm.

    Parameters
    ----------
    pinhole
        The camera.
    origin
        (3,) of the plane, mm.
    ahead, aside
        (3,) unit vectors of its x and y.
    """
    local = np.empty((3, 3))
    local[:, 0], local[:, 1], local[:, 2] = pinhole.R @ ahead, pinhole.R @ aside, pinhole.R @ origin + pinhole.t
    return pinhole.K @ local
