"""What stillness is judged by, on pictures whose motion is known."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from mcsl_core.edl import Movement
from mcsl_core.movement import Stillness, _apart, share_in_place, stillness, texture
from mcsl_core.timing import FrameRange


def cloth(seed: int = 0) -> np.ndarray:
    """A (360, 640, 3) picture of folded, woven cloth, faint as drapes are."""
    rng = np.random.default_rng(seed)
    folds = cv2.resize(rng.normal(0, 1, (12, 20)).astype(np.float32), (640, 360), interpolation=cv2.INTER_CUBIC)
    weave = cv2.GaussianBlur(rng.normal(0, 1, (360, 640)).astype(np.float32), (0, 0), 1.5)
    grey = 90 + 18 * folds + 25 * weave
    return cv2.merge([grey * 0.5, grey, grey * 0.6]).clip(0, 255).astype(np.uint8)


def noisy(picture: np.ndarray, seed: int) -> np.ndarray:
    return (picture + np.random.default_rng(seed).normal(0, 1.5, picture.shape)).clip(0, 255).astype(np.uint8)


def share(before: np.ndarray, after: np.ndarray) -> float:
    return share_in_place(texture(noisy(before, 1)), texture(noisy(after, 2)))


def test_a_still_view_is_in_place_whatever_the_light_does() -> None:
    picture = cloth()
    assert share(picture, picture) > 0.95
    assert share(picture, (picture * 0.7 + 10).astype(np.uint8)) > 0.9


@pytest.mark.parametrize("moved_px", [4, 9, 40])
def test_a_view_that_moved_is_not_in_place(moved_px: int) -> None:
    shift = np.float32([[1, 0, moved_px], [0, 1, moved_px / 2]])
    assert share(cloth(), cv2.warpAffine(cloth(), shift, (640, 360), borderMode=cv2.BORDER_REFLECT)) < 0.05


def test_a_turn_of_one_degree_is_a_movement() -> None:
    turn = cv2.getRotationMatrix2D((320, 180), 1.0, 1.0)
    assert share(cloth(), cv2.warpAffine(cloth(), turn, (640, 360), borderMode=cv2.BORDER_REFLECT)) < 0.3


def test_a_head_over_most_of_the_view_is_no_movement() -> None:
    covered = cloth()
    cv2.circle(covered, (300, 180), 200, (140, 90, 40), -1)
    assert Stillness().still < share(cloth(), covered) < 0.6


def test_a_blank_sheet_says_nothing() -> None:
    assert math.isnan(share_in_place(texture(np.full((360, 640, 3), 120, np.uint8)), texture(cloth())))
    assert math.isnan(stillness([math.nan, math.nan]))


def test_one_frozen_stream_does_not_hide_a_movement_and_three_heads_fake_none() -> None:
    assert stillness([1.0, 0.02, 0.03, 0.01, 0.0]) < Stillness().still
    assert stillness([0.05, 0.02, 0.6, 0.5, 0.04]) > Stillness().still


def test_movements_that_overlap_after_timing_become_one() -> None:
    spans = [FrameRange(100, 160), FrameRange(150, 200), FrameRange(300, 310)]
    joined = _apart([Movement(s, 0.5) for s in spans])
    assert [m.range for m in joined] == [FrameRange(100, 200), FrameRange(300, 310)]
