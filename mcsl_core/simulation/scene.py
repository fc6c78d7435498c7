"""The scene: everything that is filmed, and at each time every sprite with its plane, in the order of drawing.

A placement puts a sprite's plane at ``origin`` (mm) with the plane's x and y along ``ahead`` and ``aside``.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Literal

import attrs
import numpy as np
from numpy.typing import NDArray

from mcsl_core.simulation import actors

from .resting import THICK_MM, RestingHand, hand_with_retractor, lying_hand, resting_hands
from .rig import LampPose, Rig, cross, unit
from .scenario import Scenario
from .schedule import LampPath, Person, Progression, Worker, ease, lamp_path, people, sway, workers
from .solids import Sprite
from .surface import Surface

UP = np.array([0.0, 0.0, 1.0])
HANDLE_BELOW_LAMP_MM = 190.0


@attrs.frozen(eq=False)
class Placement:
    """A sprite and its plane in the world.

    Attributes
    ----------
    sprite
        What is drawn.
    origin
        (3,) of the plane, mm.
    ahead, aside
        (3,) unit vectors of the plane's x and y.
    kind
        Sleeves and hands at work are drawn below everything else (heads, shoulders, arms that reach for the lamp).
    ground_z
        Height of the surface below a sleeve or hand, which shades it.
    facing
        Whether it is round, and turned towards each camera.
    """

    sprite: Sprite
    origin: NDArray
    ahead: NDArray
    aside: NDArray
    kind: Literal["sleeve", "hand", "head"]
    ground_z: float = 0.0
    facing: bool = False


@attrs.frozen(eq=False)
class Cast:
    """All sprites: of each worker a hand at every grip and a sleeve, of each person head and shoulders.

    ``sleeves`` are the workers' and then the resting hands'.
    """

    hands: tuple[tuple[Sprite, ...], ...]
    sleeves: tuple[Sprite, ...]
    resting: tuple[Sprite, ...]
    heads: tuple[Sprite, ...]
    shoulders: tuple[Sprite, ...]
    fist: Sprite
    arm: Sprite

    @classmethod
    def of(cls, scenario: Scenario, crew: tuple[Worker, ...], resting: tuple[RestingHand, ...] = ()) -> Cast:
        """Models them, two at once."""
        # Half a millimetre where a picture is 960 wide; finer would not show on a moving hand and takes too long.
        fine = float(np.clip(480.0 / scenario.size[0], 0.36, 1.5))
        grips = np.linspace(0, 1, actors.GRIPS)
        people = range(scenario.heads)
        with ThreadPoolExecutor(2) as pool:
            hands = [
                [pool.submit(actors.hand, scenario, n, w.kind, float(g), w.left, fine) for g in grips]
                for n, w in enumerate(crew)
            ]
            sleeves = [pool.submit(actors.sleeve, scenario, n, 1.6 * fine) for n in range(len(crew) + len(resting))]
            rests = [
                pool.submit(hand_with_retractor if hand.holds else lying_hand, scenario, n, fine)
                for n, hand in enumerate(resting)
            ]
            heads = [pool.submit(actors.head, scenario, n, 1.2 * fine) for n in people]
            shoulders = [pool.submit(actors.shoulders, scenario, n, 2.4 * fine) for n in people]
            fist = pool.submit(actors.holding_hand, scenario, 1.2 * fine)
            arm = pool.submit(actors.sleeve, scenario, 99, 1.6 * fine, 520.0)
        return cls(
            tuple(tuple(job.result() for job in jobs) for jobs in hands),
            tuple(job.result() for job in sleeves),
            tuple(job.result() for job in rests),
            tuple(job.result() for job in heads),
            tuple(job.result() for job in shoulders),
            fist.result(),
            arm.result(),
        )


@attrs.frozen(eq=False)
class Scene:
    """The whole operation: the surface, the rig, the people, and what happens when."""

    scenario: Scenario
    surface: Surface
    rig: Rig
    path: LampPath
    persons: tuple[Person, ...]
    crew: tuple[Worker, ...]
    resting: tuple[RestingHand, ...]
    cast: Cast
    progression: Progression

    @classmethod
    def of(cls, scenario: Scenario) -> Scene:
        """The scene of a scenario."""
        surface = Surface.of(scenario)
        rig = Rig.of(scenario)
        path = lamp_path(scenario)
        persons = people(scenario, rig, path)
        crew = workers(scenario, persons, surface.site.wound_mm, surface.site.axis_deg)
        resting = resting_hands(scenario, surface.site)
        cast = Cast.of(scenario, crew, resting)
        return cls(scenario, surface, rig, path, persons, crew, resting, cast, Progression(path.movements))

    def placements(self, t: float) -> Iterator[Placement]:
        """Every sprite at programme time ``t``, the lowest first."""
        for n, hand in enumerate(self.resting):
            yield from self._resting_hand(n, hand, t)
        for n, worker in enumerate(self.crew):
            yield from self._working_hand(n, worker, t)
        for n, person in enumerate(self.persons):
            at = person.head_at(t)
            inward = -person.outward
            yield Placement(self.cast.shoulders[n], at - 165 * inward - 190 * UP, inward, cross(UP, inward), "head")
        for n, person in enumerate(self.persons):
            yield Placement(
                self.cast.heads[n], person.head_at(t), -person.outward, cross(UP, -person.outward), "head", facing=True
            )
        yield from self._reaching_arm(t)

    def _working_hand(self, n: int, worker: Worker, t: float) -> Iterator[Placement]:
        x, y, lift = worker.tip_at(t)
        ground = float(self.surface.height_at(np.array([x]), np.array([y]))[0])
        tip = np.array([x, y, ground + 1.0 + max(lift, 0.0)])
        azimuth = np.deg2rad(worker.azimuth_deg)
        elbow = np.array([470 * np.cos(azimuth), 470 * np.sin(azimuth), 210.0])
        ahead = unit(np.array([*(tip - elbow)[:2], 0.0]))
        sloping = unit(ahead - np.array([0, 0, 0.24]))
        grips = self.cast.hands[n]
        step = round(float(worker.grip.at(t)[0]) * (len(grips) - 1))
        wrist = tip - (actors.REACH_MM - 6) * sloping
        forearm = unit(wrist - elbow)
        yield Placement(self.cast.sleeves[n], wrist, forearm, unit(cross(UP, forearm)), "sleeve", ground)
        yield Placement(grips[step], tip, sloping, cross(UP, ahead), "hand", ground)

    def _resting_hand(self, n: int, hand: RestingHand, t: float) -> Iterator[Placement]:
        x, y, lift = hand.tip_at(t)
        ground = float(self.surface.height_at(np.array([x]), np.array([y]))[0])
        tip = np.array([x, y, ground + lift + (0 if hand.holds else THICK_MM)])
        azimuth = np.deg2rad(hand.azimuth_deg)
        elbow = np.array([480 * np.cos(azimuth), 480 * np.sin(azimuth), 190.0])
        ahead = unit(np.array([*(tip - elbow)[:2], 0.0]))
        # A hand lies flat; a retractor's handle rises outwards, over the drapes.
        along = unit(ahead - (0.22 if hand.holds else 0.06) * UP)
        wrist = tip - (actors.REACH_MM + 12) * along
        forearm = unit(wrist - elbow)
        sleeve = self.cast.sleeves[len(self.crew) + n]
        yield Placement(sleeve, wrist, forearm, unit(cross(UP, forearm)), "sleeve", ground)
        yield Placement(self.cast.resting[n], tip, along, cross(UP, ahead), "hand", ground)

    def _reaching_arm(self, t: float) -> Iterator[Placement]:
        """Somebody takes the lamp's handle a little before a movement and lets go a little after it."""
        for n, (start, stop) in enumerate(self.path.movements):
            if not start - 1.4 < t < stop + 1.3:
                continue
            rng = self.scenario.stream("reach", n)
            azimuth = rng.uniform(0, 2 * np.pi)
            outward = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
            held = ease((t - start + 1.4) / 1.2) * ease((stop + 1.3 - t) / 1.1)
            pose, _ = self.path.pose(t)
            shoulder = outward * 520 + 360 * UP
            hand = shoulder * 0.85 + held * (handle(pose) - shoulder * 0.85) + sway(t, rng.uniform(0, 6, 3), 3)
            forearm = unit(hand - shoulder)
            level = unit(forearm * (1, 1, 0))
            yield Placement(self.cast.arm, hand - 130 * forearm, forearm, unit(cross(UP, forearm)), "head")
            yield Placement(self.cast.fist, hand, unit(level + 0.5 * forearm), cross(UP, level), "head")


def handle(pose: LampPose) -> NDArray:
    """(3,) mm: the sterile handle below the lamp's middle."""
    return pose.centre_mm - HANDLE_BELOW_LAMP_MM * pose.axes[:, 2]
