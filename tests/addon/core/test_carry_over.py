"""What stands where an editor's strip lies, and what is left to build."""

from __future__ import annotations

import pytest

from blender_addon.core.carry_over import Part, Place, main_part, parts_of, uncovered
from mcsl_core.timing import FrameRange as R
from mcsl_core.timing import ranges_of_spans

A, B = Place(R(0, 40), "a", 0), Place(R(40, 60), "b", 40)


@pytest.mark.parametrize(
    ("start", "stop", "slip", "parts"),
    [
        (0, 60, 0, [(0, 40, A), (40, 60, B)]),
        (12, 24, 0, [(12, 24, A)]),
        (38, 42, 0, [(38, 40, A), (40, 42, B)]),
        (-5, 3, 0, [(-5, 0, None), (0, 3, A)]),
        (55, 70, 0, [(55, 60, B), (60, 70, None)]),
        (70, 80, 0, [(70, 80, None)]),
        (-5, 55, -5, [(-5, 35, A), (35, 55, B)]),  # slid: the files' ends slid with it
        (30, 50, 5, [(30, 45, A), (45, 50, B)]),
    ],
)
def test_parts_tile_the_strip(start, stop, slip, parts):
    assert list(parts_of(start, stop, [A, B], slip)) == [Part(*part) for part in parts]


def test_a_gap_between_files_is_a_part_of_its_own():
    late = Place(R(50, 60), "b", 50)
    assert [(p.start, p.stop, p.place) for p in parts_of(30, 60, [A, late])] == [
        (30, 40, A),
        (40, 50, None),
        (50, 60, late),
    ]


def test_what_must_stay_whole_gets_what_stands_over_most_of_it():
    assert main_part(30, 60, [A, B]) == (Part(30, 60, B),)
    assert main_part(-20, 5, [A, B]) == (Part(-20, 5, A),)
    assert main_part(70, 80, [A, B]) == (Part(70, 80, None),)


def test_what_no_strip_covers_is_built():
    assert uncovered([A, B], []) == ((R(0, 40), A), (R(40, 60), B))
    assert uncovered([A, B], [(10, 50)]) == ((R(0, 10), A), (R(50, 60), B))
    assert uncovered([A, B], [(-5, 45), (44, 99)]) == ()


def test_ranges_are_joined_and_begin_with_the_programme():
    assert ranges_of_spans([(-9, -3), (-3, 5), (5, 9), (20, 30)]) == (R(0, 9), R(20, 30))
