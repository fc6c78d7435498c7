"""Masks read at points."""

from __future__ import annotations

import numpy as np

from mcsl_core.imaging.masks import mask_at


def test_a_mask_is_read_at_the_nearest_pixel_and_is_not_set_outside() -> None:
    mask = np.zeros((3, 5), bool)
    mask[0, 0] = mask[2, 4] = True
    points = np.array([[0, 0], [0.4, -0.4], [-0.6, 0], [4, 2], [4.4, 1.6], [4.6, 2], [4, 2.6], [2, 1], [1e9, -1e9]])
    assert mask_at(mask, points).tolist() == [True, True, False, True, True, False, False, False, False]
    assert mask_at(mask, np.zeros((0, 2))).shape == (0,)
