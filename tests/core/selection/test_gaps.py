"""What selectors are told of cameras that have no pictures for a while."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.selection.gaps import with_ragged_edges
from mcsl_core.selection.selectors import ShortestPath

RATE, FRAMES = Fraction(25), 250
ALWAYS = (0.0, 10.0)


def scored(begins_s: float = 0.0, ends_s: float = 10.0) -> ScoreTable:
    """A head before a for the first and the last two seconds; b sees all the field while it has pictures."""
    frames = np.array([*range(0, FRAMES, 25), FRAMES - 1])
    covered = (frames < 50) | (frames >= 200)
    missing = (frames < 25 * begins_s) | (frames >= 25 * ends_s)
    visible = np.column_stack([np.where(covered, 0.1, 1.0), np.where(missing, np.nan, 0.9)])
    return ScoreTable(frames, ("a", "b"), visible, ~np.isnan(visible))


def chosen(table: ScoreTable) -> tuple[str, str]:
    shots = ShortestPath().select(table, frames=FRAMES, rate=RATE)
    return shots[0].camera, shots[-1].camera


@pytest.mark.parametrize(
    ("begins_s", "ends_s", "expected"),
    [
        (0.3, 10.0, ("b", "b")),
        (0.5, 9.95, ("b", "b")),
        (0.0, 9.5, ("b", "b")),
        (0.6, 10.0, ("a", "b")),
        (0.0, 9.4, ("b", "a")),
    ],
)
def test_a_camera_that_begins_late_or_ends_early_by_a_moment_may_open_and_close(
    begins_s: float, ends_s: float, expected: tuple[str, str]
) -> None:
    given = scored(begins_s, ends_s)
    table = with_ragged_edges(given, {"a": ALWAYS, "b": (begins_s, ends_s)}, FRAMES, RATE)
    assert chosen(table) == expected
    assert np.array_equal(table.visible[1:-1], given.visible[1:-1])
    assert chosen(given) == ("a" if begins_s else "b", "a" if ends_s < 10 else "b")


def test_a_camera_without_a_sample_stays_out() -> None:
    given = scored(20.0)
    table = with_ragged_edges(given, {"a": ALWAYS, "b": (9.97, 9.99)}, FRAMES, RATE)
    assert not table.usable[:, 1].any()
    assert chosen(table) == ("a", "a")
