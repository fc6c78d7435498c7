"""Convex regions of most worth: unknown places are bridged, spurs cut off, slanted sides kept."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from mcsl_core.imaging.convex import convex_region
from mcsl_core.imaging.masks import Mask, convex_hull

SHAPE = (120, 200)


def slanted(angle: float) -> Mask:
    box = cv2.boxPoints(((100, 60), (80, 50), angle))
    return cv2.fillConvexPoly(np.zeros(SHAPE, np.uint8), np.round(box).astype(np.int32), 1) > 0


def overlap(a: Mask, b: Mask) -> float:
    return float((a & b).sum() / (a | b).sum())


def worth_of(mask: Mask) -> np.ndarray:
    return np.where(mask, 2, -2).astype(np.float32)


@pytest.mark.parametrize("angle", [0, 7, 23, 45, 80])
def test_a_slanted_field_is_found_from_far_outside(angle: float) -> None:
    true = slanted(angle)
    start = np.zeros(SHAPE, bool)
    start[5:115, 10:190] = True
    assert overlap(convex_region(worth_of(true), start), true) > 0.92


def test_a_hand_over_its_side_is_bridged_and_a_finger_beside_it_cut_off() -> None:
    true = slanted(10)
    worth = worth_of(true)
    worth[40:120, 90:112] = 0  # nothing is known below a hand that rests there
    finger = np.zeros(SHAPE, np.uint8)
    cv2.line(finger, (140, 60), (175, 50), 1, 7)
    worth[(finger > 0) & ~true] = 2
    found = convex_region(worth, convex_hull(worth > 0))
    assert overlap(found, true) > 0.85
    assert not found[:, 165:].any(), "the finger's tip"


def test_nothing_to_start_from_is_nothing() -> None:
    assert not convex_region(worth_of(slanted(0)), np.zeros(SHAPE, bool)).any()
