"""The room as each camera hears it: voices, a monitor's beeps, metal; float32 mono at 48 kHz.

The room's sound is a function of programme time, made second by second; each camera reads it on its own clock through
its own filter, with its own noise and the few milliseconds that sound takes to reach it.
"""

from __future__ import annotations

from bisect import bisect_left
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfilt, sosfilt_zi

from .clocks import Clock
from .scenario import Scenario

RATE = 48000
_LONGEST_S = 4.0


class Room:
    """All that sounds in the room; quick when time rises."""

    def __init__(self, scenario: Scenario) -> None:
        rng = scenario.stream("room")
        begin, end = -scenario.clock_offset_s - 3, scenario.duration_s + scenario.clock_offset_s + 3
        self._scenario = scenario
        self._events: list[tuple[float, str, int]] = []
        for kind, pause in (("voice", 2.2), ("clink", 1.9)):
            t = begin
            while (t := t + rng.exponential(pause) + 0.15) < end:
                self._events.append((t, kind, int(rng.integers(2**31))))
                t += 0.9 if kind == "voice" else 0
        t, pulse = begin, rng.uniform(0.75, 1.0)
        # A heart is not a metronome; a steady beep would fit every shift by a beat.
        while (t := t + pulse * rng.uniform(0.86, 1.14)) < end:
            self._events.append((t, "beep", 0))
        self._events.sort()
        self._tone = rng.uniform(700, 1000)
        self._made: dict[int, NDArray] = {}
        self._wave = lru_cache(maxsize=8)(self._event)  # one sounds on in the seconds that follow

    def second(self, n: int) -> NDArray:
        """(`RATE`,) float32: programme time n to n + 1."""
        if n not in self._made:
            while len(self._made) > 4:
                self._made.pop(next(iter(self._made)))
            self._made[n] = self._make(n)
        return self._made[n]

    def _make(self, n: int) -> NDArray:
        total = np.zeros(RATE, np.float64)
        first = bisect_left(self._events, (n - _LONGEST_S, "", 0))
        for t, kind, seed in self._events[first : bisect_left(self._events, (n + 1.0, "", 0))]:
            wave = self._wave(kind, seed)
            at = round((t - n) * RATE)
            a, b = max(at, 0), min(at + len(wave), RATE)
            if a < b:
                total[a:b] += wave[a - at : b - at]
        return total.astype(np.float32)

    def _event(self, kind: str, seed: int) -> NDArray:
        if kind == "beep":
            t = np.arange(int(0.11 * RATE)) / RATE
            return 0.09 * np.sin(np.pi * t / 0.11) ** 0.5 * np.sin(2 * np.pi * self._tone * t + 0.3 * np.sin(9e3 * t))
        rng = np.random.default_rng(seed)
        if kind == "clink":
            t = np.arange(int(0.35 * RATE)) / RATE
            ring = sum(
                np.sin(2 * np.pi * f * t + p) * np.exp(-t * d)
                for f, p, d in zip(
                    rng.uniform(2400, 8800, 5), rng.uniform(0, 6, 5), rng.uniform(12, 45, 5), strict=True
                )
            )
            return rng.uniform(0.01, 0.05) * np.minimum(t * 2000, 1) * ring
        t = np.arange(int(rng.uniform(0.7, 3.2) * RATE)) / RATE
        # A voice: pitch pulses through formant-like bands, in syllables.
        pitch = rng.uniform(95, 210) * (1 + 0.12 * np.sin(2 * np.pi * rng.uniform(0.5, 1.6) * t + rng.uniform(0, 6)))
        phase = np.cumsum(pitch) / RATE
        source = 1.6 * (phase % 1 < 0.22) - 0.35 + 0.5 * rng.standard_normal(len(t))
        low, high = rng.uniform(260, 420), rng.uniform(1700, 3200)
        voice = np.asarray(sosfilt(butter(2, [low, high], "band", fs=RATE, output="sos"), source))
        syllables = np.arange(0, t[-1] + 0.3, 0.11)
        beats = np.interp(t, syllables, rng.random(len(syllables)) ** 1.5)
        edge = np.clip(np.minimum(t, t[-1] - t) / 0.06, 0, 1)
        return rng.uniform(0.05, 0.16) * voice * beats * edge


class Microphone:
    """One camera's audio on its own clock, read in order."""

    def __init__(self, room: Room, scenario: Scenario, camera: int, clock: Clock) -> None:
        rng = scenario.stream("microphone", camera)
        self._room, self._clock = room, clock
        self._rng = scenario.stream("hiss", camera)
        self._delay_s = 0.0 if camera == 0 else rng.uniform(-0.0012, 0.0012)
        self._gain, self._hiss = rng.uniform(0.7, 1.2), rng.uniform(0.0012, 0.004)
        self._filter = butter(1, [rng.uniform(70, 160), rng.uniform(6500, 13000)], "band", fs=RATE, output="sos")
        self._state = sosfilt_zi(self._filter) * 0.0
        self._done = 0

    def read(self, samples: int) -> NDArray:
        """(samples, 1) float32 in -1..1: the next ones."""
        own = np.arange(self._done, self._done + samples) / RATE
        self._done += samples
        t = own / (1 + self._clock.drift_ppm * 1e-6) + self._clock.offset_s - self._delay_s
        first, last = int(np.floor(t[0])), int(np.floor(t[-1])) + 1
        heard = np.concatenate([self._room.second(n) for n in range(first, last + 1)])
        wave = np.interp((t - first) * RATE, np.arange(len(heard)), heard)
        wave = self._gain * wave + self._hiss * self._rng.standard_normal(samples)
        wave, self._state = sosfilt(self._filter, wave, zi=self._state)
        return np.clip(wave, -1, 1).astype(np.float32)[:, None]
