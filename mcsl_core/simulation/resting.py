"""Hands that rest: over one place, at one height, for minutes, as an assistant's do at every operation.

At a steady height such a hand has the same parallax at every moment: it agrees with itself in all cameras as the
patient does, and only that it came and will go tells them apart. What lies below it is hidden.
"""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from mcsl_core.simulation import actors, tools

from .scenario import Scenario
from .schedule import Track, make_track, sway
from .solids import Clay, Sprite
from .surface import Site

THICK_MM = 26.0
"""From what a hand lies on to the plane of its sprite."""


@attrs.frozen(eq=False)
class RestingHand:
    """A hand that rests.

    Attributes
    ----------
    azimuth_deg
        From which side its arm comes.
    tip
        x, y and lift above the surface of its fingertips or of the retractor's blade, mm.
    phase
        (3,), of its tremor.
    holds
        Whether it holds a retractor.
    """

    azimuth_deg: float
    tip: Track
    phase: NDArray
    holds: bool

    def tip_at(self, t: float) -> NDArray:
        """(3,): x, y and lift, mm. A hand that is held up trembles by a tenth of what a working one does."""
        return self.tip.at(t) + sway(2.0 * t, self.phase, 0.15)


def resting_hands(scenario: Scenario, site: Site) -> tuple[RestingHand, ...]:
    """Each lies at the wound's edge for one to four minutes, is away for some seconds and comes to rest elsewhere."""
    found = []
    turn = np.deg2rad(site.axis_deg)
    along, across = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    side_by_chance = scenario.stream("resting").choice((-1.0, 1.0))
    for n in range(scenario.traits.resting):
        rng = scenario.stream("resting hand", n)
        # They come from both sides of the table, across the incision, where those who assist stand.
        side = side_by_chance * (1 if n % 2 else -1)
        outward = side * across + rng.uniform(-0.5, 0.5) * along
        outward /= np.linalg.norm(outward)
        holds = n % 2 == 1

        def place(rng=rng, outward=outward, side=side, holds=holds) -> NDArray:
            at = rng.uniform(-0.55, 0.55) * site.wound_mm[0] * along
            far = 0.75 * site.wound_mm[1] if holds else rng.uniform(-0.2, 0.5) * site.wound_mm[1]
            return np.array([*(at + side * far * across), -3.0 if holds else 0.0])

        keys, t = [], rng.uniform(40, 180) if scenario.duration_s > 45 else rng.uniform(0.5, 1.5) * scenario.duration_s
        while t < scenario.duration_s + 5:
            keys.append((t, t + 1.0, np.array([*(outward * 330), 70.0])))
            t += 1.0 + rng.uniform(3, 9)
            keys.append((t, t + 1.2, place()))
            t += 1.2 + rng.uniform(60, 240)
        azimuth = float(np.rad2deg(np.arctan2(outward[1], outward[0])))
        found.append(RestingHand(azimuth, make_track(keys, place()), rng.uniform(0, 6.28, 3), holds))
    return tuple(found)


def lying_hand(scenario: Scenario, n: int, pitch: float) -> Sprite:
    """A hand laid flat; its origin is the middle finger's tip, its wrist lies at -x."""
    rng = scenario.stream("lying hand", n)
    glove, side = actors.glove_material(scenario), float(rng.choice((-1, 1)))
    clay = Clay(-actors.REACH_MM - 60, -85, 12, 85, pitch)

    def at(points: list) -> list:
        """From hand coordinates (wrist at 0, thumb towards +y, fingertips at 182) to the sprite's plane."""
        return [(x - 182, side * y, z) for x, y, z in points]

    knuckles = ((88, 27, 26), (93, 9, 28), (90, -9, 27), (82, -26, 23))
    for x, y, z in knuckles:
        clay.rod(at([(4, y * 0.5, 18), (x, y, z)]), [18, 13], glove, 12)
    spread = rng.uniform(0.9, 1.25)
    for (x, y, z), long, radius in zip(knuckles, (74, 84, 76, 58), (9.6, 10, 9.4, 8.2), strict=True):
        bent = rng.uniform(-2, 2)
        joints = [(x, y, z), (x + 0.45 * long, y * spread + bent, z + 1), (x + long, y * spread * 1.12 + bent, z - 13)]
        clay.rod(at(joints), [12.5, radius, radius * 0.78], glove, 7)
    clay.rod(at([(22, 30, 18), (56, 50, 20), (84, 62, 14), (104, 64, 10)]), [17, 14, 11, 8.5], glove, 9)
    actors.wrist(clay, at, glove, bare=scenario.gloves == "bare")
    return clay.bake(rng, (-30.0 + rng.normal(0, 12), side * rng.uniform(-20, 20), rng.uniform(15, 40)))


def hand_with_retractor(scenario: Scenario, n: int, pitch: float) -> Sprite:
    """A fist around a retractor's handle; the origin is the blade's tip, the wrist lies at -x."""
    rng = scenario.stream("retracting hand", n)
    glove, side = actors.glove_material(scenario), float(rng.choice((-1, 1)))
    clay = Clay(-actors.REACH_MM - 90, -75, 14, 75, pitch)
    tools.hook(clay, 0, (0, 0, -14), blade=rng.uniform(20, 28))

    def at(points: list) -> list:
        """From hand coordinates (wrist at 0, thumb towards +y) to the sprite's plane."""
        return [(x - actors.REACH_MM - 20, side * y, z) for x, y, z in points]

    clay.rod(at([(4, 0, 18), (62, 6, 24)]), [24, 30], glove, 12)
    for n_finger, x in enumerate((104, 86, 68, 52)):
        curl = [(x - 22, 26, 26), (x, 20, 36), (x + 5, -2, 38), (x + 2, -20, 28)]
        clay.rod(at(curl), [13, 12.4 - 0.4 * n_finger, 11.5, 9], glove, 6)
    clay.rod(at([(30, 28, 20), (76, 36, 26), (112, 24, 30), (128, 12, 28)]), [16, 13, 11, 8.5], glove, 8)
    actors.wrist(clay, at, glove, bare=scenario.gloves == "bare")
    return clay.bake(rng, (-110.0, side * 10.0, rng.uniform(15, 40)))
