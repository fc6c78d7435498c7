"""Skin, wound and blood of the surgical field.

Works on a cut-out of the table's map around the field; colours BGR 0..1, heights mm. Hues stay in OpenCV's 0..30 and
150..179, which is where the paper finds a field; pen marks and veins alone leave it.
"""

from __future__ import annotations

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from .paint import bgr, cells, clouds, mix, polyline, smoothstep, warp_by, waves
from .scenario import Scenario
from .surface import Grid, Site

SKINS = {
    "light": (0.52, 0.63, 0.84),
    "medium": (0.33, 0.45, 0.68),
    "dark": (0.15, 0.21, 0.36),
    "near-black": (0.060, 0.075, 0.110),
}
BLOOD = (0.05, 0.04, 0.47)
DEEP_BLOOD = (0.03, 0.02, 0.27)


@attrs.frozen(eq=False)
class Tissue:
    """A painted field before light falls on it.

    Attributes
    ----------
    colour
        (h, w, 3), BGR 0..1.
    bump_mm
        (h, w), fine relief.
    wet
        (h, w), 0 dry skin .. 1 wet tissue.
    opening
        (h, w), 1 where skin lies bare, 0 under drapes.
    bleed
        (h, w), where blood comes first: the field is bloody where this exceeds a level that falls as it bleeds.
    """

    colour: NDArray
    bump_mm: NDArray
    wet: NDArray
    opening: NDArray
    bleed: NDArray

    def with_blood(self, level: float, specks: np.random.Generator) -> tuple[NDArray, NDArray]:
        """Colour and wetness when everything above ``level`` is bloody."""
        film = smoothstep(level - 0.28, level + 0.1, self.bleed)
        thick = smoothstep(level + 0.1, level + 0.8, self.bleed)
        colour = mix(self.colour, BLOOD, 0.82 * film)
        colour = mix(colour, DEEP_BLOOD, 0.75 * thick)
        drops = smoothstep(2.5, 2.9, waves(specks, self.wet.shape, 5.5) + 0.5 * self.bleed)
        colour = mix(colour, BLOOD, 0.75 * drops)
        return colour, np.maximum(self.wet, np.maximum(film, drops) * 0.9)


def paint_tissue(scenario: Scenario, site: Site, grid: Grid) -> Tissue:
    """Skin around the wound, and what lies open in it."""
    x, y, pitch = grid.x, grid.y, grid.pitch_mm
    shape = x.shape
    opening = site.opening(x, y)
    u, _ = site.along(x, y)
    depth = site.wound(x, y) + 0.05 * waves(scenario.stream("ragged"), shape, 5 / pitch)
    colour, bump = _skin(scenario, site, depth, pitch)
    inner, inner_bump = _inside(scenario, site, u, depth, pitch)
    within = smoothstep(-0.02, 0.02, depth)
    rim = np.exp(-((depth / 0.06) ** 2))
    colour = mix(mix(colour, inner, within), (0.46, 0.50, 0.82), 0.55 * rim)
    bump = bump * (1 - within) + inner_bump * within + 0.5 * rim
    rng = scenario.stream("bleed")
    run = waves(rng, shape, 60 / pitch)
    trickle = clouds(rng, shape, 22 / pitch, 4)
    bleed = 1.15 * smoothstep(-0.45, 0.5, depth) + 0.24 * trickle + 0.12 * run
    bleed += 0.55 * np.exp(-(((depth + 0.08) / 0.12) ** 2)) - 0.55 * smoothstep(-0.3, -1.2, depth)
    wet = np.clip(0.16 + 0.75 * within + 0.2 * smoothstep(0.2, 1.5, waves(rng, shape, 30 / pitch)), 0, 1)
    bare = smoothstep(-0.6 * pitch, 0.6 * pitch, opening)
    return Tissue(colour, bump.astype(np.float32), wet.astype(np.float32), bare, bleed.astype(np.float32))


def _skin(scenario: Scenario, site: Site, depth: NDArray, pitch: float) -> tuple[NDArray, NDArray]:
    """Colour and fine relief: mottled, with pores, hair, veins, the disinfectant's yellow-brown, the surgeon's pen."""
    rng = scenario.stream("skin")
    shape = depth.shape
    base = np.array(SKINS[scenario.skin], np.float32) * (1 + rng.normal(0, 0.03, 3))
    mottle = clouds(rng, shape, 28 / pitch, 4)
    colour = base * (1 + bgr(0.05, 0.045, 0.02) * mottle[..., None]) * np.ones((*shape, 1), np.float32)
    flush = smoothstep(-0.4, 1.8, waves(rng, shape, 24 / pitch)) * 0.5 + 0.6 * np.exp(-(((depth + 0.1) / 0.35) ** 2))
    colour = mix(colour, base * bgr(0.68, 0.68, 1.0), np.clip(0.6 * flush, 0, 1))
    iodine = smoothstep(-1.2, 1.6, clouds(rng, shape, 50 / pitch, 4)) * rng.uniform(0.25, 0.62)
    colour = colour * (1 - iodine[..., None] * bgr(0.62, 0.34, 0.08))
    pores = waves(rng, shape, 1.1 / pitch) + 0.7 * waves(rng, shape, 2.3 / pitch)
    colour *= (1 + 0.022 * pores)[..., None]
    lines = np.clip(1 - np.abs(waves(rng, shape, 6 / pitch)) * 2.2, 0, 1) ** 2
    bump = 0.05 * pores - 0.10 * lines + 0.25 * waves(rng, shape, 14 / pitch)

    vein = np.clip(1 - np.abs(clouds(rng, shape, 55 / pitch, 3)) * 9, 0, 1) ** 1.5
    vein = cv2.GaussianBlur(vein * smoothstep(-0.2, 0.9, waves(rng, shape, 50 / pitch)), (0, 0), 0.8 / pitch)
    colour = mix(colour, base * bgr(0.95, 0.74, 0.66), 0.4 * vein)
    bump += 0.5 * vein

    colour = _with_hair(rng, colour, base, pitch)
    return _with_pen_marks(rng, colour, base, site, pitch), bump


def _with_hair(rng: np.random.Generator, colour: NDArray, base: NDArray, pitch: float) -> NDArray:
    """``colour`` with moles and hair."""
    shape = colour.shape[:2]
    moles = np.zeros(shape, np.uint8)
    hair = np.zeros(shape, np.uint8)
    half = (shape[1] - 1) / 2
    for _ in range(int(rng.integers(6, 36))):
        at = rng.uniform(-110, 110, 2) / pitch + half
        radius = rng.uniform(0.4, 1.3) / pitch
        cv2.circle(moles, tuple(int(c * 16) for c in at), int(radius * 16), int(rng.integers(70, 220)), -1, 16, 4)
    colour = mix(colour, base * bgr(0.35, 0.42, 0.55), moles / np.float32(255))
    lie = rng.uniform(0, 6.28)
    for _ in range(int(rng.integers(60, 420))):
        at, turn = rng.uniform(-110, 110, 2), lie + rng.normal(0, 0.45)
        length, curl = rng.uniform(3, 9), rng.normal(0, 0.09)
        way = np.linspace(0, length, 6)
        bend = turn + curl * way
        line = at + np.stack([np.cos(bend), np.sin(bend)], 1) * way[:, None]
        polyline(hair, line / pitch + half, 0.25 / pitch, rng.uniform(0.15, 0.45))
    return mix(colour, base * bgr(0.22, 0.22, 0.28), hair / np.float32(255))


def _with_pen_marks(rng: np.random.Generator, colour: NDArray, base: NDArray, site: Site, pitch: float) -> NDArray:
    """``colour`` with the surgeon's ticks across the incision."""
    shape = colour.shape[:2]
    half = (shape[1] - 1) / 2
    pen = np.zeros(shape, np.uint8)
    turn = np.deg2rad(site.axis_deg)
    turned = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    for at in np.arange(-site.wound_mm[0] + 8, site.wound_mm[0], rng.uniform(15, 22)):
        lens = site.wound_mm[1] * np.sqrt(max(1 - (at / site.wound_mm[0]) ** 2, 0))
        for side in (-1, 1):
            tick = np.array([[at, side * (lens + 1)], [at + rng.normal(0, 1.5), side * (lens + rng.uniform(7, 14))]])
            tick[:, 1] += site.bend * tick[:, 0] ** 2
            polyline(pen, tick @ turned / pitch + half, 1.1 / pitch, 0.8)
    worn = (pen / np.float32(255)) * smoothstep(-1.4, 0.6, waves(rng, shape, 3 / pitch))
    return mix(colour, base * bgr(0.62, 0.26, 0.36), 0.7 * worn)


def _inside(scenario: Scenario, site: Site, u: NDArray, depth: NDArray, pitch: float) -> tuple[NDArray, NDArray]:
    """Colour and fine relief from the lips inwards: fat in lobules, muscle in strands, a glistening organ."""
    rng = scenario.stream("inside")
    shape = u.shape
    lobule, value = cells(rng, shape, 4.2 / pitch)
    small, _ = cells(rng, shape, 2.1 / pitch)
    fat = bgr(0.30, 0.62, 0.88) * (0.80 + 0.16 * value + 0.14 * lobule)[..., None]
    fat = mix(fat, (0.20, 0.27, 0.72), 0.5 * smoothstep(0.2, 1.6, clouds(rng, shape, 9 / pitch, 3)))
    fat_bump = 1.1 * lobule + 0.4 * small

    dx, dy = 2.2 * waves(rng, shape, 12 / pitch) / pitch, 2.2 * waves(rng, shape, 12 / pitch) / pitch
    side = shape[0]
    strands = cv2.blur(rng.standard_normal((side, side), np.float32), (int(16 / pitch) | 1, int(0.7 / pitch) | 1))
    strands = strands / strands.std()
    half = (side - 1) / 2
    turn = cv2.getRotationMatrix2D((half, half), -site.axis_deg, 1.0)
    strands = warp_by(cv2.warpAffine(strands, turn, (side, side), borderMode=cv2.BORDER_REFLECT), dx, dy)
    muscle = bgr(0.13, 0.12, 0.55) * (1 + 0.16 * strands + 0.1 * waves(rng, shape, 7 / pitch))[..., None]
    sinew = smoothstep(0.9, 2.0, strands + 0.8 * waves(rng, shape, 8 / pitch))
    muscle = mix(muscle, (0.50, 0.55, 0.80), 0.55 * sinew)

    organ_hue = (bgr(0.36, 0.40, 0.80), bgr(0.16, 0.16, 0.50), bgr(0.30, 0.45, 0.82))[int(rng.integers(0, 3))]
    net = np.clip(1 - np.abs(clouds(rng, shape, 13 / pitch, 3)) * 7, 0, 1) ** 1.5
    organ = organ_hue * (1 + 0.07 * clouds(rng, shape, 12 / pitch, 4))[..., None]
    organ = mix(organ, (0.08, 0.07, 0.45), 0.65 * net)
    loops = np.sin(u / rng.uniform(7, 11) + 0.8 * waves(rng, shape, 16 / pitch))
    organ = organ * (0.86 + 0.14 * loops)[..., None]

    fuzzy = depth + 0.09 * waves(rng, shape, 7 / pitch)
    colour = mix(fat, muscle, smoothstep(0.20, 0.28, fuzzy))
    colour = mix(colour, organ, smoothstep(0.50, 0.58, fuzzy))
    line = np.exp(-(((fuzzy - 0.53) / 0.03) ** 2)) + 0.6 * np.exp(-(((fuzzy - 0.24) / 0.025) ** 2))
    colour = colour * (1 - 0.4 * np.clip(line, 0, 1))[..., None]
    bump = np.where(fuzzy < 0.24, fat_bump, np.where(fuzzy < 0.53, 0.28 * strands, 0.8 * loops - 0.15 * net))
    return colour.astype(np.float32), cv2.GaussianBlur(bump.astype(np.float32), (0, 0), 0.35 / pitch)
