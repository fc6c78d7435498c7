"""Instruments, as clay: each points along +x with its tip at the origin, lengths in mm."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import ArrayLike

from .solids import STEEL, Clay, Material


@attrs.frozen
class Ringed:
    """An instrument of two arms that cross at a joint, with finger rings: needle holder, clamp or scissors.

    Attributes
    ----------
    jaw_mm
        Length of the jaws.
    length_mm
        From tip to rings.
    open_deg
        Angle between the jaws.
    slope
        Rise per mm along the instrument.
    curve
        How far the jaws are bent sideways, as a share of their length.
    """

    jaw_mm: float
    length_mm: float = 165.0
    open_deg: float = 8.0
    slope: float = 0.15
    curve: float = 0.0


def forceps(clay: Clay, turn: float, at: tuple, open_mm: float = 4.0, slope: float = 0.25) -> None:
    """Two springy blades joined at the far end, 140 long."""
    for side in (-1, 1):
        blade = [
            (0, side * open_mm / 2, 0),
            (-28, side * (2.0 + open_mm * 0.4), 28 * slope),
            (-62, side * 5.5, 62 * slope),
            (-100, side * 3.6, 100 * slope),
            (-140, side * 0.6, 140 * slope),
        ]
        clay.rod(placed(blade, turn, at), [0.8, 1.4, 2.6, 2.6, 3.0], STEEL)
        for x in range(-76, -48, 3):
            clay.rod(
                placed([(x, side * 4.2, -x * slope + 1.7), (x, side * 6.4, -x * slope + 1.7)], turn, at), 0.8, STEEL
            )


def ringed(clay: Clay, turn: float, at: tuple, tool: Ringed) -> None:
    """Needle holder, clamp or scissors: two arms that cross at a joint, with finger rings."""
    jaw, length, slope = tool.jaw_mm, tool.length_mm, tool.slope
    half = np.deg2rad(tool.open_deg) / 2
    for side in (-1, 1):
        ts = np.linspace(0, 1, 7)
        jaw_points = [
            (
                -jaw * u,
                side * (np.tan(half) * jaw * (1 - u) + 0.9 * u) + tool.curve * (1 - u) ** 2 * jaw,
                slope * jaw * u,
            )
            for u in ts
        ]
        clay.rod(placed(jaw_points, turn, at), list(0.9 + 1.7 * ts), STEEL)
        spread = np.tan(half) * (length - jaw) + 5
        arm = [
            (-jaw, -side * 1.2, slope * jaw),
            (-jaw - 18, -side * 3.6, slope * (jaw + 18)),
            (-length * 0.5, -side * (4.2 + 0.42 * spread), slope * length * 0.5),
            (-length * 0.75, -side * (4 + 0.85 * spread), slope * length * 0.75),
            (-length + 18, -side * (3 + spread), slope * (length - 18)),
        ]
        clay.rod(placed(arm, turn, at), [3.0, 2.5, 2.1, 2.0, 2.2], STEEL)
        ring = _ring((-length + 6, -side * (9 + spread), slope * length), 9.5)
        clay.rod(placed(ring, turn, at), 2.0, STEEL)
    joint = placed([(-jaw, 0, slope * jaw + 1.2), (-jaw - 0.1, 0, slope * jaw + 1.2)], turn, at)
    clay.rod(joint, 3.8, STEEL)


def hook(clay: Clay, turn: float, at: tuple, length: float = 190.0, blade: float = 22.0) -> None:
    """A hand-held retractor: a bent blade on a long flat handle."""
    for side in np.linspace(-1, 1, 5):
        clay.rod(
            placed([(0, side * blade / 2, -4), (-10, side * blade / 2.2, 5), (-26, side * 5, 8)], turn, at), 2.4, STEEL
        )
    clay.rod(placed([(-22, 0, 8), (-length * 0.55, 0, 16), (-length, 0, 30)], turn, at), [4.5, 4.0, 6.0], STEEL)


def sucker(clay: Clay, turn: float, at: tuple, material: Material) -> None:
    """A suction tip: a thin bent tube that grows into a handle."""
    tube = [(0, 0, 0), (-45, 3, 8), (-95, 3, 22), (-150, 0, 40)]
    clay.rod(placed(tube, turn, at), [2.2, 2.6, 3.4, 6.0], STEEL)
    clay.rod(placed([(-118, 2, 30), (-190, 0, 50)], turn, at), [5.5, 7.5], material)


def placed(points: ArrayLike, turn: float = 0.0, at: tuple[float, float, float] = (0, 0, 0)) -> np.ndarray:
    """Points turned in the plane (radians) and moved."""
    c, s = np.cos(turn), np.sin(turn)
    turned = np.asarray(points, float) @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    return turned + np.asarray(at, float)


def _ring(centre: tuple[float, float, float], radius: float) -> list:
    angles = np.linspace(0, 2 * np.pi, 25)
    return [(centre[0] + 1.25 * radius * np.cos(a), centre[1] + radius * np.sin(a), centre[2]) for a in angles]
