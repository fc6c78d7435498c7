"""People over the table as sprites: gloved hands with instruments, sleeves, heads in caps, shoulders in gowns.

Each sprite lies on its own plane: a hand's origin is the tip of its instrument and its wrist lies at -x; a sleeve
begins at the wrist and leads to -x; a head faces +x from its origin. Lengths in mm, made by solids.py.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mcsl_core.simulation import tools

from .scenario import Scenario
from .solids import PLASTIC, STEEL, Clay, Material, Sprite, softened

GLOVES = {
    "white": (0.74, 0.80, 0.83),
    "blue": (0.74, 0.50, 0.40),
    "skin": (0.50, 0.62, 0.78),
    "green": (0.50, 0.58, 0.30),
    "tan": (0.47, 0.56, 0.66),
    "bare": (0.47, 0.58, 0.80),
}
GOWNS = {
    "green": (0.38, 0.46, 0.20),
    "blue": (0.55, 0.36, 0.17),
    "white": (0.55, 0.40, 0.22),
    "skin": (0.40, 0.53, 0.70),
    "brown": (0.24, 0.32, 0.44),
    "blown": (0.55, 0.40, 0.22),
}
GRIPS = 5
"""How many steps there are between a closed and an open grip."""
TIP_DROP_MM = 20.0
"""How far below the hand's middle an instrument's tip lies."""
CUFF = Material((0.72, 0.74, 0.74), ribs_mm=3.0, mottle=0.02)
REACH_MM = 200.0
"""From the wrist to the instrument's tip."""


def glove_material(scenario: Scenario) -> Material:
    """The gloves' rubber, or skin where there are none."""
    if scenario.gloves == "bare":
        return Material(GLOVES["bare"], gloss=0.08, rough_mm=0.22, rough_length_mm=5, mottle=0.06, soft_mm=1.2)
    return Material(
        GLOVES[scenario.gloves], gloss=0.3, hardness=26, rough_mm=0.28, rough_length_mm=15, mottle=0.02, soft_mm=1.7
    )


def gown_material(scenario: Scenario) -> Material:
    """The gowns' cloth."""
    colour = GOWNS[scenario.drape]
    return Material(colour, rough_mm=4.2, rough_length_mm=34, mottle=0.05, weave=0.06)


def hand(scenario: Scenario, worker: int, kind: int, grip: float, left: bool, pitch: float) -> Sprite:
    """A hand holding instrument ``kind`` as a pen or by its rings; ``grip`` 0 closed .. 1 open."""
    rng = scenario.stream("hand look", worker)
    side = -1.0 if left else 1.0
    clay = Clay(-REACH_MM - 60, -75, 8, 75, pitch)
    glove = glove_material(scenario)

    def at(points: list) -> list:
        """From hand coordinates (wrist at 0, thumb towards +y) to the sprite's plane."""
        return [(x - REACH_MM, side * y, z) for x, y, z in points]

    axis_end = np.array([58.0, 38.0, 46.0])
    turn = float(np.arctan2(side * (0 - axis_end[1] * 1.0), REACH_MM - axis_end[0]))
    tip = (0.0, 0.0, -TIP_DROP_MM)
    wide = 2.0 + 7.0 * grip
    if kind == 0:
        tools.forceps(clay, turn, tip, wide, 0.42)
    elif kind == 1:
        tools.ringed(clay, turn, tip, tools.Ringed(20, 172, 1.5 + 4 * grip, slope=0.12))
    else:
        tools.sucker(clay, turn, tip, PLASTIC)

    spread = 4.0 * grip
    melt = 9.0
    # Back of the hand first, then the fingers from the little one to the thumb, which lies uppermost.
    for end, radius in (((84, 26, 34), 12.5), ((89, 8, 37), 12.5), ((85, -11, 34), 12), ((76, -28, 27), 11)):
        clay.rod(at([(4, end[1] * 0.45, 22), end]), [19, radius], glove, 12)
    clay.rod(at([(20, 24, 22), (60, 34, 24)]), [16, 13], glove, 12)
    clay.rod(at([(76, -28, 27), (100, -30, 17), (108, -22, 6), (102, -15, 0)]), [11, 9.2, 8.2, 7.2], glove, melt)
    clay.rod(at([(85, -11, 34), (113, -13, 24), (124, -7, 8), (116, -2, 0)]), [12, 10, 9, 7.8], glove, melt)
    clay.rod(at([(89, 8, 37), (120, 5, 31), (138, 7, 12), (143, 9, 2)]), [12.5, 10.3, 9.2, 7.6], glove, melt)
    bow = 3 * grip
    clay.rod(at([(84, 26, 34), (114, 27 + bow, 39), (138, 19 + bow, 25), (152, 13 + spread * 0.3, 9)]),
             [12.5, 10.5, 9.2, 7.4], glove, melt)  # fmt: skip
    clay.rod(at([(38, 36, 22), (74, 50 + spread, 24), (108, 42 + spread, 20), (136, 22 + spread, 9)]),
             [15, 12.5, 11, 8.6], glove, melt)  # fmt: skip
    wrist(clay, at, glove, bare=scenario.gloves == "bare")
    stain = (-60.0 + rng.normal(0, 8), side * rng.uniform(5, 15), rng.uniform(25, 55))
    return clay.bake(rng, stain)


def wrist(clay: Clay, at: Callable[[list], list], glove: Material, *, bare: bool) -> None:
    """A wrist in the glove's cuff with its rolled rim, or the wrist itself."""
    if bare:
        clay.rod(at([(10, 0, 20), (-20, 0, 20), (-60, 0, 20)]), [25, 23, 25], glove, 10)
        return
    clay.rod(at([(6, 0, 20), (-14, 0, 20)]), [27, 29], glove, 10)
    clay.rod(at([(-14, 0, 20), (-34, 0, 20)]), [29.5, 31], glove, 6)
    rim = [(-35, y, 20 + np.sqrt(max(31.5**2 - y * y, 0))) for y in np.linspace(-31, 31, 15)]
    clay.rod(at(rim), 1.6, glove, 1)


def holding_hand(scenario: Scenario, pitch: float) -> Sprite:
    """A fist around the lamp's handle; its origin is the handle."""
    rng = scenario.stream("fist")
    clay = Clay(-170, -70, 60, 70, pitch)
    glove = glove_material(scenario)
    for n, y in enumerate((-26, -9, 9, 26)):
        clay.rod([(-70, y * 0.9, 25), (-22, y, 36), (14, y, 26), (24, y, 8)],
                 [14, 12.5, 11 - n * 0.4, 9], glove, 8)  # fmt: skip
    clay.rod([(-120, 0, 20), (-66, 0, 22)], [28, 34], glove, 14)
    clay.rod([(-70, 36, 18), (-20, 46, 20), (14, 34, 22)], [15, 13, 10], glove, 8)
    clay.rod([(-150, 0, 20), (-120, 0, 20)], [31, 29], glove, 8)
    return softened(clay.bake(rng), 1.2)


def sleeve(scenario: Scenario, worker: int, pitch: float, length: float = 420.0) -> Sprite:
    """A forearm in its gown, from the knitted cuff at the wrist up to the elbow and beyond."""
    rng = scenario.stream("sleeve", worker)
    clay = Clay(-length, -75, 45, 75, pitch)
    if scenario.gloves == "bare":
        clay.rod([(40, 0, 10), (-60, 0, 10), (-190, 2, 10)], [23, 27, 38], glove_material(scenario), 6)
        clay.rod([(-170, 0, 12), (-230, 4, 12), (-length + 60, 0, 12)], [52, 55, 58], gown_material(scenario), 3)
        return clay.bake(rng)
    clay.rod([(40, 0, 10), (-18, 0, 10)], [27, 31], CUFF, 4)
    stations = np.linspace(-14, -length + 60, 14)
    points = [(x, rng.normal(0, 2.5), 10 + rng.normal(0, 1.5)) for x in stations]
    radii = [34 + 22 * (n / 13) ** 0.8 + rng.normal(0, 1.6) for n in range(14)]
    clay.rod(points, radii, gown_material(scenario), 16)
    return clay.bake(rng)


def head(scenario: Scenario, person: int, pitch: float) -> Sprite:
    """From above: cap, forehead, the mask's bulge and, on some, loupes or a head light."""
    rng = scenario.stream("head look", person)
    clay = Clay(-125, -110, 150, 110, pitch)
    cap_colour = [(0.55, 0.42, 0.22), (0.42, 0.48, 0.22), (0.62, 0.55, 0.42), (0.60, 0.35, 0.30)][
        int(rng.integers(0, 4))
    ]
    cap = Material(cap_colour, rough_mm=2.6, rough_length_mm=24, mottle=0.05, weave=0.05)
    face = Material(((0.45, 0.56, 0.76), (0.30, 0.42, 0.62), (0.14, 0.20, 0.34))[int(rng.integers(0, 3))], gloss=0.1)
    mask = Material((0.70, 0.62, 0.45), rough_mm=1.4, rough_length_mm=16, mottle=0.03)
    hair = Material((0.07, 0.08, 0.11), rough_mm=1.2, rough_length_mm=4, mottle=0.2)
    clay.ball((12, 0, -30), (92, 72, 55), face, 10)
    clay.ball((70, 0, -42), (44, 44, 34), mask, 6)
    clay.ball((84, 0, -26), (15, 11, 16), mask, 12)
    for side in (-1, 1):
        clay.ball((-2, side * 74, -46), (17, 9, 18), face, 4)
        clay.rod([(60, side * 44, -32), (5, side * 71, -34)], 1.4, Material((0.8, 0.8, 0.8)))
    clay.ball((-58, 0, -42), (46, 52, 40), hair, 6)
    clay.ball((-12, 0, -22), (96, 77, 66), cap, 14)
    clay.ball((-44, rng.normal(0, 5), -16), (58, 62, 50), cap, 26)
    band = [(62 * np.cos(a) + 4, 74 * np.sin(a), -14 - 6 * np.cos(a)) for a in np.linspace(-1.5, 1.5, 25)]
    clay.rod(band, 4.5, cap, 6)
    if rng.random() < 0.7:
        dark = Material((0.08, 0.08, 0.08), gloss=0.5, hardness=40)
        for side in (-1, 1):
            clay.rod([(72, side * 26, -16), (108, side * 22, -30)], [12, 10], dark)
            clay.rod([(108, side * 22, -30), (111, side * 22, -31)], 10.5, STEEL)
            clay.rod([(74, side * 34, -14), (18, side * 78, -26)], 2.2, dark)
        clay.rod([(76, -20, -12), (78, 20, -12)], 3.5, dark)
    if rng.random() < 0.4:
        lamp = Material((0.12, 0.12, 0.12), gloss=0.4)
        clay.rod([(70, 0, 8), (92, 0, 4)], [11, 9], lamp)
        clay.rod([(60, 0, 16), (0, 0, 46), (-70, 0, 38)], 6, lamp)
    return softened(clay.bake(rng), 1.3)


def shoulders(scenario: Scenario, person: int, pitch: float) -> Sprite:
    """A gown from above, facing +x; the neck is at the origin, the back leads away from the table."""
    rng = scenario.stream("shoulders", person)
    blue, green, red = GOWNS[scenario.drape]
    clay = Clay(-330, -270, 120, 270, pitch)
    gown = Material(GOWNS[scenario.drape], rough_mm=9, rough_length_mm=70, mottle=0.05, weave=0.03)
    tie = Material((0.8 * blue, 0.8 * green, 0.8 * red), rough_mm=1.0, rough_length_mm=9)
    clay.rod([(-200, 0, -60), (-330, 0, -140)], [150, 160], gown, 40)
    clay.rod([(-60, -150, -40), (-70, 0, 0), (-60, 150, -40)], [66, 92, 66], gown, 40)
    for side in (-1, 1):
        seam = [(-125, side * 60, 30), (-60, side * 118, 34), (8, side * 120, 6)]
        clay.rod(seam, 1.8, tie, 2)
    collar = [(-12 + 50 * np.cos(a), 56 * np.sin(a), 84) for a in np.linspace(0.9, 5.4, 20)]
    clay.rod(collar, 7, gown, 10)
    clay.rod([(-70, 0, 90), (-130, 4, 82), (-250, -6, 40)], 2.2, tie, 2)
    clay.rod([(-92, -14, 90), (-86, 0, 96), (-94, 16, 90)], 3.2, tie, 2)
    return softened(clay.bake(rng), 1.6)
