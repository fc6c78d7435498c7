"""The sound of a room, made without the simulator, and what a camera with a clock of its own records of it."""

from __future__ import annotations

import numpy as np
from scipy import signal

RATE = 48000


def room(seconds, seed=0, rate=16000):
    """Words, clinks and hum in a room, at ``rate``; nothing in it repeats."""
    rng = np.random.default_rng(seed)
    total = np.zeros(int(seconds * rate))
    t = 0.0
    while t < seconds - 3:
        length = rng.uniform(0.1, 0.6)
        n = int(length * rate)
        low = rng.uniform(150, 900)
        band = signal.butter(2, [low, low * rng.uniform(1.5, 3)], "bandpass", fs=rate, output="sos")
        word = signal.sosfilt(band, rng.normal(0, 1, n)) * np.hanning(n)
        total[int(t * rate) : int(t * rate) + n] += word * rng.uniform(0.1, 0.5)
        t += length + rng.exponential(0.25)
    return total + 0.01 * np.sin(2 * np.pi * 100 * np.arange(len(total)) / rate)


def heard(source, clock, seconds, seed, noise=0.01, rate=16000):
    """What a camera with that clock (offset_s, drift_ppm) records of ``source`` in its own time, at 48 kHz."""
    offset, drift = clock
    rng = np.random.default_rng(seed)
    own = np.arange(int(seconds * RATE)) / RATE
    programme = own / (1 + drift * 1e-6) + offset
    up = signal.resample_poly(source, 3, 1)
    sound = np.interp(programme * RATE, np.arange(len(up)), up, left=0, right=0)
    echo = np.zeros(int(0.03 * RATE))
    echo[0] = 1
    echo[rng.integers(200, len(echo), 6)] = rng.uniform(-0.3, 0.3, 6)
    return (signal.fftconvolve(sound, echo)[: len(sound)] + rng.normal(0, noise, len(sound))).astype(np.float32)
