"""Cameras found changed, written as overrides: just what is asked for is shown, and all other decisions stay."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction

import attrs
from hypothesis import given, settings
from hypothesis import strategies as st
from interchange_cuts import R, film, films

from mcsl_core.edl import Override
from mcsl_core.edl.resolve import resolve
from mcsl_core.interchange.changes import with_cameras
from mcsl_core.timing import FrameRange


def shown(edl):
    """Whom the programme shows, frame by frame."""
    return [decision.camera for piece, decision in resolve(edl) for _ in piece]


def test_other_decisions_stay_and_what_is_automatic_again_is_taken_back():
    edl = film(
        overrides=(Override(R(10, 90), camera="cam3", fill=False, note="n"), Override(R(0, 5), colour=False))
    ).edl
    new = with_cameras(edl, [(R(0, 33), "cam1"), (R(40, 50), "cam1")])
    assert new.overrides == (
        Override(R(10, 33), fill=False, note="n"),
        Override(R(33, 40), camera="cam3", fill=False, note="n"),
        Override(R(40, 50), fill=False, note="n"),
        Override(R(50, 90), camera="cam3", fill=False, note="n"),
        Override(R(0, 5), colour=False),
        Override(R(40, 50), camera="cam1"),
    )


def test_a_stretch_beside_one_that_says_the_same_makes_it_longer():
    edl = film(overrides=(Override(R(40, 50), camera="cam1"),)).edl
    assert with_cameras(edl, [(R(50, 60), "cam1")]).overrides == (Override(R(40, 60), camera="cam1"),)


@given(films(), st.data())
@settings(max_examples=60)
def test_overrides_show_just_what_is_asked_for(made, data):
    edl, names = made.edl, [camera.name for camera in made.edl.cameras]
    start = data.draw(st.integers(0, edl.frames - 1))
    stop = data.draw(st.integers(start + 1, edl.frames))
    camera = data.draw(st.sampled_from(names))
    new = with_cameras(edl, [(R(start, stop), camera)])
    expected = shown(edl)
    expected[start:stop] = [camera] * (stop - start)
    assert shown(new) == expected
    assert attrs.evolve(new, overrides=edl.overrides) == edl


def test_where_nothing_changed_the_edl_is_as_it_was():
    edl = film(overrides=(Override(R(10, 20), camera="cam2"), Override(R(20, 30), camera="cam2"))).edl
    assert with_cameras(edl, ()) is edl


def test_many_overrides_take_time_that_grows_with_them():
    """Cost: counted in what is compared, not in seconds: every override is asked for its range a few times."""
    asked = Counter()

    class Counting(FrameRange):
        def intersection(self, other):
            asked["intersection"] += 1
            return super().intersection(other)

    count = 10_000
    overrides = tuple(Override(Counting(10 * n, 10 * n + 5), camera="cam2") for n in range(count))
    edl = film(Fraction(25), 10 * count, overrides=overrides).edl
    changes = [(Counting(10 * n, 10 * n + 5), "cam3") for n in range(0, count, 4)]
    new = with_cameras(edl, changes)
    assert shown(new)[:45] == [*["cam3"] * 5, *(["cam1"] * 5 + ["cam2"] * 5) * 3, *["cam1"] * 5, *["cam3"] * 5]
    assert asked["intersection"] < 10 * count
