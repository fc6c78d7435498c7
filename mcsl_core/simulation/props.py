"""Things that lie about: gauze, instruments, tubes, towel clamps. Placed on the table's map, lit like it."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.simulation import tools

from .paint import clouds, smoothstep
from .scenario import Scenario
from .solids import CABLE, PLASTIC, Clay, Material, Sprite
from .surface import HALF_MM, Site

GAUZE = Material((0.80, 0.83, 0.84), rough_mm=1.6, rough_length_mm=14, mottle=0.04, weave=0.10)


def paste(
    layer: NDArray, sprite: Sprite, at: tuple[float, float], turn: float, pitch: float, tall: float,
    corner_mm: float = -HALF_MM,
) -> None:  # fmt: skip
    """Lays a sprite on a map, with the soft shade of something ``tall`` mm high.

    Parameters
    ----------
    layer
        (h, w, 3 or 4) float map: BGR; a fourth channel keeps how much still shines through.
    sprite, at, turn
        What, its origin (x, y) in mm, its direction in radians.
    pitch
        mm from one sample of the map to the next.
    tall
        mm.
    corner_mm
        x and y of the map's first sample.
    """
    c, s = np.cos(turn), np.sin(turn)
    move = np.array([[c, -s, at[0]], [s, c, at[1]], [0, 0, 1]])
    to_map = np.array([[1 / pitch, 0, -corner_mm / pitch], [0, 1 / pitch, -corner_mm / pitch], [0, 0, 1]])
    full = to_map @ move @ sprite.to_plane
    rows, columns = sprite.bgra.shape[:2]
    corners = full[:2] @ np.array([[0, columns, columns, 0], [0, 0, rows, rows], [1, 1, 1, 1]])
    margin = int(3 * tall / pitch) + 3
    side = layer.shape[0]
    x0, y0 = np.clip(np.floor(corners.min(1)).astype(int) - margin, 0, side)
    x1, y1 = np.clip(np.ceil(corners.max(1)).astype(int) + margin, 0, side)
    if x1 <= x0 or y1 <= y0:
        return
    shift = np.array([[1, 0, -x0], [0, 1, -y0], [0, 0, 1]])
    laid = cv2.warpAffine(sprite.bgra, (shift @ full)[:2], (int(x1 - x0), int(y1 - y0)), flags=cv2.INTER_LINEAR)
    laid = laid.astype(np.float32) / 255
    alpha = laid[..., 3]
    # The lamp is large: shade lies close around a thing and has no edge.
    shade = np.clip(1.15 * cv2.GaussianBlur(alpha, (0, 0), 0.9 * tall / pitch), 0, 1)
    window = layer[y0:y1, x0:x1]
    window *= ((1 - 0.5 * shade) * (1 - alpha))[..., None]
    window[..., :3] += laid[..., :3]


def swab(rng: np.random.Generator, pitch: float, across_mm: float) -> Sprite:
    """A crumpled gauze swab, more or less soaked."""
    half = across_mm / 2
    clay = Clay(-half * 1.3, -half * 1.2, half * 1.3, half * 1.2, pitch)
    x, y = clay.grid()
    ragged = 0.07 * clouds(rng, x.shape, 34 / clay.pitch, 3)
    square = np.maximum(np.abs(x) / half, np.abs(y) / (rng.uniform(0.6, 0.95) * half))
    box = square + 0.10 * np.hypot(x, y) / half + ragged
    clay.sheet(box < 1, 3 + 2.0 * clouds(rng, x.shape, 26 / clay.pitch, 3) - 3 * smoothstep(0.8, 1.0, box), GAUZE)
    soaked = rng.uniform(0, 1) < 0.75
    stain = (rng.normal(0, half * 0.4), rng.normal(0, half * 0.3), half * rng.uniform(0.5, 1.5)) if soaked else None
    return clay.bake(rng, stain)


def tube(rng: np.random.Generator, pitch: float, material: Material, radius: float) -> tuple[Sprite, float]:
    """A long tube or cable in a lazy curve, to be laid across the drapes."""
    way = np.linspace(-520, 520, 70)
    bend = rng.normal(0, 1, 4)
    y = 28 * bend[0] * np.sin(way / 130 + bend[1]) + 14 * bend[2] * np.sin(way / 61 + bend[3])
    clay = Clay(-520, y.min() - 8, 520, y.max() + 8, 1.5 * pitch)
    clay.rod(list(np.stack([way, y, np.zeros_like(y)], 1)), radius, material)
    return clay.bake(rng), radius


def litter(scenario: Scenario, site: Site, layer: NDArray, pitch: float) -> None:
    """Everything on the drapes: laid so that the opening and the wound stay free."""
    rng = scenario.stream("litter")
    axis = np.deg2rad(site.axis_deg)

    for material, radius in ((PLASTIC, 4.5), (CABLE, 2.6)):
        sprite, tall = tube(rng, pitch, material, radius)
        angle, far = rng.uniform(0, 6.28), rng.uniform(160, 215)
        paste(layer, sprite, (far * np.cos(angle), far * np.sin(angle)), angle + 1.57 + rng.normal(0, 0.3), pitch, tall)

    corners = [n for n in range(4) if rng.random() < 0.85]
    for n in corners:
        a, b = site.towels[n], site.towels[(n + 1) % 4]
        corner = np.linalg.solve(np.array([a[:2], b[:2]]), np.array([a[2] + 3, b[2] + 3]))
        clay = Clay(-130, -55, 12, 55, pitch)
        tools.ringed(clay, 0, (0, 0, 0), tools.Ringed(24, 105, 16, slope=0.02, curve=0.22))
        away = np.arctan2(corner[1], corner[0]) + rng.normal(0, 0.35)
        paste(layer, clay.bake(rng), tuple(corner), away + np.pi, pitch, 4)

    for _ in range(int(rng.integers(3, 7))):
        across = rng.uniform(55, 100)
        angle, far = rng.uniform(0, 6.28), rng.uniform(150, 260)
        paste(
            layer, swab(rng, pitch, across), (far * np.cos(angle), far * np.sin(angle)), rng.uniform(0, 6.28), pitch, 5
        )

    for _ in range(int(rng.integers(3, 7))):
        clay = Clay(-230, -70, 8, 70, pitch)
        kind = int(rng.integers(0, 4))
        if kind == 0:
            tools.forceps(clay, 0, (0, 0, 0), 7, 0.02)
        elif kind == 3:
            tools.hook(clay, 0, (0, 0, 0))
        else:
            jaw, curve = ((20, 0), (34, 0.15))[kind - 1]
            tool = tools.Ringed(jaw, rng.uniform(130, 190), rng.uniform(2, 14), slope=0.02, curve=curve)
            tools.ringed(clay, 0, (0, 0, 0), tool)
        angle, far = rng.uniform(0, 6.28), rng.uniform(150, 250)
        turn = angle + rng.choice((0, 1.57, -1.57)) + rng.normal(0, 0.4)
        middle = 80 * np.array([np.cos(turn), np.sin(turn)])
        paste(layer, clay.bake(rng), (far * np.cos(angle) + middle[0], far * np.sin(angle) + middle[1]), turn, pitch, 4)

    if scenario.traits.limb:
        return  # whose incision is sutured
    # Two retractors hold the wound open; their handles lead out over the drapes.
    for side in (-1, 1):
        clay = Clay(-205, -30, 12, 30, pitch)
        tools.hook(clay, 0, (0, 0, 0), blade=rng.uniform(18, 26))
        along = rng.uniform(-0.45, 0.45) * site.wound_mm[0]
        across = side * site.wound_mm[1] * np.sqrt(1 - (along / site.wound_mm[0]) ** 2) * 0.80
        at = np.array([along, across + site.bend * along**2])
        c, s = np.cos(axis), np.sin(axis)
        grip = (c * at[0] - s * at[1], s * at[0] + c * at[1])
        turn = axis - side * np.pi / 2 + rng.normal(0, 0.3)
        paste(layer, clay.bake(rng), grip, turn, pitch, 5)


def gauze_in_field(scenario: Scenario, layer: NDArray, site: Site, pitch: float, corner_mm: float) -> None:
    """In some fields a small swab lies at the wound's edge."""
    rng = scenario.stream("field gauze")
    if rng.random() < 0.4:
        return
    sprite = swab(rng, pitch, scenario.traits.narrow * rng.uniform(26, 40))
    angle = np.deg2rad(site.axis_deg) + rng.choice((0, np.pi)) + rng.normal(0, 0.5)
    far = site.wound_mm[0] * rng.uniform(0.85, 1.2)
    at = (far * np.cos(angle), far * np.sin(angle))
    paste(layer, sprite, at, rng.uniform(0, 6.28), pitch, 3, corner_mm)
