"""Consensus on views whose truth is plain."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from mcsl_core.alignment.aligned_views import AlignedPose
from mcsl_core.occlusion.consensus import Consensus


def test_a_head_that_stays_before_one_camera_does_not_become_the_field() -> None:
    rng = np.random.default_rng(2)
    size = (480, 270)
    cloth = cv2.GaussianBlur(rng.integers(0, 255, (270, 480, 3)).astype(np.uint8), (0, 0), 15)
    cloth = cv2.normalize(cloth, None, 40, 200, cv2.NORM_MINMAX)  # pyright: ignore
    cameras = [f"cam{n}" for n in range(4)]
    field = np.zeros((270, 480), bool)
    field[70:200, 150:330] = True
    aligned = AlignedPose(size, "cam0", dict.fromkeys(cameras, np.eye(3)), dict.fromkeys(cameras, size), field)
    hidden = cloth.copy()
    cv2.rectangle(hidden, (140, 60), (240, 210), (10, 10, 240), -1)  # over half of the field, all the time
    samples = [aligned.views({c: hidden if c == "cam2" else cloth for c in cameras})] * 12
    scores = Consensus().scorer(aligned, samples).score(samples[0])
    assert min(scores[c] for c in cameras if c != "cam2") > 0.95
    assert scores["cam2"] == pytest.approx(0.5, abs=0.1)


def test_under_a_hand_that_rests_the_field_is_not_seen() -> None:
    """All cameras show the same there: nothing but its height, which the pose knows, tells it from the patient."""
    size, cameras = (480, 270), ("cam0", "cam1", "cam2")
    cloth = cv2.GaussianBlur(np.random.default_rng(3).integers(0, 255, (270, 480, 3)).astype(np.uint8), (0, 0), 9)
    field, hand = np.zeros((270, 480), bool), np.zeros((270, 480), bool)
    field[70:200, 150:330] = True
    hand[60:220, 140:195] = True  # a quarter of the field
    sizes = dict.fromkeys(cameras, size)
    aligned = AlignedPose(size, "cam0", dict.fromkeys(cameras, np.eye(3)), sizes, field, {"cam1": hand})
    samples = [aligned.views(dict.fromkeys(cameras, cloth))] * 12
    scores = Consensus().scorer(aligned, samples).score(samples[0])
    assert scores["cam0"] > 0.95
    assert scores["cam2"] > 0.95
    assert scores["cam1"] == pytest.approx(0.75, abs=0.05)
