"""The minimum shot length: in whole frames, and as a selector's guard hands it on."""

from __future__ import annotations

from fractions import Fraction

import attrs
import pytest

from mcsl_core.errors import PluginError
from mcsl_core.hooks.registry import discover
from mcsl_core.selection.protocol import MIN_SHOT_S, least_frames
from mcsl_core.selection.selectors import LeastOccluded, ShortestPath

NTSC = Fraction(30000, 1001)


@pytest.mark.parametrize(
    ("seconds", "rate", "frames"),
    [(2, 25, 50), (2, NTSC, 60), (1.5, 25, 38), (1.46, 25, 37), (0, 25, 1), (0.1, 30, 3), (1.001, NTSC, 30)],
)
def test_so_many_frames_last_as_long_and_one_fewer_does_not(seconds: float, rate: Fraction, frames: int) -> None:
    assert least_frames(seconds, Fraction(rate)) == frames


def test_what_a_selector_promises_is_handed_on_and_checked() -> None:
    offer = discover().choose("selector")

    def promised(selector: object) -> float:
        return attrs.evolve(offer, implementation=selector).checked.min_shot_s

    assert promised(ShortestPath(min_shot_s=7)) == 7
    assert promised(LeastOccluded()) == MIN_SHOT_S
    for wrong in (-1, float("nan"), "long", None):
        with pytest.raises(PluginError, match="min_shot_s"):
            promised(attrs.make_class("Wrong", {"min_shot_s": attrs.field(default=wrong)})())
