"""Where cameras have no pictures, told to selectors: none is chosen in a gap, each may begin late or end early."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

import attrs
import numpy as np

from mcsl_core.edl import Camera
from mcsl_core.occlusion.score_table import ScoreTable

from .selectors import sample_borders

_RAGGED_S = 0.5  # by which recorders that are started and stopped together begin and end after one another
_ROUNDED = 1e-6  # seconds


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


def with_ragged_edges(
    table: ScoreTable, spans: Mapping[str, tuple[float, float]], frames: int, rate: Fraction
) -> ScoreTable:
    """The table with cameras that begin a moment after the programme, or end before it, as if they lasted as long.

    Until its first picture, and from its last one on, another camera is shown. Else the one that begins first, or ends
    last, were on air for a whole shot whatever is before it.

    Parameters
    ----------
    table : ScoreTable
        Of S samples.
    spans : mapping of str to (float, float)
        Camera -> programme seconds at which it has its first picture, and at which its last one is over.
    frames : int
        Length of the programme.
    rate : Fraction
        Programme frames per second.

    Returns
    -------
    ScoreTable
        Where they are missing as at the sample nearest to it.
    """
    visible, usable = table.visible.copy(), table.usable.copy()
    seconds, length_s = table.frames / float(rate), frames / float(rate)
    for name, (begins_s, ends_s) in spans.items():
        column = table.cameras.index(name)
        there = np.flatnonzero((seconds >= begins_s - _ROUNDED) & (seconds < ends_s - _ROUNDED))
        if not len(there):
            continue
        first, last = there[0], there[-1]
        if begins_s <= _RAGGED_S:
            visible[:first, column], usable[:first, column] = visible[first, column], usable[first, column]
        if length_s - ends_s <= _RAGGED_S:
            visible[last + 1 :, column], usable[last + 1 :, column] = visible[last, column], usable[last, column]
    return attrs.evolve(table, visible=visible, usable=usable)
