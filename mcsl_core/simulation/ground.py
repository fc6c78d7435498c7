"""The ground: one lit colour map of everything on the table that lies still, and the field's states over time.

Maps are BGR uint8 over the square of surface.py, but finer; the field's states are cut-outs in its middle.
"""

from __future__ import annotations

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from .drapes import paint_drapes
from .paint import lambert, mix, normals, shine, to_uint8
from .photograph import cloth_detail, tissue_detail
from .props import gauze_in_field, litter
from .rig import CAMERA_CIRCLE_MM, LAMP_HEIGHT_MM, Rig
from .scenario import Scenario
from .straps import straps
from .surface import HALF_MM, Grid, Surface, sample
from .tissue import Tissue, paint_tissue

FIELD_HALF_MM = 135.0
"""The field's cut-out reaches this far from the middle."""


@attrs.frozen(eq=False)
class Ground:
    """What lies still.

    Attributes
    ----------
    scenario, surface
        What it is made of.
    pitch_mm
        From one sample of the map to the next.
    base
        (H, W, 3) uint8: the whole map, the field in it as it was painted, without blood.
    cut
        Rows and columns of the field's states in the map.
    cloth
        (h, w, 3) float: lit drapes in the cut-out.
    layer
        (h, w, 4) float: what lies on top in the cut-out, BGR and, fourth, how much of the field shines through.
    tissue
        The field before light falls on it.
    light, normal
        (h, w) brightness and (h, w, 3) unit normals in the cut-out.
    glints
        Per camera (h, w): how strongly a wet point would mirror the lamp into it.
    """

    scenario: Scenario
    surface: Surface
    pitch_mm: float
    base: NDArray
    cut: tuple[slice, slice]
    cloth: NDArray
    layer: NDArray
    tissue: Tissue
    light: NDArray
    normal: NDArray
    glints: tuple[NDArray, ...]

    @classmethod
    def of(cls, scenario: Scenario, surface: Surface, rig: Rig) -> Ground:
        """The ground of a scenario."""
        # As fine as the pictures, within reason: half a millimetre where a picture is 960 wide.
        pitch = float(np.clip(480.0 / scenario.size[0], 0.3, 1.0))
        pitch = HALF_MM / round(HALF_MM / pitch)
        grid = Grid.of_table(pitch)
        coarse = sample(surface.height_mm, grid.x, grid.y)
        colour, bump = paint_drapes(scenario, surface.site, grid)
        reach = round(FIELD_HALF_MM / pitch)
        middle = round(HALF_MM / pitch)
        span = slice(middle - reach, middle + reach + 1)
        cut = (span, span)
        tissue = paint_tissue(scenario, surface.site, grid.part(cut))
        traits = scenario.traits
        if traits.photograph:
            colour *= cloth_detail(scenario, pitch, colour.shape)
            detailed = tissue.colour * tissue_detail(scenario, pitch, tissue.colour.shape)
            tissue = attrs.evolve(tissue, colour=detailed)
        if traits.smooth:
            colour, bump, tissue = smoothed(traits.smooth, pitch, colour, bump, tissue)
        bump[cut] = bump[cut] * (1 - tissue.opening) + tissue.bump_mm * tissue.opening
        normal = normals(coarse + bump, pitch)
        light = lighting(coarse, normal, grid)
        colour *= light[..., None]
        layer = np.zeros((*grid.x.shape, 4), np.float32)
        layer[..., 3] = 1
        if not traits.plain:
            litter(scenario, surface.site, layer, pitch)
        if traits.straps:
            straps(scenario, surface.site, layer, pitch)
        base = to_uint8(colour * layer[..., 3:] + layer[..., :3])
        glints = tuple(glint(normal[cut], azimuth) for azimuth in rig.azimuth_deg)
        return cls(
            scenario, surface, pitch, base, cut, colour[cut].copy(), layer[cut].copy(), tissue,
            light[cut].copy(), normal[cut].copy(), glints,
        )  # fmt: skip

    def state(self, stage: int, camera: int) -> NDArray:
        """The field's cut-out (BGR uint8) after ``stage`` steps of the operation, as it glistens to ``camera``."""
        rng = self.scenario.stream("blood", stage)
        # It bleeds, is wiped, and bleeds again.
        level = 1.5 - 0.2 * (stage % 3) + rng.uniform(-0.1, 0.1)
        colour, wet = self.tissue.with_blood(level, self.scenario.stream("specks", stage // 3))
        lit = colour * self.light[..., None] + (0.62 * wet * self.glints[camera])[..., None]
        gauze_in_field(self.scenario, lit, self.surface.site, self.pitch_mm, -FIELD_HALF_MM)
        lit = mix(self.cloth, lit, self.tissue.opening)
        return to_uint8(lit * self.layer[..., 3:] + self.layer[..., :3])


def smoothed(
    share: float, pitch: float, colour: NDArray, bump: NDArray, tissue: Tissue
) -> tuple[NDArray, NDArray, Tissue]:
    """Colour and fine relief of cloth, and the tissue, with that share of the texture of cloth and skin gone."""
    sigma = 5 / pitch
    cloth = mix(colour, cv2.GaussianBlur(colour, (0, 0), sigma), share)
    plain = cv2.GaussianBlur(tissue.colour, (0, 0), sigma)
    # What is wet, the wound, keeps its own.
    skin = share * (1 - np.clip((cv2.GaussianBlur(tissue.wet, (0, 0), 1.5 / pitch) - 0.4) / 0.3, 0, 1))
    calm = tissue.bump_mm + skin * (cv2.GaussianBlur(tissue.bump_mm, (0, 0), sigma) - tissue.bump_mm)
    return (
        cloth,
        bump + share * (cv2.GaussianBlur(bump, (0, 0), sigma) - bump),
        attrs.evolve(tissue, colour=mix(tissue.colour, plain, skin), bump_mm=calm.astype(np.float32)),
    )


def lighting(height: NDArray, normal: NDArray, grid: Grid) -> NDArray:
    """(h, w) brightness of a white thing: a wide lamp from above, brightest in the middle, hollows darker."""
    diffuse = 0.62 * lambert(normal, (0.0, 0.0, 1.0)) + 0.33 * lambert(normal, (0.55, 0.4, 0.75))
    diffuse += 0.12 * lambert(normal, (-0.8, 0.1, 0.5))
    shrink = grid.pitch_mm / 1.5
    small = cv2.resize(height, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
    near, far = cv2.GaussianBlur(small, (0, 0), 5 / 1.5), cv2.GaussianBlur(small, (0, 0), 16 / 1.5)
    hollow = np.clip((small - near) / 8, -0.3, 0.15) + np.clip((small - far) / 40, -0.28, 0.15)
    hollow = cv2.resize(hollow, (height.shape[1], height.shape[0]), interpolation=cv2.INTER_LINEAR)
    spot = 0.46 + 0.66 * np.exp(-(grid.x * grid.x + grid.y * grid.y) / (2 * 190.0**2))
    return (diffuse * (1 + hollow) * spot).astype(np.float32)


def glint(normal: NDArray, azimuth_deg: float) -> NDArray:
    """(h, w): the lamp's modules mirrored towards the camera at that azimuth by a wet surface."""
    azimuth = np.deg2rad(azimuth_deg)
    lens = np.array([CAMERA_CIRCLE_MM * np.cos(azimuth), CAMERA_CIRCLE_MM * np.sin(azimuth), LAMP_HEIGHT_MM])
    lens /= np.linalg.norm(lens)
    total = np.zeros(normal.shape[:2], np.float32)
    for turn, share in ((0.0, 0.7), (1.9, 0.6), (-1.9, 0.6), (3.1, 0.5)):
        lamp = np.array([260 * np.cos(azimuth + turn), 260 * np.sin(azimuth + turn), LAMP_HEIGHT_MM])
        total += share * shine(normal, lens + lamp / np.linalg.norm(lamp), 130)
    return np.minimum(total, 1.3)
