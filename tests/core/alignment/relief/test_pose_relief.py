"""What a pose's relief says of the surface under hands."""

from __future__ import annotations

from hand_over_slope import HAND, under_hand


def test_under_a_hand_the_surface_is_carried_on_and_ties_nothing() -> None:
    seen = under_hand().seen
    assert not seen.confidence[HAND].any()
    assert seen.confidence[5, 5] == 0.9
