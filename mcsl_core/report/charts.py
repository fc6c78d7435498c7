"""Curves and stretches over time as shapes of an SVG that is stretched to whatever width the page has.

x runs from 0 at the programme's first frame to `WIDTH` at its end, y from 0 at the top to `HEIGHT`. The SVG holds no
text: a stretched letter is a broken one, so the page writes labels beside it, and positions are per cent.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

WIDTH, HEIGHT = 1000, 100
BINS = 400  # points a curve: two pixels each on a wide screen; hours of samples do not make the page larger
_STEPS_S = (1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400)
_MOST_TICKS = 5  # so many times fit side by side on a phone


@frozen
class Bar:
    """A stretch of time: left edge and width in the SVG's units, ``group`` for its look, ``title`` for the reader."""

    x: str
    width: str
    group: str
    title: str


@frozen
class Tick:
    """A label at ``at`` per cent along an axis."""

    at: str
    text: str


def number(value: float) -> str:
    """A coordinate: two decimals, no trailing noughts, the same on every machine."""
    return f"{value:.2f}".rstrip("0").rstrip(".") or "0"


def place(frame: float, frames: int) -> float:
    return WIDTH * frame / frames


def bar(start: int, stop: int, frames: int, group: str, title: str) -> Bar:
    """Frames [start, stop) as a bar, at least wide enough to be seen."""
    width = max(place(stop - start, frames), 1.5)
    return Bar(number(min(place(start, frames), WIDTH - width)), number(width), group, title)


def binned(
    frames: NDArray[np.int64], values: NDArray[np.float64], total: int, *, keep: str = "mean"
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """At most `BINS` (frame, value) of a curve; NaN where a bin has no data. keep: "mean", "min" or "max" of each."""
    if len(frames) <= BINS:
        return frames.astype(np.float64), values
    position = np.minimum(frames * BINS // total, BINS - 1)
    x, y = np.full(BINS, np.nan), np.full(BINS, np.nan)
    take = {"mean": np.mean, "min": np.min, "max": np.max}[keep]
    for index in range(BINS):
        inside = position == index
        if inside.any():
            x[index] = frames[inside].mean()
            known = values[inside][~np.isnan(values[inside])]
            y[index] = take(known) if len(known) else np.nan
    there = ~np.isnan(x)
    return x[there], y[there]


def line(
    x: NDArray[np.float64], y: NDArray[np.float64], total: int, lowest: float, highest: float, *, closed: bool = False
) -> str:
    """The SVG path of a curve between ``lowest`` (bottom) and ``highest`` (top); it breaks where there is no data.

    closed: down to the bottom at both ends, for filling.
    """
    scale = HEIGHT / (highest - lowest)
    runs: list[list[str]] = [[]]
    ends: list[list[float]] = [[]]
    for frame, value in zip(x, y, strict=True):
        if math.isnan(value):
            runs.append([])
            ends.append([])
            continue
        at = place(frame, total)
        runs[-1].append(f"{number(at)} {number(HEIGHT - scale * (min(max(value, lowest), highest) - lowest))}")
        ends[-1].append(at)
    made = []
    for run, at in zip(runs, ends, strict=True):
        if not run:
            continue
        if len(run) == 1:  # a point alone would be invisible
            run, at = [run[0], f"{number(at[0] + 1)} {run[0].split()[1]}"], [at[0], at[0] + 1]
        path = "M" + "L".join(run)
        made.append(path + f"L{number(at[-1])} {HEIGHT}L{number(at[0])} {HEIGHT}Z" if closed else path)
    return "".join(made)


def time_ticks(seconds: float) -> list[Tick]:
    """Round times along a programme of ``seconds``, none so near its end that the text would leave the page."""
    step = next((s for s in _STEPS_S if seconds / s <= _MOST_TICKS), _STEPS_S[-1])
    hours = seconds >= 3600
    return [
        Tick(number(100 * t / seconds), short_time(t, hours=hours)) for t in range(0, math.ceil(0.96 * seconds), step)
    ]


def short_time(seconds: float, *, hours: bool = False) -> str:
    """m:ss, or h:mm:ss where an hour is reached or asked for."""
    whole = math.floor(seconds + 0.5)
    if hours or whole >= 3600:
        return f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d}"
    return f"{whole // 60}:{whole % 60:02d}"


def bounds(values: NDArray[np.float64], thresholds: Sequence[float], *, share: bool) -> tuple[float, float]:
    """Where a chart's axis begins and ends: a share's is 0 to 1; else from 0 past the threshold and most of the curve.

    A single peak a hundred times as high as the threshold must not flatten what lies about it.
    """
    if share:
        return 0.0, 1.0
    known = values[~np.isnan(values)]
    reach = [4 * t for t in thresholds] + ([float(np.percentile(known, 95)) * 1.2] if len(known) else [])
    highest = min(max(reach, default=1.0), float(known.max()) * 1.05 if len(known) else 1.0)
    return 0.0, max(highest, 1e-9, *thresholds) if thresholds else max(highest, 1e-9)
