"""Each camera's own clock: own time is (t - offset_s) * (1 + drift_ppm * 1e-6), t programme time in seconds."""

from __future__ import annotations

import math

import attrs

from .scenario import Scenario


@attrs.frozen
class Clock:
    """The true clock of a camera: frame k of its file stands at own time k / rate. The reference has 0 and 0."""

    offset_s: float = 0.0
    drift_ppm: float = 0.0

    def own(self, t: float) -> float:
        """The camera's own time at programme time ``t``."""
        return (t - self.offset_s) * (1 + self.drift_ppm * 1e-6)

    def programme(self, own_s: float) -> float:
        """Programme time at the camera's own time."""
        return own_s / (1 + self.drift_ppm * 1e-6) + self.offset_s


def clocks(scenario: Scenario) -> tuple[Clock, ...]:
    """Every camera's clock."""
    rng = scenario.stream("clocks")
    rows = rng.uniform(-1, 1, (scenario.cameras, 2)) * (scenario.clock_offset_s, scenario.drift_ppm)
    return (Clock(), *(Clock(float(offset), float(drift)) for offset, drift in rows[1:]))


def frame_counts(scenario: Scenario) -> tuple[int, ...]:
    """How many frames each camera's file has: all stop at about the end of the programme, none exactly."""
    rng = scenario.stream("ends")
    counts = [scenario.frames]
    for clock in clocks(scenario)[1:]:
        end = scenario.duration_s + rng.uniform(0, 1) * scenario.clock_offset_s
        counts.append(max(1, math.floor(clock.own(end) * scenario.rate)))
    return tuple(counts)
