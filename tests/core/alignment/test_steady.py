"""What stays is told from what trembles, comes and goes, or wanders; light that changes is not movement."""

from __future__ import annotations

import cv2
import numpy as np

from mcsl_core.alignment.steady import steady_view

SIZE = (320, 180)


def cloth(seed: int, scale: float = 25.0) -> np.ndarray:
    """(180, 320, 3) with structure of several sizes."""
    rng = np.random.default_rng(seed)
    grey = sum(
        cv2.resize(rng.normal(0, 1, (180 // k + 2, 320 // k + 2)).astype(np.float32), SIZE) * k**0.5 for k in (3, 7, 19)
    )
    grey = 120 + scale * grey / grey.std()
    return np.repeat(grey.clip(30, 220)[..., None], 3, axis=2).astype(np.uint8)


def noisy(picture: np.ndarray, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.clip(picture + rng.normal(0, 1.2, picture.shape), 0, 255).astype(np.uint8)


def test_a_hand_that_trembles_in_one_place_is_not_steady_and_the_rest_is() -> None:
    scene, hand = cloth(1), cloth(2)
    pictures = []
    for n in range(20):
        rng = np.random.default_rng(n)
        x, y = rng.normal(0, 2.5, 2).round().astype(int)
        shown = scene.copy()
        shown[60 + y : 120 + y, 120 + x : 200 + x] = hand[60:120, 100:180]
        pictures.append(noisy(shown, n))
    view = steady_view(pictures)
    assert view is not None
    assert view.steady[70:110, 140:180].mean() < 0.1
    away = view.steady.copy()
    away[40:140, 90:230] = True
    assert away.mean() > 0.97


def test_what_is_hidden_most_of_the_time_is_seen_where_it_is_steady() -> None:
    """A head stands before the left half in six samples of ten, never twice the same."""
    scene = cloth(3)
    pictures = []
    for n in range(20):
        shown = scene.copy()
        if n % 5 < 3:
            shown[:, :160] = np.roll(cloth(10 + n), 11 * n, axis=1)[:, :160]
        pictures.append(noisy(shown, n))
    view = steady_view(pictures)
    assert view is not None
    off = np.abs(view.picture.astype(int) - scene)[view.steady].max(axis=-1)
    assert view.steady[:, :140].mean() > 0.6
    assert np.percentile(off, 95) < 8


def test_exposure_that_settles_and_pumps_leaves_all_steady() -> None:
    scene = cloth(4)
    gains = 1 + 0.25 * np.exp(-np.arange(16) / 3) + 0.05 * np.sin(np.arange(16))
    view = steady_view([noisy(cv2.convertScaleAbs(scene, alpha=float(g)), n) for n, g in enumerate(gains)])
    assert view is not None
    assert view.steady.mean() > 0.97


def test_too_few_pictures_say_nothing_of_steadiness() -> None:
    one = cloth(5)
    assert steady_view([None, None]) is None
    view = steady_view([None, cloth(6), one])
    assert view is not None
    assert view.steady.all()
    np.testing.assert_array_equal(view.picture, one)
