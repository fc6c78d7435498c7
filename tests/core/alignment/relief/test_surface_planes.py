"""Planes under hands are told of the surface and not of the hand."""

from __future__ import annotations

import numpy as np
from hand_over_slope import PROJECTIONS, slope, under_hand

from mcsl_core.alignment.relief.surface_planes import surface_pairs
from mcsl_core.imaging.geometry import project

FIELD = np.zeros((270, 480), bool)
FIELD[90:180, 160:320] = True


def test_planes_under_hands_are_told_of_the_surface_and_not_of_the_hand() -> None:
    pairs = surface_pairs(under_hand(), "ref", FIELD)
    assert pairs.keys() == {("ref", "b"), ("ref", "c")}
    for (_, name), matches in pairs.items():
        scene = np.column_stack([matches.a, slope(matches.a[:, 0])])
        in_field = matches.weight == 1
        assert in_field.sum() > 300
        off = np.hypot(*(project(PROJECTIONS[name], scene) - matches.b)[in_field].T)
        assert np.median(off) < 0.3
        assert off.max() < 2
        assert (~in_field).sum() > 300
        assert matches.weight[~in_field].sum() < 0.001 * in_field.sum(), "they say that the pair is tied, not how"
