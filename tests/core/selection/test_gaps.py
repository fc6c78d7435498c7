"""What selectors are told of cameras that have no pictures for a while."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from mcsl_core.edl import Camera, Clock, Media
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.selection.gaps import with_late_starts
from mcsl_core.selection.selectors import ShortestPath

RATE, FRAMES = Fraction(10), 100


def begun(name: str, late_s: float) -> Camera:
    """A camera that begins so long after the programme."""
    return Camera(name, (Media(f"{name}.mp4", 100),), (64, 36), RATE, Clock(offset_s=late_s))


def scored(late_s: float) -> ScoreTable:
    """A head before a for two seconds; b sees all the field from when it begins."""
    frames = np.arange(0, FRAMES, 10)
    visible = np.column_stack([np.where(frames < 20, 0.0, 0.9), np.where(frames < 10 * late_s, np.nan, 1.0)])
    return ScoreTable(frames, ("a", "b"), visible, ~np.isnan(visible))


@pytest.mark.parametrize(("late_s", "first"), [(0.3, "b"), (0.5, "b"), (0.6, "a"), (1.5, "a")])
def test_a_camera_that_begins_a_moment_late_may_be_the_first_on_air(late_s: float, first: str) -> None:
    cameras = [begun("a", 0.0), begun("b", late_s)]
    table = with_late_starts(scored(late_s), cameras, RATE)
    shots = ShortestPath().select(table, frames=FRAMES, rate=RATE)
    assert shots[0].camera == first
    assert ShortestPath().select(scored(late_s), frames=FRAMES, rate=RATE)[0].camera == "a"
    assert np.array_equal(table.visible[2:], scored(late_s).visible[2:])


def test_a_camera_that_never_has_a_picture_stays_out() -> None:
    table = scored(0.0)
    nothing = ScoreTable(table.frames, table.cameras, np.full(table.visible.shape, np.nan), np.zeros_like(table.usable))
    assert not with_late_starts(nothing, [begun("a", 0.0), begun("b", 0.3)], RATE).usable.any()
