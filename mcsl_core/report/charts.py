"""Curves and ranges over time as shapes of an SVG that is scaled to whatever width the page has.

x runs from 0 at the programme's first frame to `WIDTH` at its end, y from 0 at the top to `HEIGHT`. The SVG holds no
text: letters scaled in one direction are broken ones, so the page writes labels beside it, and positions are per cent.
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
    """A range of time.

    Attributes
    ----------
    x, width : str
        Left edge and width in the SVG's units.
    group : str
        The CSS class it is drawn by.
    title : str
        What the reader is told.
    """

    x: str
    width: str
    group: str
    title: str


@frozen
class Tick:
    """A label ``at`` so many per cent along an axis."""

    at: str
    text: str


def coordinate(value: float) -> str:
    """A coordinate: two decimals, no trailing noughts, the same on every machine."""
    return f"{value:.2f}".rstrip("0").rstrip(".") or "0"


def x_of(frame: float, frames: int) -> float:
    """Where a programme frame lies across, of ``frames`` in all."""
    return WIDTH * frame / frames


def bar(start: int, stop: int, frames: int, group: str, title: str) -> Bar:
    """A range of frames as a bar, at least wide enough to be seen.

    Parameters
    ----------
    start, stop : int
        Programme frames, half-open.
    frames : int
        The programme's length.
    group, title : str
        As of `Bar`.

    Returns
    -------
    Bar
    """
    width = max(x_of(stop - start, frames), 1.5)
    return Bar(coordinate(min(x_of(start, frames), WIDTH - width)), coordinate(width), group, title)


def binned(
    frames: NDArray[np.int64], values: NDArray[np.float64], total: int, *, keep: str = "mean"
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A curve by at most `BINS` points.

    Parameters
    ----------
    frames : (S,) int64
        Programme frames of the samples.
    values : (S,) float64
        NaN where there is no data.
    total : int
        The programme's length in frames.
    keep : {"mean", "min", "max"}
        What is kept of each bin.

    Returns
    -------
    frames, values : (N,) float64
        NaN where a bin has no data.
    """
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


def curve_path(
    x: NDArray[np.float64], y: NDArray[np.float64], total: int, lowest: float, highest: float, *, closed: bool = False
) -> str:
    """The SVG path of a curve; it breaks where there is no data.

    Parameters
    ----------
    x, y : (N,) float64
        Programme frames and values; NaN where there is no data.
    total : int
        The programme's length in frames.
    lowest, highest : float
        Values at the bottom and at the top.
    closed : bool
        Down to the bottom at both ends, for filling.

    Returns
    -------
    str
        The ``d`` of a path; empty without data.
    """
    scale = HEIGHT / (highest - lowest)
    runs: list[list[tuple[float, float]]] = [[]]
    for frame, value in zip(x, y, strict=True):
        if math.isnan(value):
            runs.append([])
        else:
            runs[-1].append((x_of(frame, total), HEIGHT - scale * (min(max(value, lowest), highest) - lowest)))
    return "".join(_run_path(run, closed) for run in runs if run)


def _run_path(run: list[tuple[float, float]], closed: bool) -> str:
    if len(run) == 1:  # a point alone would be invisible
        run = [run[0], (run[0][0] + 1, run[0][1])]
    path = "M" + "L".join(f"{coordinate(x)} {coordinate(y)}" for x, y in run)
    return path + f"L{coordinate(run[-1][0])} {HEIGHT}L{coordinate(run[0][0])} {HEIGHT}Z" if closed else path


def time_ticks(seconds: float) -> list[Tick]:
    """Round times along a programme of ``seconds``, none so near its end that the text would leave the page."""
    step = next((s for s in _STEPS_S if seconds / s <= _MOST_TICKS), _STEPS_S[-1])
    hours = seconds >= 3600
    return [
        Tick(coordinate(100 * t / seconds), short_time(t, hours=hours))
        for t in range(0, math.ceil(0.96 * seconds), step)
    ]


def short_time(seconds: float, *, hours: bool = False) -> str:
    """m:ss, or h:mm:ss where an hour is reached or asked for."""
    whole = math.floor(seconds + 0.5)
    if hours or whole >= 3600:
        return f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d}"
    return f"{whole // 60}:{whole % 60:02d}"


def bounds(values: NDArray[np.float64], thresholds: Sequence[float], *, share: bool) -> tuple[float, float]:
    """Where a chart's axis begins and ends.

    Parameters
    ----------
    values : (S,) float64
        The curve; NaN where there is no data.
    thresholds : sequence of float
        What is drawn as well.
    share : bool
        Whether the values are shares: then 0 to 1.

    Returns
    -------
    lowest, highest : float

    Notes
    -----
    Else from 0 past the thresholds and most of the curve: a single peak a hundred times as high as the threshold must
    not flatten what lies about it.
    """
    if share:
        return 0.0, 1.0
    known = values[~np.isnan(values)]
    reach = [4 * t for t in thresholds] + ([float(np.percentile(known, 95)) * 1.2] if len(known) else [])
    highest = min(max(reach, default=1.0), float(known.max()) * 1.05 if len(known) else 1.0)
    return 0.0, max(highest, 1e-9, *thresholds) if thresholds else max(highest, 1e-9)
