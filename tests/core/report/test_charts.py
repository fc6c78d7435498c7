"""The report's curves, bars and ticks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcsl_core.report.charts import BINS, HEIGHT, WIDTH, bar, binned, curve_path, short_time, time_ticks


def points_of(path: str) -> list[list[tuple[float, float]]]:
    return [
        [(float(x), float(y)) for x, y in (pair.split() for pair in run.rstrip("Z").split("L"))]
        for run in path.split("M")[1:]
    ]


def test_a_curve_breaks_where_there_is_no_data() -> None:
    x, y = np.arange(6) * 20.0, np.array([0, 0.5, np.nan, 1, np.nan, 0.25])
    first, second, third = points_of(curve_path(x, y, 100, 0, 1))
    assert first == [(0, HEIGHT), (200, HEIGHT / 2)]
    assert second[0] == (600, 0)
    assert len(second) == len(third) == 2, "a point alone is drawn as a dash"
    closed = points_of(curve_path(x, y, 100, 0, 1, closed=True))
    assert closed[0][-2:] == [(200, HEIGHT), (0, HEIGHT)]
    assert curve_path(x, np.full(6, np.nan), 100, 0, 1) == ""


def test_hours_of_samples_become_few_points_that_keep_their_peaks() -> None:
    frames = np.arange(20_000) * 30
    values = np.zeros(20_000)
    values[12_345] = 1
    values[:100] = np.nan
    x, y = binned(frames, values, 600_000, keep="max")
    assert len(x) == BINS
    assert np.nanmax(y) == 1
    assert np.isnan(y[0])
    assert np.nanmax(binned(frames, values, 600_000)[1]) == pytest.approx(1 / 50)


@pytest.mark.parametrize(
    ("seconds", "texts"),
    [
        (4, ["0:00", "0:01", "0:02", "0:03"]),
        (600, ["0:00", "2:00", "4:00", "6:00", "8:00"]),
        (7200, ["0:00:00", "0:30:00", "1:00:00", "1:30:00"]),
    ],
)
def test_ticks_are_round_and_few(seconds: float, texts: list[str]) -> None:
    assert [t.text for t in time_ticks(seconds)] == texts


@given(st.floats(0.04, 200_000))
def test_ticks_lie_on_the_axis(seconds: float) -> None:
    ticks = time_ticks(seconds)
    assert 1 <= len(ticks) <= 14
    assert all(0 <= float(t.at) <= 96 for t in ticks)
    assert short_time(3599.6) == "1:00:00"


@given(st.integers(1, 10**6).flatmap(lambda n: st.tuples(st.just(n), st.integers(0, n - 1))), st.integers(1, 10**6))
def test_bars_stay_inside_and_can_be_seen(bar_at: tuple[int, int], length: int) -> None:
    frames, start = bar_at
    made = bar(start, min(start + length, frames), frames, "", "")
    assert float(made.x) >= 0
    assert float(made.width) >= 1.5
    assert float(made.x) + float(made.width) <= WIDTH + 0.011
