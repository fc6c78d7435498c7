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
from mcsl_core.selection.selectors import Fixed, LeastOccluded, ShortestPath, ThroughHeads, believed, sample_borders
from mcsl_core.selection.worth import ViewingWorth
from mcsl_core.timing import check_tiles

SELECTORS = [ShortestPath(), ThroughHeads(), LeastOccluded(), Fixed()]


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


def worths(table: ScoreTable, taste: ViewingWorth, error: float) -> list[list[float]]:
    """What a frame of every camera is worth at every sample."""
    rows = []
    for i in range(len(table.frames)):
        seen = [known(table, i, c) for c in range(len(table.cameras))]
        best = max((s for s, usable in zip(seen, table.usable[i], strict=True) if usable), default=0.0)
        row = []
        for c, own in enumerate(seen):
            short = best - own
            own = best - short * short / (short + error) if short > 0 else own
            worth = own - taste.covered * (1 - own) * (1 - own)
            worth -= sum(getattr(taste, name) * (1 - merit[i, c]) for name, merit in table.merits.items())
            row.append(worth if table.usable[i, c] else -1e7)
        rows.append(row)
    return rows


def value(each: list[list[float]], borders: np.ndarray, choice: tuple[int, ...], cost: float) -> float:
    total = sum(each[i][c] * (borders[i + 1] - borders[i]) for i, c in enumerate(choice))
    return total - cost * sum(a != b for a, b in pairwise(choice))


@given(
    tables(), st.integers(1, 20), st.floats(0, 5), st.sampled_from([0.0, 2.0, 7.0]), st.sampled_from([0.0, 0.03, 0.3])
)
@settings(max_examples=150, deadline=None)
def test_shortest_path_is_the_best_of_all_cuts(drawn, min_frames: int, cost: float, covered: float, error) -> None:
    table, frames = drawn
    borders = sample_borders(table, frames)
    taste = ViewingWorth(covered=covered)
    each = worths(table, taste, error)
    selector = ShortestPath(min_shot_s=min_frames, switch_cost_s=cost, worth=taste, score_error=error)
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
            best = max(best, value(each, borders, other, cost))
    assert value(each, borders, choice, cost) == pytest.approx(best, rel=1e-9, abs=1e-6)


@pytest.mark.parametrize("selector", SELECTORS, ids=lambda s: s.name)
@given(drawn=tables(samples=40, cameras=6))
@settings(max_examples=40, deadline=None)
def test_shots_tile_and_neighbours_differ(selector, drawn) -> None:
    table, frames = drawn
    shots = selector.select(table, frames=frames, rate=Fraction(25))
    check_tiles((s.range for s in shots), frames, "shots")
    assert all(a.camera != b.camera for a, b in pairwise(shots))
    assert all(0 <= s.score <= 1 and s.why for s in shots)


def test_a_camera_is_kept_under_a_head_that_is_seen_through() -> None:
    """Heads cover half of the field of the nearer camera for three seconds in ten; the other one sees it."""
    head = np.arange(100) % 20 < 6
    visible = np.column_stack([np.where(head, 0.5, 1.0), np.ones(100)])
    merits = {"viewpoint": np.tile([1.0, 0.0], (100, 1))}
    table = ScoreTable(np.arange(100) * 15, ("near", "far"), visible, np.ones((100, 2), bool), merits=merits)

    def cameras(selector: ShortestPath) -> list[str]:
        return [shot.camera for shot in selector.select(table, frames=1500, rate=Fraction(30))]

    assert "far" in cameras(ShortestPath())
    assert cameras(ThroughHeads(seen_through=1.0)) == ["near"]
    assert cameras(ThroughHeads(seen_through=0.0)) == cameras(ShortestPath())


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


@pytest.mark.parametrize("off", [0.02, 0.03, 0.04])
def test_what_may_be_chance_is_not_worth_a_switch(off: float) -> None:
    """Two cameras see as much; one seems to see a little more for a quarter of a minute, and is then covered."""
    visible = np.column_stack([np.full(40, 0.86), np.full(40, 0.86)])
    visible[:14, 1] += off
    visible[14:, 1] = 0.0
    table = ScoreTable(np.arange(40) * 30, ("a", "b"), visible, np.ones((40, 2), bool))
    assert [s.camera for s in ShortestPath().select(table, frames=1200, rate=Fraction(30))] == ["a"]


def test_what_is_more_than_chance_is_worth_a_switch_as_before() -> None:
    visible = np.column_stack([np.full(40, 0.6), np.full(40, 0.86)])
    visible[14:, 1] = 0.0
    table = ScoreTable(np.arange(40) * 30, ("a", "b"), visible, np.ones((40, 2), bool))
    assert [s.camera for s in ShortestPath().select(table, frames=1200, rate=Fraction(30))] == ["b", "a"]


def test_a_camera_that_always_sees_a_little_more_is_shown() -> None:
    visible = np.column_stack([np.full(40, 0.85), np.full(40, 0.86)])
    table = ScoreTable(np.arange(40) * 30, ("a", "b"), visible, np.ones((40, 2), bool))
    assert [s.camera for s in ShortestPath().select(table, frames=1200, rate=Fraction(30))] == ["b"]


@given(st.integers(0, 2**32), st.sampled_from([0.0, 0.01, 0.03, 0.2]))
def test_what_is_believed_keeps_the_cameras_order_and_the_best(seed: int, error: float) -> None:
    rng = np.random.default_rng(seed)
    visible, usable = rng.random((9, 4)), rng.random((9, 4)) < 0.7
    found = believed(visible, usable, error)
    assert (np.argsort(found, axis=1) == np.argsort(visible, axis=1)).all()
    best = np.where(usable, visible, 0).max(axis=1)
    np.testing.assert_allclose(np.where(usable, found, 0).max(axis=1), best)
    assert ((visible - 1e-9 <= found) & (found <= visible + error + 1e-9)).all()
    if error == 0:
        np.testing.assert_allclose(found, visible)


def test_fixed_names_what_there_is() -> None:
    table = ScoreTable(np.arange(3), ("a", "b"), np.ones((3, 2)), np.ones((3, 2), bool))
    with pytest.raises(UsageError, match="Choose one of a, b"):
        Fixed("c").select(table, frames=3, rate=Fraction(1))


def test_two_hours_of_samples_are_quick_enough_to_select_again() -> None:
    rng = np.random.default_rng(0)
    table = ScoreTable(np.arange(7200) * 30, tuple("abcde"), rng.random((7200, 5)), np.ones((7200, 5), bool))
    shots = ShortestPath().select(table, frames=7200 * 30, rate=Fraction(30))
    assert min(len(s.range) for s in shots) >= 60
