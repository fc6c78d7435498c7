"""Drapes: four towels laid around the field and a large sheet beyond, woven, hemmed, creased and wrinkled.

Works on whole maps of the table (see surface.py); makes colour (BGR 0..1) and fine relief (mm).
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from .paint import bgr, clouds, mix, smoothstep, streaks, warp_by, waves
from .scenario import Scenario
from .surface import Grid, Site

COLOURS = {
    "green": (0.36, 0.46, 0.17),
    "blue": (0.60, 0.37, 0.16),
    "white": (0.70, 0.71, 0.68),
    "skin": (0.42, 0.55, 0.72),
    "brown": (0.24, 0.36, 0.50),
    "blown": (1.75, 1.76, 1.70),
}
"""Cloth in full light, BGR; "skin" and "brown" have the skin's hue, so that hue tells nothing, and "blown" is white
cloth under exposure for the wound."""


def paint_drapes(scenario: Scenario, site: Site, grid: Grid) -> tuple[NDArray, NDArray]:
    """Colour (h, w, 3) and fine relief (h, w) of all cloth; what lies inside the opening is left for the skin."""
    rng = scenario.stream("drapes")
    x, y, pitch = grid.x, grid.y, grid.pitch_mm
    shape = x.shape
    base = np.array(COLOURS[scenario.drape], np.float32) * (1 + rng.normal(0, 0.02, 3))
    shades = rng.normal(1.0, 0.05, 5)
    width = rng.uniform(58, 74)
    colour = np.empty((*shape, 3), np.float32)
    colour[:] = base
    bump = np.zeros(shape, np.float32)
    if scenario.traits.plain:
        return colour, bump

    # The sheet lies over the towels from ``width`` outwards: they need painting up to there only.
    reach = min(round((float(site.towels[:, 2].max()) * 1.35 + width + 30) / pitch), shape[0] // 2)
    middle = shape[0] // 2
    span = slice(middle - reach, middle + reach + 1)
    cut = (span, span)
    inner = grid.part(cut)
    for n in (int(n) for n in site.order):
        nx, ny = float(site.towels[n, 0]), float(site.towels[n, 1])
        angle = float(np.rad2deg(np.arctan2(ny, nx)))
        edge, run = site.edge(n, inner.x, inner.y), nx * inner.y - ny * inner.x
        cloth, own, on, below = _cloth(rng, inner, edge, run, angle, base * shades[n])
        colour[cut] = mix(colour[cut] * below[..., None], cloth, on)
        bump[cut] = mix(bump[cut], own, on)
    edge = -site.opening(x, y) - float(width) + 5 * waves(rng, shape, 90 / pitch)
    cloth, own, on, below = _cloth(rng, grid, edge, x + 0.7 * y, rng.uniform(-12, 12), base * (shades[4] * 0.94))
    colour = mix(colour * below[..., None], cloth, on)
    bump = mix(bump, own, on)
    # Blood and fluid that ran over the edge.
    rng = scenario.stream("stains")
    away = -site.opening(x, y)
    stains = smoothstep(1.6, 3.0, clouds(rng, shape, 26 / pitch, 5, 0.6) + 2.2 * smoothstep(70, 5, away) - 1.5)
    colour = mix(colour, base * bgr(0.12, 0.12, 0.35) + bgr(0.03, 0.02, 0.24), 0.85 * stains)
    return colour, bump


def _cloth(
    rng: np.random.Generator, grid: Grid, edge: NDArray, run: NDArray, angle: float, dye: NDArray
) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    """One piece of cloth: colour, fine relief, opacity, and how it shades what lies below.

    Parameters
    ----------
    rng
        Its chance.
    grid
        Where it is painted.
    edge, run
        mm from its edge, positive on the cloth, and mm along the edge.
    angle
        Of its threads, degrees.
    dye
        (3,), BGR.
    """
    side, pitch = edge.shape[0], grid.pitch_mm
    threads = weave(rng, side, -angle)
    tint = (dye * (1 + rng.normal(0, 0.014, 3))).astype(np.float32)
    tone = 1 + 0.045 * threads + 0.04 * waves(rng, edge.shape, 35 / pitch)
    hem = smoothstep(0.3, 1.0, edge) * smoothstep(10.4, 9.8, edge)
    stitch = np.exp(-(((edge - 8.2) / 0.45) ** 2)) * (np.sin(run * float(2 * np.pi / 3.2)) > -0.35)
    tone *= 1 - 0.10 * hem - 0.22 * stitch
    below = 1 - 0.45 * np.exp(np.clip(edge, None, 0) / 2.2) * (edge < 0.5)
    bump = wrinkles(rng, side, pitch) * (0.5 + 0.5 * smoothstep(0, 30, edge)) + 0.55 * hem - 0.35 * stitch
    bump += 0.02 * threads
    c, t = float(np.cos(np.deg2rad(angle))), float(np.sin(np.deg2rad(angle)))
    for across in (c * grid.x + t * grid.y, -t * grid.x + c * grid.y):
        # Cloth comes folded in squares, and keeps the creases.
        fold = (across + rng.uniform(0, 150)) % 150 - 75
        bump += float(rng.choice((-0.45, 0.45))) * np.exp(-((fold / 1.3) ** 2))
    on = smoothstep(-0.6 * pitch, 0.6 * pitch, edge)
    return tone[..., None] * tint, bump.astype(np.float32), on, below


def weave(rng: np.random.Generator, side: int, angle: float) -> NDArray:
    """Threads in two directions: faint, of uneven thickness; mean 0, deviation about 1."""
    tile = 512
    warp = cv2.blur(rng.standard_normal((tile, tile), np.float32), (1, 9)) * 3
    weft = cv2.blur(rng.standard_normal((tile, tile), np.float32), (9, 1)) * 3
    slub = cv2.blur(rng.standard_normal((tile, tile), np.float32), (31, 1)) * 3.5
    cloth = 0.6 * warp + 0.6 * weft + 0.5 * slub
    turn = cv2.getRotationMatrix2D((side / 2, side / 2), angle, 1.0)
    return cv2.warpAffine(cloth, turn, (side, side), flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_WRAP)


def wrinkles(rng: np.random.Generator, side: int, pitch: float) -> NDArray:
    """Creases of cloth that has been pulled about, mm."""
    coarse = max(pitch, 1.0)
    shape = (int(side * pitch / coarse) + 1,) * 2
    total = np.zeros(shape, np.float32)
    angle = rng.uniform(0, 180)
    where = smoothstep(-0.8, 0.8, waves(rng, shape, 70 / coarse))
    for turn, weight in ((angle, where), (angle + rng.uniform(40, 90), 1 - where)):
        for along, across, tall in ((75, 13, 0.9), (38, 7, 0.42), (20, 3.4, 0.16)):
            wave = streaks(rng, shape, along / coarse, across / coarse, turn + rng.normal(0, 8))
            crest = np.clip(1 - np.abs(wave), 0, 1)
            total += weight * float(tall) * (crest * crest + 0.5 * wave)
    total = warp_by(total, 5 / coarse * waves(rng, shape, 30 / coarse), 5 / coarse * waves(rng, shape, 30 / coarse))
    total *= 0.3 + 0.7 * smoothstep(-0.8, 1.2, waves(rng, shape, 80 / coarse))
    return cv2.resize(total, (side, side), interpolation=cv2.INTER_CUBIC)
