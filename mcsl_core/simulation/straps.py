"""Red straps about the field: vessel loops, slings and bands, in the hue of blood and skin."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .props import paste
from .scenario import Scenario
from .solids import Clay, Material
from .surface import Site

RED = Material((0.11, 0.11, 0.66), gloss=0.12, rough_mm=0.4, rough_length_mm=12, mottle=0.05)


def straps(scenario: Scenario, site: Site, layer: NDArray, pitch: float) -> None:
    """Lays bands across the drapes and loops at the opening's edges on the table's map."""
    rng = scenario.stream("straps")
    near = site.towels[:, 2]
    for n in range(int(rng.integers(4, 7))):
        edge = site.towels[n % 4]
        normal, run = edge[:2], np.array([-edge[1], edge[0]])
        wide = rng.uniform(2.2, 4.0)
        if n % 3 == 2:
            # A long band that crosses the drapes, beside the opening.
            long = rng.uniform(140, 260)
            way = np.linspace(-long / 2, long / 2, 24)
            line = np.stack([way, 7 * np.sin(way / rng.uniform(30, 60)), np.zeros_like(way)], 1)
            at = normal * (edge[2] + rng.uniform(14, 60)) + run * rng.uniform(-40, 40)
            turn = float(np.arctan2(run[1], run[0]) + rng.normal(0, 0.25))
        else:
            line = _loop(rng, rng.uniform(34, 60), rng.uniform(20, 36))
            at = normal * (edge[2] + rng.uniform(-4, 26)) + run * rng.uniform(-0.5, 0.5) * float(near.min())
            turn = float(np.arctan2(normal[1], normal[0]) + rng.normal(0, 0.5))
        (left, top), (right, bottom) = line[:, :2].min(0) - 6, line[:, :2].max(0) + 6
        clay = Clay(left, top, right, bottom, pitch)
        clay.rod(line, wide, RED)
        paste(layer, clay.bake(rng), (float(at[0]), float(at[1])), turn, pitch, 2)


def _loop(rng: np.random.Generator, long: float, wide: float) -> NDArray:
    """A band laid back to where it came from, with two tails."""
    corners = [(0, -wide / 2), (long, -wide / 2), (long * 1.05, wide / 2), (long * 0.05, wide / 2), (-4, -wide * 0.55)]
    points = np.array([*corners, (-26, -wide * rng.uniform(0.2, 0.9))])
    points += rng.normal(0, 1.5, points.shape)
    steps = np.linspace(0, 1, 8)[:, None]
    line = np.concatenate([a + steps * (b - a) for a, b in zip(points[:-1], points[1:], strict=True)])
    return np.column_stack([line, np.zeros(len(line))])
