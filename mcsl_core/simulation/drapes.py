"""Drapes: four towels laid around the field and a large sheet beyond, woven, hemmed, creased and wrinkled.

Works on whole maps of the table (see surface.py); gives colour (BGR 0..1) and fine relief (mm).
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from .paint import clouds, mix, smoothstep, waves
from .scenario import Scenario
from .surface import Site

COLOURS = {"green": (0.36, 0.46, 0.17), "blue": (0.60, 0.37, 0.16), "white": (0.70, 0.71, 0.68)}
"""Cloth, BGR, as it looks in full light."""


def weave(rng: np.random.Generator, side: int, angle: float) -> NDArray:
    """Threads in two directions: faint, of uneven thickness; mean 0, deviation about 1."""
    tile = 512
    warp = cv2.blur(rng.standard_normal((tile, tile), np.float32), (1, 9)) * 3
    weft = cv2.blur(rng.standard_normal((tile, tile), np.float32), (9, 1)) * 3
    slub = cv2.blur(rng.standard_normal((tile, tile), np.float32), (31, 1)) * 3.5
    cloth = 0.6 * warp + 0.6 * weft + 0.5 * slub
    turn = cv2.getRotationMatrix2D((side / 2, side / 2), angle, 1.0)
    return cv2.warpAffine(cloth, turn, (side, side), flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT)


def wrinkles(rng: np.random.Generator, shape: tuple[int, int], pitch: float) -> NDArray:
    """Sharp little ridges of cloth that has been pulled about, mm."""
    total = np.zeros(shape, np.float32)
    where = smoothstep(-0.3, 1.2, waves(rng, shape, 60 / pitch))
    for length, tall in ((26, 0.9), (11, 0.42), (5, 0.15)):
        bent = waves(rng, shape, length / pitch) + 0.4 * waves(rng, shape, 0.4 * length / pitch)
        total += tall * np.clip(1 - np.abs(bent) * 1.1, 0, 1) ** 2
    return total * (0.35 + 0.65 * where)


def paint_drapes(scenario: Scenario, site: Site, x: NDArray, y: NDArray, pitch: float) -> tuple[NDArray, NDArray]:
    """Colour and fine relief of all cloth; what lies inside the opening is left for the skin."""
    rng = scenario.stream("drapes")
    shape = x.shape
    base = np.array(COLOURS[scenario.drape], np.float32) * (1 + rng.normal(0, 0.05, 3))
    colour = np.empty((*shape, 3), np.float32)
    colour[:] = base
    bump = np.zeros(shape, np.float32)

    shades = rng.normal(1.0, 0.05, 5)
    sheet_edge = -site.opening(x, y) - rng.uniform(62, 80) + 5 * waves(rng, shape, 90 / pitch)
    layers = [(int(n), site.edge(int(n), x, y)) for n in site.order] + [(4, sheet_edge)]
    for n, edge in layers:
        on = smoothstep(-0.6 * pitch, 0.6 * pitch, edge)
        angle = np.rad2deg(np.arctan2(site.towels[n, 1], site.towels[n, 0])) if n < 4 else rng.uniform(-10, 10)
        threads = weave(rng, shape[0], -angle)
        tint = base * shades[n] * (1 + rng.normal(0, 0.025, 3))
        cloth = tint.astype(np.float32) * (1 + 0.045 * threads + 0.04 * waves(rng, shape, 35 / pitch))[..., None]
        hem = smoothstep(0.3, 1.0, edge) * smoothstep(10.4, 9.8, edge)
        s = (-site.towels[n, 1] * x + site.towels[n, 0] * y) if n < 4 else x + 0.7 * y
        stitch = np.exp(-(((edge - 8.2) / 0.45) ** 2)) * (np.sin(s * 2 * np.pi / 3.2) > -0.35)
        cloth = cloth * (1 - 0.10 * hem - 0.22 * stitch)[..., None]
        # The layer's own thickness at its edge, and the shade it throws on what lies below.
        shade = 1 - 0.45 * np.exp(-np.clip(-edge, 0, None) / 2.2) * (edge < 0.5)
        colour = mix(colour * shade[..., None], cloth, on)
        fold = wrinkles(rng, shape, pitch) * (0.5 + 0.5 * smoothstep(0, 30, edge))
        crease = np.zeros(shape, np.float32)
        c, t = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
        for place, direction in ((c * x + t * y, rng.uniform(0, 150)), (-t * x + c * y, rng.uniform(0, 150))):
            crease += np.exp(-((((place + direction) % 150 - 75) / 1.3) ** 2)) * np.float32(rng.choice((-1, 1)))
        own = fold + 0.45 * crease + 0.55 * hem - 0.35 * stitch + 0.02 * threads
        bump = bump * (1 - on) + own * on
    stains = smoothstep(1.5, 2.4, clouds(rng, shape, 40 / pitch, 4) + 1.2 * smoothstep(40, 0, sheet_edge + 60))
    colour = mix(colour, (0.10, 0.09, 0.33), 0.75 * stains * (scenario.stream("stains").random() < 0.8))
    return colour.astype(np.float32), bump.astype(np.float32)
