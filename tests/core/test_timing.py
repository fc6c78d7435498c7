"""Exact time: rates, frames and moments, ranges, tilings."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import ranges, rates, tilings

from mcsl_core.timing import (
    FrameRange,
    check_tiles,
    cut_points,
    format_rate,
    format_time,
    merge_equal,
    parse_rate,
    parse_time,
    without,
)

R = FrameRange


@given(rates)
def test_a_rate_reads_back(rate):
    assert parse_rate(format_rate(rate)) == rate


@pytest.mark.parametrize(
    ("text", "rate"),
    [
        ("25", Fraction(25)),
        (" 30000/1001 ", Fraction(30000, 1001)),
        ("29.97", Fraction(30000, 1001)),
        ("23.976", Fraction(24000, 1001)),
        ("23.98", Fraction(24000, 1001)),
        ("59.94", Fraction(60000, 1001)),
        ("12.5", Fraction(25, 2)),
        ("50/2", Fraction(25)),
    ],
)
def test_rates_people_write(text, rate):
    assert parse_rate(text) == rate


@pytest.mark.parametrize(
    "text", ["", "fast", "0", "0/5", "25/0", "-25", "1e3", "1e999999999", "inf", "nan", "3_0", "٣"]
)
def test_what_is_no_rate_is_refused(text):
    with pytest.raises(ValueError, match=r"expected a rate such as|must be positive"):
        parse_rate(text)


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0, "0:00:00.0"),
        (59.96, "0:01:00.0"),
        (3599.99, "1:00:00.0"),
        (-1.25, "-0:00:01.2"),
        (Fraction(36061, 10), "1:00:06.1"),
    ],
)
def test_time_for_people(seconds, text):
    assert format_time(seconds) == text


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("1:02:03.5", Fraction(7447, 2)),
        ("00:00:01,5", Fraction(3, 2)),
        (" 2:30 ", 150),
        ("150", 150),
        ("0:90", 90),
        (".5", Fraction(1, 2)),
        ("00:00:03.003000000", Fraction(3003, 1000)),
        ("1.2000000000000002", Fraction(12000000000000002, 10**16)),  # as Python writes 1.1 + 0.1
    ],
)
def test_times_people_and_files_write(text, seconds):
    assert parse_time(text) == seconds


@pytest.mark.parametrize(
    "text",
    [
        *("", ":", "1:", "::1", "1:-30", "-1", "+1", "1/3", "1_0", "nan", "inf", "1e3", "1e999999999"),
        *("0:0:1e999999999", "1:2:3:4", "1.5:30", "1 2", "٣", "9" * 5000, "0x1", "1.2.3", "soon"),
    ],
)
def test_what_is_no_time_is_refused_at_once(text):
    with pytest.raises(ValueError, match="is no time"):
        parse_time(text)


def test_a_range_is_half_open_and_never_empty():
    piece = R(3, 6)
    assert list(piece) == [3, 4, 5]
    assert len(piece) == 3
    assert [f in piece for f in (2, 3, 5, 6)] == [False, True, True, False]
    assert str(piece) == "[3, 6)"
    for start, stop in ((3, 3), (4, 3), (-1, 3)):
        with pytest.raises(ValueError, match="a range"):
            R(start, stop)


def test_a_range_takes_whole_numbers_of_any_kind_and_nothing_else():
    piece = R(np.int64(3), np.int32(6))
    assert (type(piece.start), type(piece.stop)) == (int, int)
    for wrong in (1.0, "1", np.float64(1)):
        with pytest.raises(TypeError):
            R(0, wrong)  # pyright: ignore[reportArgumentType]


@given(ranges(40), ranges(40))
def test_intersection_is_the_frames_in_both(a, b):
    both = a.intersection(b)
    assert (list(both) if both else []) == sorted(set(a) & set(b))


@given(st.integers(1, 60).flatmap(lambda n: st.tuples(st.just(n), tilings(n))))
def test_a_tiling_passes_and_any_other_does_not(drawn):
    frames, pieces = drawn
    check_tiles(pieces, frames, "shots")
    wrong = [pieces[1:], pieces[:-1], [*pieces, pieces[-1]], [R(0, 1), *pieces], pieces[::-1] if pieces[1:] else []]
    for others in wrong:
        with pytest.raises(ValueError, match="shots must tile"):
            check_tiles(others, frames, "shots")
    with pytest.raises(ValueError, match=rf"they end at frame {frames}"):
        check_tiles(pieces, frames + 1, "shots")


@given(st.lists(ranges(50), max_size=5), st.integers(1, 40))
def test_between_two_cut_points_no_range_begins_or_ends(pieces, frames):
    points = cut_points(frames, pieces)
    assert points == sorted(set(points))
    assert (points[0], points[-1]) == (0, frames)
    ends = {p for piece in pieces for p in (piece.start, piece.stop) if 0 < p < frames}
    assert set(points[1:-1]) == ends


@given(st.lists(st.tuples(st.integers(1, 4), st.booleans()), max_size=12))
def test_merging_keeps_every_frames_value_and_leaves_no_equal_neighbours(steps):
    pieces, at = [], 0
    for length, value in steps:
        pieces.append((R(at, at + length), value))
        at += length
    merged = merge_equal(pieces)
    assert [v for r, v in merged for _ in r] == [v for r, v in pieces for _ in r]
    assert all(a[1] != b[1] for a, b in zip(merged, merged[1:], strict=False))


def test_pieces_apart_are_not_merged():
    assert len(merge_equal([(R(0, 2), 1), (R(3, 4), 1)])) == 2


@given(st.lists(ranges(40), max_size=6), st.lists(ranges(40), max_size=6))
def test_without_leaves_the_frames_that_no_hole_has(pieces, holes):
    found = without(pieces, holes)
    assert {n for piece in found for n in piece} == {n for p in pieces for n in p} - {n for h in holes for n in h}
    assert all(a.stop < b.start for a, b in zip(found, found[1:], strict=False)), "as few as can be"
