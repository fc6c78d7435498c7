"""The relief below the lamp: heights in mm over a square of the table, and the surgical field in its middle.

Maps are square; column and row of a sample are (x + HALF_MM) / pitch and (y + HALF_MM) / pitch.
"""

from __future__ import annotations

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from .paint import clouds, smoothstep, streaks, warp_by, waves
from .rig import PinholeCamera
from .scenario import Scenario

HALF_MM = 432.0
PITCH_MM = 1.5
SUTURED_MM = 5.0
"""Half width of an incision that is closed."""


@attrs.frozen(eq=False)
class Grid:
    """The sample positions of a map.

    Attributes
    ----------
    x, y
        (h, w) float32, mm.
    pitch_mm
        From one sample to the next.
    """

    x: NDArray
    y: NDArray
    pitch_mm: float

    @classmethod
    def of_table(cls, pitch_mm: float = PITCH_MM) -> Grid:
        """All of the square."""
        line = np.arange(int(2 * HALF_MM / pitch_mm) + 1, dtype=np.float32) * pitch_mm - HALF_MM
        x, y = np.meshgrid(line, line)
        return cls(x, y, pitch_mm)

    def part(self, cut: tuple[slice, slice]) -> Grid:
        """The cut-out of these rows and columns."""
        return Grid(self.x[cut], self.y[cut], self.pitch_mm)


@attrs.frozen(eq=False)
class Site:
    """The site of the operation: the drapes' opening and the incision in it.

    Attributes
    ----------
    axis_deg
        Direction of the incision.
    towels
        (4, 3): unit normal and distance of each drape's edge; the opening is where n.p < d for all.
    order
        (4,): the order in which the four towels were laid.
    wound_mm
        Half length and half width of the incision, held open.
    bend
        Curvature of the incision.
    wobble
        (8,): phases of the waves along the edges.
    """

    axis_deg: float
    towels: NDArray
    order: NDArray
    wound_mm: tuple[float, float]
    bend: float
    wobble: NDArray

    @classmethod
    def of(cls, scenario: Scenario) -> Site:
        """The site of a scenario."""
        rng = scenario.stream("site")
        axis = rng.uniform(-25, 25)
        reach = (rng.uniform(86, 98), rng.uniform(56, 66), rng.uniform(86, 98), rng.uniform(56, 66))
        narrow = scenario.traits.narrow
        reach = tuple(narrow * d for d in reach)
        angles = np.deg2rad(axis + 90 * np.arange(4) + rng.uniform(-7, 7, 4))
        towels = np.stack([np.cos(angles), np.sin(angles), reach], 1)
        wound = (narrow * rng.uniform(52, 62), narrow * rng.uniform(23, 29))
        if scenario.traits.limb:
            wound = (wound[0], narrow * SUTURED_MM)
        return cls(axis, towels, rng.permutation(4), wound, rng.uniform(-0.0022, 0.0022), rng.normal(0, 1, 8))

    def along(self, x: NDArray, y: NDArray) -> tuple[NDArray, NDArray]:
        """Coordinates along and across the incision, mm."""
        c, s = float(np.cos(np.deg2rad(self.axis_deg))), float(np.sin(np.deg2rad(self.axis_deg)))
        u, v = c * x + s * y, -s * x + c * y
        return u, v - self.bend * u * u

    def edge(self, n: int, x: NDArray, y: NDArray) -> NDArray:
        """mm from towel n's edge, positive on the towel."""
        # Plain floats, for numpy 2 makes doubles of float32 maps that meet its own scalars.
        nx, ny, d = (float(v) for v in self.towels[n])
        s = -ny * x + nx * y
        wave = 2.2 * np.sin(s / 31 + float(self.wobble[n])) + 1.2 * np.sin(s / 13.7 + 2 * float(self.wobble[n + 4]))
        return nx * x + ny * y - d + wave - 0.0007 * s * s

    def opening(self, x: NDArray, y: NDArray) -> NDArray:
        """mm inside the opening: positive on bare skin, negative under drapes."""
        return -np.max([self.edge(n, x, y) for n in range(4)], axis=0)

    def wound(self, x: NDArray, y: NDArray) -> NDArray:
        """1 along the incision's middle, 0 at its lips, negative outside."""
        u, v = self.along(x, y)
        length, width = self.wound_mm
        ragged = 1 + 0.05 * np.sin(u / 7.3 + float(self.wobble[0])) + 0.04 * np.sin(u / 3.1 + float(self.wobble[1]))
        lens = width * ragged * np.sqrt(np.clip(1 - (u / length) ** 2, 1e-4, None))
        return 1 - np.maximum(np.abs(v) / lens, np.abs(u) / length)


@attrs.frozen(eq=False)
class Surface:
    """The relief and the points that stand for the surgical field.

    Attributes
    ----------
    site
        The drapes' opening and the incision.
    height_mm
        (h, w), heights.
    field_points_mm
        (N, 3), spread evenly over the field, some 300 of them: the truth's correspondences.
    visibility_points_mm
        (M, 3), 500 and more: what the visible fraction is counted on.
    """

    site: Site
    height_mm: NDArray
    field_points_mm: NDArray
    visibility_points_mm: NDArray

    @classmethod
    def of(cls, scenario: Scenario) -> Surface:
        """The surface of a scenario."""
        site = Site.of(scenario)
        height = relief(scenario, site)
        narrow = scenario.traits.narrow
        return cls(site, height, spread(site, height, 9.0 * narrow), spread(site, height, 7.0 * narrow))

    def height_at(self, x: NDArray, y: NDArray) -> NDArray:
        """Heights in mm at points in mm."""
        return sample(self.height_mm, x, y)

    def intersect(self, pinhole: PinholeCamera, px: NDArray) -> tuple[NDArray, NDArray]:
        """x, y (mm, float32) where the rays through pixels (..., 2) meet the surface."""
        rays = pinhole.rays(px)
        slope_x, slope_y = rays[..., 0] / rays[..., 2], rays[..., 1] / rays[..., 2]
        cx, cy, cz = pinhole.centre_mm
        z = np.zeros(px.shape[:-1])
        # Fixed-point steps; the half step keeps steep wound walls seen at a slant from oscillating.
        for n in range(14):
            x, y = cx + slope_x * (z - cz), cy + slope_y * (z - cz)
            found = sample(self.height_mm, x, y)
            z = found if n == 0 else z + 0.7 * (found - z)
        return (cx + slope_x * (z - cz)).astype(np.float32), (cy + slope_y * (z - cz)).astype(np.float32)


def sample(height: NDArray, x: NDArray, y: NDArray) -> NDArray:
    """A map's values at points in mm, by bilinear interpolation."""
    flat = cv2.remap(
        height,
        ((np.asarray(x) + HALF_MM) / PITCH_MM).astype(np.float32).reshape(np.shape(x)[0], -1),
        ((np.asarray(y) + HALF_MM) / PITCH_MM).astype(np.float32).reshape(np.shape(x)[0], -1),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    )
    return flat.reshape(np.shape(x))


def relief(scenario: Scenario, site: Site) -> NDArray:
    """The body's swell, the gaping wound with its lips and what bulges in it, drapes in folds around."""
    rng = scenario.stream("relief")
    grid = Grid.of_table()
    x, y = grid.x, grid.y
    shape = x.shape
    u, v = site.along(x, y)
    turn = rng.uniform(-0.5, 0.5)
    across = v * np.cos(turn) + u * np.sin(turn)
    along = u * np.cos(turn) - v * np.sin(turn)
    body = -45 * (1 - np.exp(-((across / 190) ** 2) - (along / 420) ** 2)) + 1.6 * clouds(rng, shape, 45, 2)
    if scenario.traits.limb:
        body = limb(scenario, u, v) + 0.4 * (body - body.mean())
    depth = site.wound(x, y)
    gap = smoothstep(-0.1, 1.0, cv2.GaussianBlur(depth.astype(np.float32), (0, 0), 2.2))
    lips = np.exp(-(((depth + 0.22) / 0.28) ** 2)) * np.clip(1.2 - np.abs(u) / site.wound_mm[0], 0, 1)
    bulge = np.exp(-(((u - rng.uniform(-16, 16)) / 26) ** 2) - (v / 11) ** 2)
    deep = min(1.0, site.wound_mm[1] / 23)  # a narrow wound gapes less
    flesh = body - deep * rng.uniform(22, 28) * gap + deep * 4.5 * lips + deep * rng.uniform(7, 12) * bulge * gap
    flesh += 0.9 * gap * waves(rng, shape, 5)
    flesh = cv2.GaussianBlur(flesh.astype(np.float32), (0, 0), 2.4)
    opening = site.opening(x, y)
    inside = flesh[opening > 0]
    span = np.percentile(inside, 99) - np.percentile(inside, 1)
    scale = np.float32(scenario.relief_mm / span)
    # What is scaled is the field; far out the body keeps falling at most as steeply as drawn above.
    ground = (flesh - inside.mean()) * (scale + (min(scale, 1.0) - scale) * smoothstep(0, 120, -opening))
    cloth = smoothstep(0, 14, -opening)
    folds = drape_folds(rng, shape, opening) * cloth * min(1.0, scenario.relief_mm / 20)
    folds *= not scenario.traits.plain
    height = ground + 1.5 * cloth * min(1.0, scenario.relief_mm / 5) + folds
    return cv2.GaussianBlur(height.astype(np.float32), (0, 0), 1.1)


def limb(scenario: Scenario, u: NDArray, v: NDArray) -> NDArray:
    """A limb along the incision: round above, with sides of up to 60 degrees, which every camera still looks onto."""
    rng = scenario.stream("limb")
    narrow = scenario.traits.narrow
    tall, half = narrow * rng.uniform(56, 64), narrow * rng.uniform(36, 42)
    taper, bow = rng.uniform(-0.06, 0.06), rng.uniform(-0.0005, 0.0005)
    width = half + np.clip(taper * u + 2.5 * np.sin(u / 37 + rng.uniform(0, 6.28)), -0.3 * half, 0.5 * half)
    return tall / (1 + ((v - bow * u * u) / width) ** 4)


def drape_folds(rng: np.random.Generator, shape: tuple[int, int], opening: NDArray) -> NDArray:
    """Long folds in two main directions that grow away from the opening, where the cloth is held down."""
    bend_x, bend_y = (12 * waves(rng, shape, 60) for _ in range(2))
    angle = rng.uniform(0, 180)
    where = smoothstep(-0.6, 0.6, waves(rng, shape, 110))
    total = np.zeros(shape, np.float32)
    for turn, weight in ((angle, where), (angle + rng.uniform(50, 110), 1 - where)):
        for along, across, tall in ((190, 34, 5.0), (110, 17, 2.6)):
            wave = streaks(rng, shape, along / PITCH_MM, across / PITCH_MM, turn)
            ridge = np.clip(1 - np.abs(wave) * 0.9, 0, 1)
            total += weight * tall * (0.55 * np.tanh(wave) + 0.8 * ridge * ridge)
    total = warp_by(total.astype(np.float32), bend_x, bend_y)
    return total * (0.2 + 0.8 * smoothstep(10, 110, -opening))


def spread(site: Site, height: NDArray, step_mm: float) -> NDArray:
    """Points on the field in a triangular grid of that step, keeping clear of the drapes' edge."""
    rows = np.arange(-150, 150, step_mm * 0.866)
    x = np.concatenate([np.arange(-180, 180, step_mm) + (n % 2) * step_mm / 2 for n in range(len(rows))])
    y = np.repeat(rows, len(np.arange(-180, 180, step_mm)))
    inside = site.opening(x, y) > 2.0
    x, y = x[inside], y[inside]
    return np.stack([x, y, sample(height, x[:, None], y[:, None])[:, 0]], 1).astype(np.float64)
