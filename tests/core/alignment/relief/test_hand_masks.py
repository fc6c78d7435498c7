"""A hand that rests lies in every aligned view where its own height puts it."""

from __future__ import annotations

import numpy as np
import pytest
from hand_over_slope import HAND, HIGH, PROJECTIONS, SIZE, slope, under_hand

from mcsl_core.alignment.aligned_views import AlignedPose
from mcsl_core.alignment.relief.hand_masks import hand_masks
from mcsl_core.imaging.geometry import project, transform_points

NO_FIELD = np.zeros((270, 480), bool)


def test_a_resting_hand_lies_in_every_view_where_its_height_puts_it() -> None:
    planes = {name: np.linalg.inv(p[:, :3]) for name, p in PROJECTIONS.items()}
    planes["tied by points alone"] = np.eye(3)
    aligned = AlignedPose((480, 270), "ref", planes, dict.fromkeys(planes, SIZE), NO_FIELD)
    masks = hand_masks(under_hand(), aligned)
    np.testing.assert_array_equal(masks.pop("tied by points alone"), masks["ref"])
    assert masks.keys() == PROJECTIONS.keys()
    place = np.array([450.0, 250.0])  # a node of the hand
    for name, mask in masks.items():
        seen = project(PROJECTIONS[name], np.array([[*place, slope(place[0]) + HIGH]]))
        x, y = transform_points(planes[name], seen)[0] / 2
        assert mask[round(y), round(x)]
        assert mask.sum() == pytest.approx(HAND.sum() * 25, rel=0.25)
