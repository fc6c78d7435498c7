"""Small sculptures seen from above: rods, balls and sheets of some material, lit and cut out as sprites.

A ``Clay`` is a height map over its own plane (x, y and heights in mm). What comes out is a ``Sprite``: BGRA, uint8,
colours multiplied by their own opacity, with the pixel of its origin and its pixels per mm.
"""

from __future__ import annotations

import attrs
import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from .paint import bgr, clouds, lambert, mix, normals, shine, smoothstep, waves

EMPTY = -1000.0


@attrs.frozen
class Material:
    """A material.

    Attributes
    ----------
    colour
        BGR, 0..1.
    gloss, hardness
        Strength 0..1 and exponent of its highlights.
    rough_mm, rough_length_mm
        Height and length of its unevenness; 0 for smooth.
    mottle
        How uneven its colour is, 0..1.
    mirror
        How much of its surroundings it mirrors, 0..1: steel.
    ribs_mm
        Distance of knitted ribs; 0 without.
    soft_mm
        How far its shapes flow into each other: skin over joints.
    weave
        How much its threads show, 0..1.
    """

    colour: tuple[float, float, float]
    gloss: float = 0.0
    hardness: float = 30.0
    rough_mm: float = 0.0
    rough_length_mm: float = 6.0
    mottle: float = 0.03
    mirror: float = 0.0
    ribs_mm: float = 0.0
    soft_mm: float = 0.0
    weave: float = 0.0


STEEL = Material((0.62, 0.61, 0.60), gloss=0.8, hardness=60, mirror=1.0, mottle=0.02)
PLASTIC = Material((0.62, 0.66, 0.66), gloss=0.6, hardness=80)
CABLE = Material((0.45, 0.22, 0.10), gloss=0.4, hardness=60)


@attrs.frozen(eq=False)
class Sprite:
    """A cut-out on a plane: plane point (x, y) mm lies at pixel origin + (x, y) / pitch.

    Attributes
    ----------
    bgra
        (h, w, 4) uint8, premultiplied.
    origin_px
        (x, y) of the plane's origin.
    pitch_mm
        From one pixel to the next.
    """

    bgra: NDArray
    origin_px: tuple[float, float]
    pitch_mm: float

    @property
    def to_plane(self) -> NDArray:
        """(3, 3): pixel -> plane, mm."""
        ox, oy = self.origin_px
        p = self.pitch_mm
        return np.array([[p, 0, -ox * p], [0, p, -oy * p], [0, 0, 1.0]])


class Clay:
    """A height map that is modelled upon, at twice the sprite's resolution for smooth edges.

    Parameters
    ----------
    left, top, right, bottom
        What of the plane it spans, mm.
    pitch_mm
        Of the sprite.
    """

    def __init__(self, left: float, top: float, right: float, bottom: float, pitch_mm: float) -> None:
        self.pitch = pitch_mm / 2
        # A margin, so that no sprite is cut off where it still has an edge to soften.
        self.left, self.top = left - 4 * pitch_mm, top - 4 * pitch_mm
        columns = 2 * (int((right - left) / pitch_mm) + 8)
        rows = 2 * (int((bottom - top) / pitch_mm) + 8)
        self.z = np.full((rows, columns), EMPTY, np.float32)
        self.part = np.zeros((rows, columns), np.uint8)
        self.materials: list[Material] = []

    def _index(self, material: Material) -> int:
        if material not in self.materials:
            self.materials.append(material)
        return self.materials.index(material) + 1

    def grid(self) -> tuple[NDArray, NDArray]:
        """x and y of every sample, mm."""
        rows, columns = self.z.shape
        x = np.arange(columns, dtype=np.float32) * self.pitch + self.left
        y = np.arange(rows, dtype=np.float32) * self.pitch + self.top
        return np.meshgrid(x, y)

    def rod(self, points: ArrayLike, radii: ArrayLike, material: Material, blend_mm: float = 0.0) -> None:
        """Adds a chain of round bars.

        Parameters
        ----------
        points
            (N, 3) x, y, z, mm.
        radii
            (N,) or one for all, mm.
        material
            What it is made of.
        blend_mm
            How far it melts into what is there already.
        """
        line = np.asarray(points, np.float64)
        thick = np.broadcast_to(np.asarray(radii, np.float64), len(line))
        for a, b, ra, rb in zip(line[:-1], line[1:], thick[:-1], thick[1:], strict=True):
            self._bar(a, b, ra, rb, material, blend_mm)

    def ball(self, centre: tuple, radii: tuple, material: Material, blend_mm: float = 0.0, turn: float = 0) -> None:
        """Adds an ellipsoid with half axes ``radii`` (x, y, z), turned in the plane by ``turn`` radians."""
        reach = max(radii[:2])
        window = self._window(np.asarray(centre) - reach, np.asarray(centre) + reach)
        if window is None:
            return
        x, y = self._coordinates(window)
        dx, dy = x - centre[0], y - centre[1]
        c, s = np.cos(turn), np.sin(turn)
        inside = 1 - ((c * dx + s * dy) / radii[0]) ** 2 - ((c * dy - s * dx) / radii[1]) ** 2
        z = centre[2] + radii[2] * np.sqrt(np.clip(inside, 0, None))
        self._add(window, z, inside > 0, material, blend_mm)

    def sheet(self, mask: NDArray, z: NDArray | float, material: Material) -> None:
        """Adds a flat thing: wherever ``mask`` holds, at height ``z``."""
        window = (slice(0, self.z.shape[0]), slice(0, self.z.shape[1]))
        self._add(window, np.broadcast_to(np.asarray(z, np.float32), self.z.shape), mask, material, 0.0)

    def _bar(self, a, b, ra, rb, material, blend_mm) -> None:
        reach = max(ra, rb)
        window = self._window(np.minimum(a, b) - reach, np.maximum(a, b) + reach)
        if window is None:
            return
        x, y = self._coordinates(window)
        way = b[:2] - a[:2]
        long = float(way @ way)
        s = np.clip(((x - a[0]) * way[0] + (y - a[1]) * way[1]) / long, 0, 1) if long > 1e-9 else np.ones_like(x)
        radius = ra + s * (rb - ra)
        off = (x - a[0] - s * way[0]) ** 2 + (y - a[1] - s * way[1]) ** 2
        z = a[2] + s * (b[2] - a[2]) + np.sqrt(np.clip(radius**2 - off, 0, None))
        self._add(window, z, off < radius**2, material, blend_mm)

    def _window(self, low: NDArray, high: NDArray) -> tuple[slice, slice] | None:
        rows, columns = self.z.shape
        x0, x1 = int((low[0] - self.left) / self.pitch) - 1, int((high[0] - self.left) / self.pitch) + 2
        y0, y1 = int((low[1] - self.top) / self.pitch) - 1, int((high[1] - self.top) / self.pitch) + 2
        x0, x1, y0, y1 = max(x0, 0), min(x1, columns), max(y0, 0), min(y1, rows)
        return (slice(y0, y1), slice(x0, x1)) if x0 < x1 and y0 < y1 else None

    def _coordinates(self, window: tuple[slice, slice]) -> tuple[NDArray, NDArray]:
        rows, columns = window
        x = np.arange(columns.start, columns.stop, dtype=np.float32) * self.pitch + self.left
        y = np.arange(rows.start, rows.stop, dtype=np.float32) * self.pitch + self.top
        return x[None, :], y[:, None]

    def _add(self, window, z, where, material, blend_mm) -> None:
        old, part, index = self.z[window], self.part[window], self._index(material)
        above = where & (z > old)
        if blend_mm > 0:
            same = where & (part == index)
            near = np.clip(1 - np.abs(z - old) / blend_mm, 0, None)
            melted = np.maximum(z, old) + near * near * blend_mm / 4
            old[same] = melted[same]
            above &= ~same
        old[above] = np.broadcast_to(z, old.shape)[above]
        part[above] = index

    def _trim(self) -> None:
        """Cuts off what stayed empty, but for a margin."""
        rows, columns = np.flatnonzero(self.part.any(1)), np.flatnonzero(self.part.any(0))
        y0, y1 = max(rows[0] - 8, 0), min(rows[-1] + 9, self.part.shape[0])
        x0, x1 = max(columns[0] - 8, 0), min(columns[-1] + 9, self.part.shape[1])
        y1, x1 = y1 - (y1 - y0) % 2, x1 - (x1 - x0) % 2
        self.z, self.part = self.z[y0:y1, x0:x1], self.part[y0:y1, x0:x1]
        self.left, self.top = self.left + x0 * self.pitch, self.top + y0 * self.pitch

    def _soften(self) -> None:
        for index, stuff in enumerate(self.materials, 1):
            if stuff.soft_mm:
                at = (self.part == index).astype(np.float32)
                sigma = stuff.soft_mm / self.pitch
                share = cv2.GaussianBlur(at, (0, 0), sigma)
                mean = cv2.GaussianBlur(self.z * at, (0, 0), sigma) / np.maximum(share, 1e-3)
                # Near an edge there is too little around to take a mean of.
                self.z += smoothstep(0.5, 1.0, share) * at * (mean - self.z)

    def bake(self, rng: np.random.Generator, stain: tuple | None = None) -> Sprite:
        """The lit sprite; ``stain`` is (x, y, radius) in mm of a blood stain."""
        self._trim()
        shape, pitch = self.z.shape, self.pitch
        solid = self.part > 0
        bump = np.zeros(shape, np.float32)
        albedo = np.zeros((*shape, 3), np.float32)
        gloss, mirror = np.zeros(shape, np.float32), np.zeros(shape, np.float32)
        hard = np.full(shape, 30, np.float32)
        x, y = self.grid()
        for index, stuff in enumerate(self.materials, 1):
            at = self.part == index
            if not at.any():
                continue
            tone = 1 + stuff.mottle * clouds(rng, shape, 22 / pitch, 3)
            if stuff.weave:
                tone = tone * (1 + stuff.weave * cv2.blur(rng.standard_normal(shape, np.float32), (5, 2)) * 2)
            albedo[at] = (bgr(*stuff.colour) * tone[..., None])[at]
            gloss[at], hard[at], mirror[at] = stuff.gloss, stuff.hardness, stuff.mirror
            if stuff.rough_mm:
                length = stuff.rough_length_mm / pitch
                bent = waves(rng, shape, length) + 0.5 * waves(rng, shape, length / 2.4)
                rough = np.clip(1 - np.abs(bent), -0.5, 1) + 0.25 * waves(rng, shape, length / 3)
                bump[at] += (stuff.rough_mm * rough)[at]
            if stuff.ribs_mm:
                bump[at] += (0.35 * np.sin(2 * np.pi * (y + 0.2 * x) / stuff.ribs_mm))[at]
        if stain is not None:
            far = np.hypot(x - stain[0], y - stain[1]) / stain[2]
            bloody = smoothstep(0.55, -0.35, far - 0.6 + 0.22 * clouds(rng, shape, 14 / pitch, 4))
            albedo = mix(albedo, (0.03, 0.025, 0.34), 0.8 * bloody)
        self._soften()
        height = np.where(solid, self.z, np.float32(np.min(self.z[solid], initial=0.0) - 1.0))
        n = normals(cv2.GaussianBlur(height + bump, (0, 0), 0.3 / pitch), pitch)
        light = 0.30 + 0.62 * lambert(n, (0.25, -0.2, 1.0)) + 0.13 * lambert(n, (-0.8, 0.5, 0.5))
        hollow = np.clip((height - cv2.GaussianBlur(height, (0, 0), 5 / pitch)) / 9, -0.35, 0.12)
        colour = albedo * (light * (1 + hollow))[..., None]
        # Steel shows the bright lamp and the dark room around it in bands.
        bands = 0.42 + 0.5 * smoothstep(-0.3, 0.5, n[..., 1] - 0.3 * n[..., 0]) * smoothstep(1.0, 0.45, n[..., 1])
        bands = bands - 0.35 * smoothstep(0.45, 0.85, np.abs(n[..., 0]) + np.abs(n[..., 1]) * 0.6)
        colour = mix(colour, albedo * (0.25 + bands)[..., None], mirror)
        spark = np.maximum(shine(n, np.array([0.12, -0.1, 1.0]), 1.0), 0) ** hard
        spark += 0.6 * np.maximum(shine(n, np.array([-0.18, 0.2, 1.0]), 1.0), 0) ** (1.6 * hard)
        colour += (0.55 * gloss * spark)[..., None]
        out = np.dstack([np.clip(colour, 0, 1) * solid[..., None], solid.astype(np.float32)])
        rows, columns = shape[0] // 2, shape[1] // 2
        small = cv2.resize(out, (columns, rows), interpolation=cv2.INTER_AREA)
        bgra = np.clip(small * 255 + 0.5, 0, 255).astype(np.uint8)
        final = 2 * pitch
        return Sprite(bgra, (-self.left / final - 0.25, -self.top / final - 0.25), final)


def softened(sprite: Sprite, blur_mm: float) -> Sprite:
    """The sprite out of focus."""
    sigma = blur_mm / sprite.pitch_mm
    return attrs.evolve(sprite, bgra=cv2.GaussianBlur(sprite.bgra, (0, 0), sigma)) if sigma > 0.3 else sprite
