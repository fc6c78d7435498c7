"""Margins about movements, which the views of two may not share."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest

from mcsl_core.alignment.tracking.movement_views import _about
from mcsl_core.edl import Camera, Media, Movement
from mcsl_core.recording.footage import Footage
from mcsl_core.timing import FrameRange


@pytest.mark.parametrize("gap", [1, 2, 7, 15, 16, 40])
def test_margins_of_two_movements_do_not_overlap_and_stay_within_the_programme(gap: int) -> None:
    footage = Footage(
        [Camera("a", (Media("a.mp4", 100),), (320, 180), Fraction(25))], rate=Fraction(25), frames=100, base=Path()
    )
    first, second = Movement(FrameRange(3, 30)), Movement(FrameRange(30 + gap, 98))
    (low, high), (then, last) = (_about(each, (first, second), footage) for each in (first, second))
    assert 0 <= low <= 3
    assert high >= 29
    assert high < then <= 30 + gap
    assert 97 <= last <= 99
