"""Styles against every way there is to cut a short recording, and what each of their wishes does to a longer one."""

from __future__ import annotations

import time
from fractions import Fraction
from itertools import groupby, product
from pathlib import Path

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcsl_switching_style import CALM, CLOSE, TEACHING, OwnStyle, Style, StyleSelector, load_style
from mcsl_switching_style.planning import best_path
from mcsl_switching_style.style import costs_of

from mcsl_core.hooks import InputError, ScoreTable, UsageError, discover, sample_borders

RATE = 10


def worth_of(style: Style, table: ScoreTable, frames: int, cameras: tuple[int, ...]) -> float | None:
    """What one way to cut is worth in seconds; None where a shot is too short. As the README tells it, shot by shot."""
    middles = (table.frames[:-1] + table.frames[1:] + 1) // 2
    borders = [0, *middles.tolist(), frames]
    preferred = {"": -1, "first": 0}.get(style.preferred, -1)
    shots = []
    at = 0
    for camera, run in groupby(cameras):
        count = len(list(run))
        shots.append((camera, at, at + count))
        at += count
    total = 0.0
    for number, (camera, start, stop) in enumerate(shots):
        length_s = (borders[stop] - borders[start]) / RATE
        if length_s < style.min_shot_s - 1e-9 and len(shots) > 1:
            return None
        for i in range(start, stop):
            seconds = (borders[i + 1] - borders[i]) / RATE
            seen = table.visible[i, camera] + (style.preference if camera == preferred else 0)
            total += seconds * seen
        if length_s > style.max_shot_s:
            total -= style.long_cost * (length_s - style.max_shot_s)
        if stop < len(cameras):
            total -= style.cut_cost_s
            if table.visible[stop, camera] >= style.hold:
                total -= style.hold_cost_s
            goes_back = number > 0 and shots[number - 1][0] == shots[number + 1][0]
            if goes_back and length_s < style.return_s - 1e-9:
                total -= style.return_cost_s
    return total


styles = st.builds(
    Style,
    min_shot_s=st.sampled_from([0.0, 1.0, 2.0, 3.5]),
    max_shot_s=st.sampled_from([float("inf"), 0.0, 2.0, 4.0]),
    long_cost=st.sampled_from([0.0, 0.2, 2.0]),
    cut_cost_s=st.sampled_from([0.0, 0.3, 1.0]),
    preferred=st.sampled_from(["", "first"]),
    preference=st.sampled_from([0.0, 0.3]),
    return_s=st.sampled_from([0.0, 2.0, 5.0]),
    return_cost_s=st.sampled_from([0.0, 0.7, 3.0]),
    hold=st.sampled_from([0.0, 0.5, 1.0]),
    hold_cost_s=st.sampled_from([0.0, 0.6]),
)


@st.composite
def tables(draw) -> tuple[ScoreTable, int]:
    samples, cameras = draw(st.sampled_from([(1, 1), (4, 1), (7, 2), (9, 2), (6, 3), (5, 4)]))
    gaps = draw(st.lists(st.integers(4, 16), min_size=samples, max_size=samples))
    frames = np.cumsum(gaps) - gaps[0]
    seen = draw(st.lists(st.integers(0, 10), min_size=samples * cameras, max_size=samples * cameras))
    visible = np.array(seen, float).reshape(samples, cameras) / 10
    names = tuple(f"cam{n + 1}" for n in range(cameras))
    return ScoreTable(frames, names, visible, np.ones(visible.shape, bool)), int(frames[-1]) + draw(st.integers(1, 12))


@settings(max_examples=250)
@given(styles, tables())
def test_no_way_to_cut_is_worth_more(style: Style, given_: tuple[ScoreTable, int]) -> None:
    table, frames = given_
    found = tuple(best_path(costs_of(style, table, sample_borders(table, frames), RATE)).tolist())
    ways = product(range(len(table.cameras)), repeat=len(table.frames))
    values = [value for way in ways if (value := worth_of(style, table, frames, way)) is not None]
    assert worth_of(style, table, frames, found) == pytest.approx(max(values), abs=1e-9)


def table_of(*rows: str) -> ScoreTable:
    """A row a camera, a digit a second: tenths of the field, "-" without data, "x" where it may not be used."""
    visible = np.array([[np.nan if c in "-x" else int(c) / 9 for c in row] for row in rows]).T
    usable = np.array([[c != "x" for c in row] for row in rows]).T
    cameras = tuple(f"cam{n + 1}" for n in range(len(rows)))
    return ScoreTable(np.arange(len(visible)) * RATE + RATE // 2, cameras, visible, usable)


def cut(table: ScoreTable, style: Style | str) -> str:
    """The camera of every second, a digit each, from a style or from the plugin of that name."""
    frames = len(table.frames) * RATE
    selector = StyleSelector("t", style) if isinstance(style, Style) else discover().choose("selector", style).checked
    shots = selector.select(table, frames=frames, rate=Fraction(RATE))
    return "".join(table.cameras[table.cameras.index(s.camera)][-1] * (len(s.range) // RATE) for s in shots)


PLAIN = Style(min_shot_s=1, cut_cost_s=0.1)


def test_the_preferred_camera_is_shown_unless_it_is_blocked() -> None:
    table = table_of("777777770000007777", "999999999999999999")
    assert cut(table, PLAIN) == "2" * 18
    assert cut(table, attrs.evolve(PLAIN, preferred="cam1", preference=0.3)) == "111111112222221111"


def test_the_minimum_is_kept_and_a_longer_shot_than_the_maximum_costs() -> None:
    table = table_of("909090909090", "090909090909")
    assert cut(table, Style(min_shot_s=1, cut_cost_s=0)) == "121212121212"
    found = cut(table, Style(min_shot_s=4, cut_cost_s=0))
    assert min(len(list(run)) for _, run in groupby(found)) >= 4
    same = table_of("999999999999", "888888888888")
    assert cut(same, PLAIN) == "1" * 12
    lengths = [len(list(run)) for _, run in groupby(cut(same, attrs.evolve(PLAIN, max_shot_s=4, long_cost=1)))]
    assert max(lengths) <= 4


def test_the_minimum_is_promised_to_mcsl(tmp_path: Path) -> None:
    promised = {name: discover().choose("selector", f"style-{name}").checked.min_shot_s for name in ("calm", "close")}
    assert promised == {"calm": 6, "close": 1.5}
    path = tmp_path / "mine.toml"
    path.write_text("min_shot_s = 8\n", "utf-8")
    assert OwnStyle(path).min_shot_s == 8


def test_back_and_forth_costs_but_a_third_camera_does_not() -> None:
    two = table_of("999999000099999", "000000999900000")
    there_and_back = "111111222211111"
    assert cut(two, attrs.evolve(PLAIN, return_s=6, return_cost_s=1)) == there_and_back, "worth it"
    assert cut(two, attrs.evolve(PLAIN, return_s=20, return_cost_s=9)) == "1" * 15
    assert cut(two, attrs.evolve(PLAIN, return_s=4, return_cost_s=9)) == there_and_back, "four seconds are not soon"
    three = table_of("999999000099999", "000000999900000", "000000000088888")
    assert cut(three, attrs.evolve(PLAIN, min_shot_s=4, return_s=20, return_cost_s=9)) == "111111222233333"


def test_a_camera_is_held_while_it_shows_the_field() -> None:
    table = table_of("999966666222", "555599999999")
    assert cut(table, PLAIN) == "111122222222"
    assert cut(table, attrs.evolve(PLAIN, hold=0.6, hold_cost_s=3)) == "111111111222"


def test_an_unusable_camera_is_left_at_once_and_no_data_holds_nobody() -> None:
    table = table_of("9999xxxx9999", "000000000000")
    style = attrs.evolve(PLAIN, hold=0.1, hold_cost_s=50, preferred="cam1", preference=1)
    assert cut(table, style) == "111122221111"
    assert cut(table_of("9999--------", "9999-----999"), PLAIN) == "1" * 12


def test_the_three_styles_differ_as_their_names_say() -> None:
    """Heads over cam1 and cam2 for three to nine seconds, now and then; cam2 always sees a little more."""
    rng = np.random.default_rng(3)
    seen = np.tile([0.85, 0.93, 0.8], (300, 1))
    for camera in (0, 1):
        for start in rng.choice(290, 14, replace=False):
            seen[start : start + rng.integers(3, 10), camera] = 0.15
    table = ScoreTable(np.arange(300) * RATE, ("cam1", "cam2", "cam3"), seen, np.ones(seen.shape, bool))
    found = {name: cut(table, f"style-{name}") for name in ("calm", "close", "teaching")}
    runs = {name: [len(list(run)) for _, run in groupby(way)] for name, way in found.items()}
    assert len(runs["calm"]) < len(runs["teaching"]) < len(runs["close"])
    assert min(runs["calm"]) >= 6
    assert found["teaching"].count("1") > 150 > found["close"].count("1")
    visible = {n: np.mean([seen[i, int(c) - 1] for i, c in enumerate(way)]) for n, way in found.items()}
    assert visible["close"] > visible["calm"] > 0.75


def test_time_grows_with_the_recordings_length_not_with_its_square() -> None:
    rng = np.random.default_rng(1)
    spent = []
    for hours in (0.25, 1):
        seen = np.repeat(rng.random((round(360 * hours), 5)), 10, axis=0)
        table = ScoreTable(np.arange(len(seen)) * RATE, tuple("abcde"), seen, np.ones(seen.shape, bool))
        costs = costs_of(CALM, table, sample_borders(table, len(seen) * RATE), RATE)
        began = time.process_time()
        best_path(costs)
        spent.append(time.process_time() - began)
    assert spent[1] < 8 * spent[0]


def test_a_style_of_ones_own_is_read_from_the_file_that_the_environment_names(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('base = "teaching"\npreferred = "cam2"\nmin_shot_s = 8\n', "utf-8")
    assert load_style(path) == attrs.evolve(TEACHING, preferred="cam2", min_shot_s=8.0)
    assert "style-own" not in {o.name for o in discover().offers}
    monkeypatch.setenv("MCSL_STYLE", str(path))
    table = table_of("77777777777", "77777777777")
    assert cut(table, "style-own") == "2" * 11
    path.write_text('preferred = "cam7"\n', "utf-8")
    with pytest.raises(UsageError, match=r"prefers camera 'cam7', which is not there. Name one of cam1, cam2"):
        cut(table, "style-own")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("min_shot_s = -1", "min_shot_s"),
        ('min_shot_s = "long"', "min_shot_s is 'long', expected a number"),
        ("hold = 1.5", "hold"),
        ("pace = 3", "pace"),
        ("preferred = 2", "preferred is 2, expected a text"),
        ('base = "wild"', "expected one of calm, close, teaching"),
        ("hold = ", "is not TOML"),
        ("base = [1]", "base is [1], expected one of"),
    ],
)
def test_a_wrong_style_is_refused_with_what_is_wrong(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(text, "utf-8")
    with pytest.raises(InputError) as caught:
        OwnStyle(path).select(table_of("99", "99"), frames=20, rate=Fraction(RATE))
    assert str(path) in str(caught.value)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_presets_are_what_the_readme_says() -> None:
    page = (Path(__file__).parents[1] / "README.md").read_text("utf-8")
    for setting in attrs.fields(Style):
        row = next(line for line in page.splitlines() if line.startswith(f"| `{setting.name}` |"))
        cells = [cell.strip() for cell in row.split("|")[2:5]]
        for cell, style in zip(cells, (CALM, CLOSE, TEACHING), strict=True):
            value = getattr(style, setting.name)
            assert cell == (f'"{value}"' if isinstance(value, str) else f"{value:g}"), setting.name
