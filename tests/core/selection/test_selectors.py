"""Selection against enumeration of every possible cut, and its promises on long random tables."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcsl_core.errors import UsageError
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.selection.merits import MERITS
from mcsl_core.selection.selectors import Fixed, LeastOccluded, ShortestPath, sample_borders
from mcsl_core.selection.worth import ViewingWorth
from mcsl_core.timing import check_tiles

SELECTORS = [ShortestPath(), LeastOccluded(), Fixed()]


@st.composite
def tables(draw: st.DrawFn, samples: int = 7, cameras: int = 3) -> tuple[ScoreTable, int]:
    s, c = draw(st.integers(1, samples)), draw(st.integers(1, cameras))
    frames = np.cumsum([draw(st.integers(1, 9)) for _ in range(s)])
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    visible = rng.random((s, c))
    visible[rng.random((s, c)) < 0.1] = np.nan
    usable = rng.random((s, c)) < 0.9
    merits = {name: rng.random((s, c)) for name in draw(st.sampled_from([(), ("sharpness",), MERITS]))}
    table = ScoreTable(frames, tuple(f"cam{i}" for i in range(c)), visible, usable, merits)
    return table, int(frames[-1]) + draw(st.integers(1, 9))


def known(table: ScoreTable, i: int, c: int) -> float:
    """What is known of camera c at sample i: where it has no data, the line between the nearest that it has."""
    there = [j for j in range(len(table.frames)) if not np.isnan(table.visible[j, c])]
    if not there:
        return 0.0
    before, after = (
        max((j for j in there if j <= i), default=there[0]),
        min((j for j in there if j >= i), default=there[-1]),
    )
    a, b, at = (float(table.frames[j]) for j in (before, after, i))
    share = 0.0 if a == b else (at - a) / (b - a)
    return (
        float((1 - share) * table.visible[before, c] + share * table.visible[after, c])
        if a <= at
        else float(table.visible[after, c])
    )


def value(table: ScoreTable, borders: np.ndarray, choice: tuple[int, ...], cost: float, taste: ViewingWorth) -> float:
    total = 0.0
    for i, c in enumerate(choice):
        seen = known(table, i, c)
        worth = seen - taste.covered * (1 - seen) * (1 - seen)
        worth -= sum(getattr(taste, name) * (1 - merit[i, c]) for name, merit in table.merits.items())
        worth = worth if table.usable[i, c] else -1e7
        total += worth * (borders[i + 1] - borders[i])
    return total - cost * sum(a != b for a, b in pairwise(choice))


@given(tables(), st.integers(1, 20), st.floats(0, 5), st.sampled_from([0.0, 2.0, 7.0]))
@settings(max_examples=150, deadline=None)
def test_shortest_path_is_the_best_of_all_cuts(drawn, min_frames: int, cost: float, covered: float) -> None:
    table, frames = drawn
    borders = sample_borders(table, frames)
    taste = ViewingWorth(covered=covered)
    selector = ShortestPath(min_shot_s=min_frames, switch_cost_s=cost, worth=taste)
    shots = selector.select(table, frames=frames, rate=Fraction(1))
    check_tiles((s.range for s in shots), frames, "shots")
    assert len(shots) == 1 or min(len(s.range) for s in shots) >= min_frames
    choice = tuple(
        next(table.cameras.index(s.camera) for s in shots if int(borders[i]) in s.range)
        for i in range(len(table.frames))
    )
    best = -np.inf
    for other in product(range(len(table.cameras)), repeat=len(table.frames)):
        cuts = [0, *(int(borders[i]) for i in range(1, len(other)) if other[i] != other[i - 1]), frames]
        if len(cuts) == 2 or min(b - a for a, b in pairwise(cuts)) >= min_frames:
            best = max(best, value(table, borders, other, cost, taste))
    assert value(table, borders, choice, cost, taste) == pytest.approx(best, rel=1e-9, abs=1e-6)


@pytest.mark.parametrize("selector", SELECTORS, ids=lambda s: s.name)
@given(drawn=tables(samples=40, cameras=6))
@settings(max_examples=40, deadline=None)
def test_shots_tile_and_neighbours_differ(selector, drawn) -> None:
    table, frames = drawn
    shots = selector.select(table, frames=frames, rate=Fraction(25))
    check_tiles((s.range for s in shots), frames, "shots")
    assert all(a.camera != b.camera for a, b in pairwise(shots))
    assert all(0 <= s.score <= 1 and s.why for s in shots)


def test_an_unusable_camera_is_never_chosen_while_another_is_there() -> None:
    visible = np.column_stack([np.full(50, 0.1), np.full(50, 1.0)])
    usable = np.column_stack([np.ones(50, bool), np.zeros(50, bool)])
    table = ScoreTable(np.arange(50) * 30, ("dim", "weak"), visible, usable)
    for selector in (ShortestPath(), LeastOccluded()):
        assert {s.camera for s in selector.select(table, frames=1500, rate=Fraction(30))} == {"dim"}


def test_a_short_glimpse_is_not_worth_a_switch() -> None:
    visible = np.column_stack([np.full(30, 0.8), np.full(30, 0.6)])
    visible[10, 1] = 1.0
    table = ScoreTable(np.arange(30) * 30, ("a", "b"), visible, np.ones((30, 2), bool))
    assert [s.camera for s in ShortestPath().select(table, frames=900, rate=Fraction(30))] == ["a"]
    assert [s.camera for s in LeastOccluded().select(table, frames=900, rate=Fraction(30))] == ["a", "b", "a"]


def test_fixed_names_what_there_is() -> None:
    table = ScoreTable(np.arange(3), ("a", "b"), np.ones((3, 2)), np.ones((3, 2), bool))
    with pytest.raises(UsageError, match="Choose one of a, b"):
        Fixed("c").select(table, frames=3, rate=Fraction(1))


def test_two_hours_of_samples_are_quick_enough_to_select_again() -> None:
    rng = np.random.default_rng(0)
    table = ScoreTable(np.arange(7200) * 30, tuple("abcde"), rng.random((7200, 5)), np.ones((7200, 5), bool))
    shots = ShortestPath().select(table, frames=7200 * 30, rate=Fraction(30))
    assert min(len(s.range) for s in shots) >= 60
