"""Cameras are not chosen in their gaps: what is known between two samples, told to the selectors."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np

from mcsl_core.edl import Camera
from mcsl_core.occlusion.score_table import ScoreTable

from .selectors import sample_borders


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
