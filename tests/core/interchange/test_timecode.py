"""Timecode against opentimelineio's, which is another program's."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st
from interchange_cuts import RATES
from interchange_readers import otio

from mcsl_core.errors import UsageError
from mcsl_core.interchange.timecode import count_of, is_broadcast, label, may_drop

DROP = [Fraction(30000, 1001), Fraction(60000, 1001)]


def theirs(count, rate, *, drop):
    return otio.opentime.to_timecode(otio.opentime.RationalTime(count, float(rate)), float(rate), drop)


@given(st.sampled_from(RATES), st.integers(0, 23 * 3600 * 60))
def test_labels_are_those_of_another_program_and_come_back(rate, count):
    count %= 23 * 3600 * 24
    text = label(count, rate, drop=False)
    assert text == theirs(count, rate, drop=False)
    assert count_of(text, rate) == (count, False)


@given(st.sampled_from(DROP), st.integers(0, 23 * 3600 * 24))
def test_drop_frame_labels_are_those_of_another_program_and_come_back(rate, count):
    text = label(count, rate, drop=True)
    assert text == theirs(count, rate, drop=True)
    assert count_of(text, rate) == (count, True)


@pytest.mark.parametrize("rate", DROP)
def test_drop_frame_at_the_borders_of_minutes(rate):
    minute = 60 * round(rate)
    for count in (
        n * minute - dropped + near for n in range(24) for dropped in range(0, 100, 2) for near in (-1, 0, 1)
    ):
        if count >= 0:
            assert label(count, rate, drop=True) == theirs(count, rate, drop=True)


def test_drop_frame_agrees_with_the_clock():
    hour = round(3600 * Fraction(30000, 1001))
    assert label(hour, Fraction(30000, 1001), drop=True) == "01:00:00;00"
    assert label(1799, Fraction(30000, 1001), drop=True) == "00:00:59;29"


@pytest.mark.parametrize("rate", [rate for rate in RATES if rate not in DROP])
def test_there_is_drop_frame_at_2997_and_5994_alone(rate):
    assert not may_drop(rate)
    with pytest.raises(UsageError, match="does not fit"):
        count_of("01:00:00;00", rate)


@pytest.mark.parametrize("text", ["1h", "01:00:00:30", "24:00:00:00", "00:01:00;00", "-1:00:00:00"])
def test_what_is_no_timecode_is_refused(text):
    with pytest.raises(UsageError):
        count_of(text, Fraction(30000, 1001))


def test_rates_that_editors_know():
    assert all(is_broadcast(rate) for rate in RATES)
    assert not any(is_broadcast(rate) for rate in (Fraction(25, 2), Fraction(2997, 100), Fraction(1000)))
