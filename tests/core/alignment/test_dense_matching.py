"""Every point of a grid compared: what stays is found to a fraction of a pixel, what moves is not believed."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from mcsl_core.alignment.dense_matching import AlignedCamera, DenseSettings, match_densely
from mcsl_core.imaging.geometry import transform_points

SIZE = (480, 270)


def cloth(seed: int, hue: tuple[float, float, float]) -> np.ndarray:
    """A (270, 480, 3) picture with structure of several sizes, in shades of a BGR colour."""
    rng = np.random.default_rng(seed)
    grey = sum(
        cv2.resize(rng.normal(0, 1, (270 // k + 2, 480 // k + 2)).astype(np.float32), SIZE) * k**0.5 for k in (3, 7, 19)
    )
    grey = cv2.normalize(grey, None, 60, 200, cv2.NORM_MINMAX)
    return np.clip(grey[..., None] * np.array(hue), 0, 255).astype(np.uint8)


def area() -> np.ndarray:
    mask = np.zeros((270, 480), bool)
    mask[70:200, 120:360] = True
    return mask


def tilted(angle_deg: float, x: float, y: float) -> np.ndarray:
    """Pixel of the plane -> camera pixel: a turn about the middle, a little perspective, a shift."""
    turn = np.vstack([cv2.getRotationMatrix2D((240, 135), angle_deg, 1.0), [0, 0, 1]])
    return np.array([[1, 0, x], [0, 1, y], [2e-5, -1e-5, 1]]) @ turn


def seen(plane: np.ndarray, to_camera: np.ndarray, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    picture = cv2.warpPerspective(plane, to_camera, SIZE, flags=cv2.INTER_CUBIC)
    return np.clip(picture + rng.normal(0, 2, picture.shape), 0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def cameras() -> tuple[dict[str, AlignedCamera], dict[str, np.ndarray]]:
    """Three cameras over ten samples, laid some pixels wrong; a patch wanders over the left half of the field."""
    plane = cloth(1, (0.3, 0.4, 1.0))
    true = {"a": tilted(0, 0, 0), "b": tilted(72, 5, -3), "c": tilted(-140, -6, 8)}
    wrong = {"a": (0, 0), "b": (3.3, -2.1), "c": (-2.4, 4.2)}
    laid = {}
    for number, (name, to_camera) in enumerate(true.items()):
        pictures = []
        for sample in range(10):
            with_hand = plane.copy()
            y, x = 80 + 9 * sample, 130 + 7 * sample + 5 * number  # above the plane: elsewhere in every view
            with_hand[y : y + 40, x : x + 60] = cloth(50 + 10 * sample + number, (0.4, 0.8, 1.0))[:40, :60]
            pictures.append(seen(with_hand, to_camera, 100 * number + sample))
        shift = np.array([[1, 0, wrong[name][0]], [0, 1, wrong[name][1]], [0, 0, 1]])
        laid[name] = AlignedCamera.by_plane(pictures, shift @ np.linalg.inv(to_camera), SIZE, SIZE)
    return laid, true


def test_points_are_found_to_a_fraction_of_a_pixel(cameras) -> None:
    laid, true = cameras
    found = match_densely(laid, area())
    assert set(found) == {("a", "b"), ("a", "c"), ("b", "c")}
    for (a, b), matches in found.items():
        there = transform_points(true[b] @ np.linalg.inv(true[a]), matches.a)
        error = np.hypot(*(there - matches.b).T)
        assert np.median(error) < 0.3
        assert np.percentile(error, 95) < 1.0, "a hand that wanders was believed"
        assert matches.seen.min() >= 3
        at = transform_points(np.linalg.inv(true[a]), matches.a)
        reached = {(int(x) // 40, int(y) // 40) for x, y in at}
        assert len(reached) >= 20, "the points lie all over the field"


def test_what_never_shows_the_fields_hue_weighs_less() -> None:
    plane = cloth(2, (0.3, 0.4, 1.0))
    plane[:, 240:] = cloth(3, (0.3, 1.0, 0.3))[:, 240:]
    one = tilted(0, 0, 0)
    pictures = [seen(plane, one, n) for n in range(4)]
    views = {name: AlignedCamera.by_plane(pictures, np.eye(3), SIZE, SIZE) for name in "ab"}
    matches = match_densely(views, area())["a", "b"]
    left, right = matches.a[:, 0] < 230, matches.a[:, 0] > 250
    np.testing.assert_allclose(matches.weight[left], 1.0)
    np.testing.assert_allclose(matches.weight[right], DenseSettings().other_hue)


def test_nothing_comes_of_nothing() -> None:
    plane = cloth(4, (0.3, 0.4, 1.0))
    one = AlignedCamera.by_plane([plane], np.eye(3), SIZE, SIZE)
    blank = AlignedCamera.by_plane([np.zeros_like(plane)], np.eye(3), SIZE, SIZE)
    assert match_densely({"a": one, "b": one}, np.zeros((270, 480), bool)) == {}
    assert match_densely({"a": one, "b": blank}, area()) == {}
    assert match_densely({"a": one, "b": AlignedCamera.by_plane([None], np.eye(3), SIZE, SIZE)}, area()) == {}
    assert match_densely({"a": one}, area()) == {}
    unrelated = AlignedCamera.by_plane([cloth(5, (0.3, 0.4, 1.0))], np.eye(3), SIZE, SIZE)
    believed = match_densely({"a": one, "b": unrelated}, area())
    assert sum(len(m) for m in believed.values()) < 0.05 * area().sum() / 36
