"""Degree of occlusion and clear frames, against the paper's words."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mcsl_core.alignment.clear_frames import ClearFrames, degree_of_occlusion, field_area
from mcsl_core.imaging.masks import main_region


def test_doo_is_the_papers_formula() -> None:
    assert degree_of_occlusion([0.2, 0.2, 0.2]) == 0
    assert degree_of_occlusion([0.1, 0.2, 0.3]) == pytest.approx(1.0)
    assert math.isnan(degree_of_occlusion([0, 0, 0])), "no field anywhere is no data, not a clear frame"
    assert math.isnan(degree_of_occlusion([0.2]))


@pytest.mark.parametrize(
    ("hue", "counts"), [(0, True), (30, True), (31, False), (149, False), (150, True), (179, True)]
)
def test_the_fields_hues_are_the_papers(hue: int, counts: bool) -> None:
    import cv2

    hsv = np.full((8, 8, 3), (hue, 200, 255), np.uint8)
    assert (field_area(cv2.cvtColor(hsv, cv2.COLOR_HSV2BGR)) > 0.5) == counts


def test_clear_frames_come_in_runs_from_all_over_the_pose() -> None:
    doo = np.full(60, 0.9)
    doo[[3, 24]] = 0.1  # single glimpses do not count where there is a run
    doo[[16, 17, 18]] = 0.3
    doo[26:60] = 0.2
    chosen, clear = ClearFrames(wanted=6).choose(doo)
    assert clear
    assert [int(c) // 10 for c in chosen] == [0, 1, 2, 3, 4, 5]
    assert 16 <= chosen[1] <= 18
    assert chosen[2] >= 26


def test_without_clear_frames_the_clearest_are_taken_and_said_so() -> None:
    doo = np.linspace(2, 0.6, 50)
    chosen, clear = ClearFrames(wanted=5).choose(doo)
    assert not clear
    assert len(chosen) == 5
    assert list(chosen) == [9, 19, 29, 39, 49]
    chosen, clear = ClearFrames().choose(np.full(4, np.nan))
    assert not clear
    assert len(chosen) == 4


def test_the_main_region_leaves_out_specks() -> None:
    mask = np.zeros((200, 300), bool)
    mask[60:140, 100:200] = True
    mask[5:15, 5:15] = True
    region = main_region(mask)
    assert region[100, 150]
    assert not region[10, 10]
    assert not main_region(np.zeros((200, 300), bool)).any()
