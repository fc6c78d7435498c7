"""Where cameras have no pictures, told to the selectors: they are not chosen in gaps, and may begin a little late."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import ceil

import attrs
import numpy as np

from mcsl_core.edl import Camera
from mcsl_core.occlusion.score_table import ScoreTable

from .selectors import sample_borders

_LATE_S = 0.5  # by which recorders that are started together begin after one another


def without_gaps(table: ScoreTable, cameras: Sequence[Camera], frames: int) -> ScoreTable:
    """The table with no camera usable where one of its gaps reaches into what a sample stands for.

    Parameters
    ----------
    table : ScoreTable
        Of S samples, which see a gap only where they fall into it.
    cameras : sequence of Camera
        With their gaps.
    frames : int
        Length of the programme.

    Returns
    -------
    ScoreTable
        There ``usable`` is False, and ``visible`` NaN.
    """
    if not len(table.frames) or not any(camera.gaps for camera in cameras):
        return table
    borders = sample_borders(table, frames)
    visible, usable = table.visible.copy(), table.usable.copy()
    for camera in cameras:
        column = table.cameras.index(camera.name)
        for gap in camera.gaps:
            reached = (borders[:-1] < gap.stop) & (borders[1:] > gap.start)
            usable[reached, column] = False
            visible[reached, column] = np.nan
    return attrs.evolve(table, visible=visible, usable=usable)


def with_late_starts(table: ScoreTable, cameras: Sequence[Camera], rate: Fraction) -> ScoreTable:
    """The table with cameras that begin a moment after the programme taken as if they began with it.

    Until their first picture another camera is shown. Else the one that begins first were on air for a whole shot,
    whatever is before it.

    Parameters
    ----------
    table : ScoreTable
        Of S samples.
    cameras : sequence of Camera
        With their clocks.
    rate : Fraction
        Programme frames per second.

    Returns
    -------
    ScoreTable
        Before they begin, as at the first sample after it.
    """
    visible, usable = table.visible.copy(), table.usable.copy()
    for camera in cameras:
        column = table.cameras.index(camera.name)
        begins = ceil(camera.clock.programme_time(0) * float(rate))
        first = int(np.searchsorted(table.frames, begins))
        if 0 < begins <= _LATE_S * float(rate) and first < len(table.frames):
            visible[:first, column], usable[:first, column] = visible[first, column], usable[first, column]
    return attrs.evolve(table, visible=visible, usable=usable)
