"""Arithmetic on a file's timestamps: the rate of its pictures, whether they stand in order, where its clock jumps."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from .facts import nominal_rate

_USUAL = sorted(
    {Fraction(n) for n in (5, 10, 12, 15, 20, 24, 25, 30, 48, 50, 60, 90, 100, 120, 200, 240)}
    | {Fraction(n * 1000, 1001) for n in (24, 30, 60, 120)}
)
_MOST_DECLARED = 1000  # frames a second; FFmpeg's guess from a millisecond clock is the clock's own rate
_CLOSE = Fraction(1, 2000)  # 29.97 and 30 are twice as far apart
_LONGEST_HOLE = 20  # slots: over longer ones the step is not known well enough to count them
JUMP_S = 1  # a clock that goes back by more was set anew; reordering and rounding stay far below


def frame_rate(stamps: Sequence[int], tick: Fraction, declared: Fraction | None) -> Fraction:
    """Nominal frames per second from the presentation timestamps.

    Parameters
    ----------
    stamps
        In ticks, in any order.
    tick
        Seconds.
    declared
        What the headers say; believed where the timestamps leave it open.

    Returns
    -------
    Fraction
        Where the pictures stand on an even grid, the grid's rate: lost pictures leave holes in it and do not change
        it. Else the declared rate if pictures really come that fast, or the usual rate nearest to the mean.
    """
    if declared is not None and not 0 < declared <= _MOST_DECLARED:
        declared = None
    rising = np.unique(np.array(stamps, np.int64))
    if len(rising) < 2:
        return nominal_rate(declared) if declared is not None and declared <= _USUAL[-1] else Fraction(25)
    steps = np.diff(rising)
    span = Fraction(int(rising[-1] - rising[0])) * tick
    grid = _grid_rate(steps, tick)
    if grid is not None:
        # Rounding to ticks at both ends leaves so much open: 2.3 s of 29.97 in milliseconds cannot tell 29.974.
        slack = 2 * tick / span
        if declared is not None and abs(declared - grid) <= grid * slack:
            return nominal_rate(declared)
        usual = min(_USUAL, key=lambda rate: abs(rate - grid))
        return usual if abs(usual - grid) <= grid * min(slack, _CLOSE) else nominal_rate(grid)
    mean = len(steps) / span
    fastest = 1 / (float(np.quantile(steps, 0.1)) * float(tick))
    if declared is not None and mean / 2 <= declared <= 1.25 * fastest:
        return nominal_rate(declared)
    return min(_USUAL, key=lambda rate: abs(rate - mean))


def _grid_rate(steps: NDArray[np.int64], tick: Fraction) -> Fraction | None:
    """The rate of the even grid that the steps are whole multiples of, in 95 of 100; None where there is none."""
    middle = float(np.median(steps))
    step = float(steps[(steps > 0.5 * middle) & (steps < 1.5 * middle)].mean())
    slots = np.round(steps / step)
    fits = (np.abs(steps - slots * step) <= 1 + 0.1 * step) & (slots >= 1)
    if fits.mean() < 0.95:
        return None
    fits &= slots <= _LONGEST_HOLE
    return Fraction(int(slots[fits].sum())) / (int(steps[fits].sum()) * tick)


def set_back(stamps: Sequence[int], tick: Fraction, *, lasting: int) -> Fraction | None:
    """Where a file's clock was set back by more than a second, as in files joined end to end; None where it was not.

    Parameters
    ----------
    stamps
        In ticks, in the order of the file.
    tick
        Seconds.
    lasting
        How many timestamps from there on must lie below: a damaged one alone says nothing, nor do reordered pictures.

    Returns
    -------
    Fraction or None
        Seconds of the clock, just before it was set back.
    """
    values = np.array(stamps, np.int64)
    if len(values) < 2:
        return None
    before = np.maximum.accumulate(values)[:-1]
    below = (before - values[1:]) * float(tick) > JUMP_S
    for at in np.flatnonzero(below):
        if below[at : at + lasting].all() and len(below) - at >= lasting:
            return int(before[at]) * tick
    return None
