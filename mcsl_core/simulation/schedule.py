"""The schedule, in programme seconds: lamp movements, heads that lean in, hands that work, a field that bleeds.

Everything here is a plain function of time, so that each camera can ask at its own instants.
"""

from __future__ import annotations

from bisect import bisect_right

import attrs
import numpy as np
from numpy.typing import NDArray

from .rig import LampPose, Rig
from .scenario import Scenario

HEAD_HEIGHT_MM = 500.0


def ease(u: float) -> float:
    """0 to 1 with no speed at either end."""
    u = min(max(u, 0.0), 1.0)
    return u * u * (3 - 2 * u)


@attrs.frozen(eq=False)
class LampPath:
    """The lamp over time.

    Attributes
    ----------
    poses
        ``poses[i]`` holds until movement i, then ``poses[i + 1]``.
    movements
        (last instant at rest, first instant at rest again) of each movement.
    """

    poses: tuple[LampPose, ...]
    movements: tuple[tuple[float, float], ...]

    def pose(self, t: float) -> tuple[LampPose, int | None]:
        """The lamp's pose at ``t`` and which still pose that is, or None while it moves."""
        done = bisect_right([stop for _, stop in self.movements], t)
        if done == len(self.movements) or t <= self.movements[done][0]:
            return self.poses[done], done
        start, stop = self.movements[done]
        return self.poses[done].towards(self.poses[done + 1], ease((t - start) / (stop - start))), None

    def nearest(self, t: float) -> LampPose:
        """The still pose at ``t``; of a movement, the one it leads to."""
        return self.poses[bisect_right([start for start, _ in self.movements], t)]


def movement_frames(scenario: Scenario) -> tuple[tuple[int, int], ...]:
    """[first frame with any motion, first frame standing still again) of every movement."""
    rate = float(scenario.rate)
    if not isinstance(scenario.movements, int):
        return tuple(
            (max(1, round(start * rate)), min(scenario.frames, max(1, round((start + length) * rate))))
            for start, length in sorted(scenario.movements)
        )
    rng = scenario.stream("movements")
    found = []
    for n in range(scenario.movements):
        slot = scenario.duration_s / scenario.movements
        length = rng.uniform(1.0, min(6.0, slot * 0.4))
        start = slot * n + rng.uniform(0.25 * slot, 0.8 * slot - length)
        found.append((round(start * rate), round((start + length) * rate)))
    return tuple(found)


def lamp_path(scenario: Scenario) -> LampPath:
    """The lamp's path through a scenario."""
    rng = scenario.stream("lamp")
    # A camera between two frames of the reference must not move before the reference's first moving frame.
    movements = tuple(
        ((start - 1) / float(scenario.rate), stop / float(scenario.rate)) for start, stop in movement_frames(scenario)
    )
    poses = [LampPose(np.array([*rng.normal(0, 15, 2), 1000.0]), np.array([0.0, 0.0, 5.0]), rng.uniform(-6, 6))]
    for _ in movements:
        last = poses[-1]
        while True:
            centre = np.array([*rng.uniform(-150, 150, 2), rng.uniform(940, 1060)])
            if 60 < np.linalg.norm((centre - last.centre_mm)[:2]) < 250:
                break
        turn = last.turn_deg + rng.choice((-1, 1)) * rng.uniform(4, 28)
        turn = turn if abs(turn) < 40 else 2 * last.turn_deg - turn
        aim = np.array([*rng.uniform(-22, 22, 2), 5.0])
        poses.append(LampPose(centre, aim, turn, rng.uniform(0.96, 1.07)))
    return LampPath(tuple(poses), movements)


@attrs.frozen(eq=False)
class Track:
    """A value that rests at keys and glides from one to the next.

    Attributes
    ----------
    leave_s, arrive_s
        From ``leave_s[i]`` to ``arrive_s[i]`` it glides from ``values[i]`` to ``values[i + 1]``.
    values
        One more than glides.
    """

    leave_s: tuple[float, ...]
    arrive_s: tuple[float, ...]
    values: tuple[NDArray, ...]

    def at(self, t: float) -> NDArray:
        """The value at ``t``."""
        i = bisect_right(self.leave_s, t) - 1
        if i < 0:
            return self.values[0]
        way = ease((t - self.leave_s[i]) / (self.arrive_s[i] - self.leave_s[i]))
        return self.values[i] + way * (self.values[i + 1] - self.values[i])


def make_track(keys: list[tuple[float, float, NDArray]], first: NDArray) -> Track:
    """A track from (leave, arrive, value) in order of time; keys that would overlap the one before are put off."""
    leave, arrive, values = [], [], [first]
    for start, stop, value in keys:
        start = max(start, arrive[-1] if arrive else start)
        leave.append(start)
        arrive.append(max(stop, start + 0.15))
        values.append(value)
    return Track(tuple(leave), tuple(arrive), tuple(values))


def sway(t: float, phase: NDArray, size_mm: float) -> NDArray:
    """Two slow incommensurable waves in x, y and z: nobody holds quite still."""
    rates = np.array([0.9, 1.13, 0.71])
    return size_mm * (np.sin(rates * t + phase) * 0.6 + np.sin(2.17 * rates * t + 2 * phase) * 0.4)


@attrs.frozen(eq=False)
class Person:
    """Somebody at the table: their azimuth about the field, their head over time, the phase of their sway."""

    azimuth_deg: float
    head: Track
    phase: NDArray

    def head_at(self, t: float) -> NDArray:
        """The head's centre, mm."""
        return self.head.at(t) + sway(t, self.phase, 5.0)

    @property
    def outward(self) -> NDArray:
        """(3,): the direction from the field to them."""
        azimuth = np.deg2rad(self.azimuth_deg)
        return np.array([np.cos(azimuth), np.sin(azimuth), 0.0])


@attrs.frozen
class Pace:
    """How quickly a head comes and goes, each as the least and most seconds.

    Attributes
    ----------
    glide_s
        In and out.
    stay_s
        Over one place.
    shift_s, again_s
        From there to another place now and then, and over that.
    away_s
        Until it comes again.
    """

    glide_s: tuple[float, float] = (0.7, 1.6)
    stay_s: tuple[float, float] = (2.5, 11)
    shift_s: tuple[float, float] = (0.6, 1.2)
    again_s: tuple[float, float] = (2.5, 8)
    away_s: tuple[float, float] = (3, 12)


QUICK = Pace(glide_s=(0.25, 0.5), stay_s=(0.3, 1.4), shift_s=(0.25, 0.5), again_s=(0.3, 1.2), away_s=(0.8, 4.5))


def people(scenario: Scenario, rig: Rig, path: LampPath) -> tuple[Person, ...]:
    """Heads lean into the line of sight of a camera on their side of the table, stay a while and go back."""
    found = []
    pace = QUICK if scenario.traits.quick else Pace()
    offset = scenario.stream("people").uniform(0, 360)
    for n in range(scenario.heads):
        rng = scenario.stream("person", n)
        azimuth = (offset + 360.0 / max(scenario.heads, 1) * n + rng.uniform(-18, 18)) % 360
        outward = np.array([np.cos(np.deg2rad(azimuth)), np.sin(np.deg2rad(azimuth))])
        height = HEAD_HEIGHT_MM + rng.uniform(-45, 55)

        def out(rng=rng, outward=outward, height=height) -> NDArray:
            side = np.array([-outward[1], outward[0]]) * rng.uniform(-60, 60)
            return np.array([*(outward * rng.uniform(330, 400) + side), height + 30])

        def over(t: float, rng=rng, azimuth=azimuth, height=height) -> NDArray:
            """A point between the field and one of the two or three cameras nearest to this person."""
            pose = path.nearest(t)
            away = np.abs((rig.azimuth_deg + pose.turn_deg - azimuth + 180) % 360 - 180)
            near = [c for c in np.argsort(away)[:3] if away[c] < 100] or [int(np.argmin(away))]
            lens = rig.pinhole(int(rng.choice(near)), pose).centre_mm
            return np.array([*(lens[:2] * (height / lens[2]) + rng.normal(0, 22, 2)), height])

        keys, t = [], rng.uniform(-6, 4)
        while t < scenario.duration_s + 5:
            glide = rng.uniform(*pace.glide_s)
            keys.append((t, t + glide, over(t)))
            t += glide + rng.uniform(*pace.stay_s)
            if rng.random() < 0.3:
                glide = rng.uniform(*pace.shift_s)
                keys.append((t, t + glide, over(t)))
                t += glide + rng.uniform(*pace.again_s)
            glide = rng.uniform(*pace.glide_s)
            keys.append((t, t + glide, out()))
            t += glide + rng.uniform(*pace.away_s)
        found.append(Person(azimuth, make_track(keys, out()), rng.uniform(0, 6.28, 3)))
    return tuple(found)


@attrs.frozen(eq=False)
class Worker:
    """A hand at work.

    Attributes
    ----------
    azimuth_deg
        From which side its arm comes.
    tip
        x, y and lift above the surface of its instrument's tip, mm.
    grip
        0 closed .. 1 open.
    phase
        (3,), of its tremor.
    kind
        Its instrument: 0 forceps, 1 ringed, 2 sucker.
    left
        Whether it is a left hand.
    """

    azimuth_deg: float
    tip: Track
    grip: Track
    phase: NDArray
    kind: int
    left: bool

    def tip_at(self, t: float) -> NDArray:
        """(3,): x, y and lift, mm."""
        return self.tip.at(t) + sway(3.1 * t, self.phase, 1.2)


def workers(
    scenario: Scenario, persons: tuple[Person, ...], reach_mm: tuple[float, float], axis_deg: float
) -> tuple[Worker, ...]:
    """Hands that go from point to point in the wound (half axes ``reach_mm``), and leave it now and then."""
    found = []
    for n in range(scenario.hands):
        rng = scenario.stream("hand", n)
        owner = persons[(n // 2) % len(persons)].azimuth_deg if persons else 90.0 * (n // 2)
        left = n % 2 == 1
        azimuth = owner + (22 if left else -22) + rng.uniform(-6, 6)
        outward = np.array([np.cos(np.deg2rad(azimuth)), np.sin(np.deg2rad(azimuth))])
        turn = np.deg2rad(axis_deg)
        axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        busy = n < 2

        def target(rng=rng, outward=outward, axes=axes) -> NDArray:
            own = axes.T @ (rng.normal(0, 0.45, 2) * reach_mm)
            return np.array([*(own + outward * 8), rng.choice((0.0, 2.0, 8.0))])

        keys, grips, t = [], [], -5.0
        while t < scenario.duration_s + 5:
            if rng.random() < (0.1 if busy else 0.25):
                glide = rng.uniform(0.6, 1.1)
                keys.append((t, t + glide, np.array([*(outward * rng.uniform(260, 340)), 60.0])))
                t += glide + rng.uniform(1.0, 4.0)
            glide = rng.uniform(0.35, 0.9)
            keys.append((t, t + glide, target()))
            t += glide
            for _ in range(int(rng.integers(0, 3))):
                grips.append((t, t + 0.2, np.array([rng.uniform(0.5, 1.0)])))
                grips.append((t + 0.3, t + 0.5, np.array([0.1])))
                t += 0.7
            t += rng.exponential(0.9 if busy else 4.0)
        found.append(
            Worker(
                azimuth,
                make_track(keys, target()),
                make_track(grips, np.array([0.2])),
                rng.uniform(0, 6.28, 3),
                int(rng.integers(0, 3)),
                left,
            )
        )
    return tuple(found)


@attrs.frozen(eq=False)
class Progression:
    """How far the operation has come. It rests while the lamp moves, so that a movement needs one texture only.

    Attributes
    ----------
    rests
        (start, stop) of the lamp's movements.
    stage_s
        From one state of the field to the next.
    """

    rests: tuple[tuple[float, float], ...]
    stage_s: float = 24.0

    def at(self, t: float) -> float:
        """Rises by one from one state of the field to the next."""
        rested = sum(max(0.0, min(t, stop) - start) for start, stop in self.rests)
        return max(0.0, t - rested) / self.stage_s
