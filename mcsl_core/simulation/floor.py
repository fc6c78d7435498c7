"""The floor beside a narrow table: far below what everything is about, and full of things to match by mistake."""

from __future__ import annotations

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from .paint import bgr, clouds, polyline, smoothstep, to_uint8, waves
from .rig import PinholeCamera
from .scenario import Scenario

DEPTH_MM = 850.0
HALF_MM = 1500.0
PITCH_MM = 2.5
EDGE_MM = 3.0
"""How wide the table's edge is in the picture."""
SHADED_MM = 16.0
"""How far from its edge the drape falls away and darkens."""


@attrs.frozen(eq=False)
class Floor:
    """The floor and the table's two edges.

    Attributes
    ----------
    picture
        (h, w, 3) uint8, BGR, seen from above, `PITCH_MM` a pixel.
    edges
        (2, 3): unit normal and distance in mm; the table lies where n.p < d for both.
    """

    picture: NDArray
    edges: NDArray

    @classmethod
    def of(cls, scenario: Scenario) -> Floor:
        """The floor of a scenario."""
        rng = scenario.stream("floor")
        angle = np.deg2rad(rng.uniform(0, 360))
        normal = np.array([np.cos(angle), np.sin(angle)])
        edges = np.stack([[*normal, rng.uniform(140, 165)], [*-normal, rng.uniform(165, 205)]])
        return cls(_painted(rng), edges)

    def outside(self, x: NDArray, y: NDArray) -> NDArray:
        """mm beyond the table's nearest edge at points of the table's plane; negative on the table."""
        return np.max([nx * x + ny * y - d for nx, ny, d in self.edges], axis=0)

    def below(self, whole: NDArray, layer: NDArray, pinhole: PinholeCamera, table: tuple[NDArray, NDArray]) -> NDArray:
        """The picture with the floor where the camera looks past the table.

        Parameters
        ----------
        whole
            (H, W, 4) layer: the table, as if it went on.
        layer
            The floor's picture as a layer in the camera's colours.
        pinhole
            The camera.
        table
            x and y (H, W) of the table's point at every pixel, mm.
        """
        beyond = self.outside(*table)
        seen = smoothstep(0, EDGE_MM, beyond)
        if not seen.any():
            return whole
        # A plane from a camera is a homography: floor pixel -> camera pixel.
        to_world = np.array([[PITCH_MM, 0, -HALF_MM], [0, PITCH_MM, -HALF_MM], [0, 0, -DEPTH_MM], [0, 0, 1]])
        matrix = pinhole.K @ np.column_stack([pinhole.R, pinhole.t]) @ to_world
        size = (whole.shape[1], whole.shape[0])
        under = cv2.warpPerspective(layer, matrix, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
        # The drape falls over the edge: towards it, less light meets it.
        shade = 1 - 0.5 * smoothstep(-SHADED_MM, 0, beyond)
        shaded = (whole - (16, 0, 0, 0)) * np.dstack([shade, np.ones((*shade.shape, 3), np.float32)]) + (16, 0, 0, 0)
        mixed = shaded + seen[..., None] * (under.astype(np.float32) - shaded)
        return np.clip(mixed + 0.5, 0, 255).astype(np.uint8)


def _painted(rng: np.random.Generator) -> NDArray:
    """Speckled linoleum with seams, a cable, spots and swabs that fell, the feet of a stand; out of focus and dim."""
    side = round(2 * HALF_MM / PITCH_MM)
    base = (bgr(0.42, 0.46, 0.44), bgr(0.30, 0.36, 0.42), bgr(0.50, 0.44, 0.36))[int(rng.integers(0, 3))]
    tone = 1 + 0.10 * clouds(rng, (side, side), 120 / PITCH_MM, 3) + 0.09 * waves(rng, (side, side), 9 / PITCH_MM)
    picture = base * tone[..., None].astype(np.float32)
    for axis in (0, 1):
        for at in np.arange(rng.uniform(0, 600), 2 * HALF_MM, 600):
            row = round(at / PITCH_MM)
            picture[(slice(None), slice(row, row + 2)) if axis else slice(row, row + 2)] *= 0.72
    lines = np.zeros((side, side), np.uint8)
    for _ in range(3):
        way = np.cumsum(rng.normal(0, 1, (24, 2)) + rng.normal(0, 1.2, 2), axis=0) * 60 / PITCH_MM + side / 2
        polyline(lines, way, 9 / PITCH_MM)
    picture *= 1 - 0.8 * (lines / np.float32(255))[..., None]
    for _ in range(30):
        at, turn = rng.uniform(0.3, 0.7, 2) * side, rng.uniform(0, 360)
        size = rng.uniform(30, 110, 2) / PITCH_MM
        colour = [(0.78, 0.80, 0.80), (0.12, 0.12, 0.13), (0.05, 0.04, 0.30), (0.5, 0.36, 0.2)][int(rng.integers(0, 4))]
        box = cv2.boxPoints((tuple(at), tuple(size), turn))
        cv2.fillConvexPoly(picture, np.rint(box).astype(np.int32), [float(c) for c in colour], cv2.LINE_AA)
    return to_uint8(0.75 * cv2.GaussianBlur(picture, (0, 0), 5 / PITCH_MM))
