"""Still pictures aligned: held against the homography that one was made from the other by."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

import mcsl_core as mcsl
from mcsl_core.errors import UsageError

SIZE = (640, 360)


def scene() -> np.ndarray:
    """RGB: a red field with texture on green cloth with texture."""
    rng = np.random.default_rng(7)
    grey = sum(
        cv2.resize(rng.normal(0, 1, (SIZE[1] // k + 2, SIZE[0] // k + 2)).astype(np.float32), SIZE) * k**0.5
        for k in (2, 5, 13, 40)
    )
    grey = cv2.normalize(grey, None, 40, 220, cv2.NORM_MINMAX).astype(np.uint8)
    field = cv2.ellipse(np.zeros(SIZE[::-1], np.uint8), (320, 180), (130, 90), 0, 0, 360, 1, -1)[..., None] > 0
    red, green = np.dstack([grey, grey // 4, grey // 4]), np.dstack([grey // 3, grey, grey // 2])
    return np.where(field, red, green)


@pytest.fixture(scope="module")
def seen() -> tuple[dict[str, np.ndarray], np.ndarray]:
    """What two cameras see of it, the second turned, tilted and of another size; and its pixel -> the first's."""
    turn = np.vstack([cv2.getRotationMatrix2D((320, 180), 72, 0.9), [0, 0, 1]])
    tilt = np.array([[1, 0.03, 6], [-0.02, 1, -9], [6e-5, -4e-5, 1]])
    back = np.linalg.inv(np.diag([1.25, 1.25, 1]) @ tilt @ turn)
    other = cv2.warpPerspective(scene(), np.linalg.inv(back), (800, 450))
    return {"cam1": scene(), "cam2": other}, back


def test_a_turned_picture_is_laid_where_it_came_from(seen) -> None:
    pictures, back = seen
    found = mcsl.align(pictures, reference="cam1")
    assert found.weak == ()
    np.testing.assert_array_equal(found.homographies["cam1"], np.eye(3))
    field = np.array([[[x, y]] for x in (230, 320, 410) for y in (120, 180, 240)], float)
    there = cv2.perspectiveTransform(field, np.linalg.inv(back))
    again = cv2.perspectiveTransform(there, found.homographies["cam2"])
    assert np.abs(again - field).max() < 0.7
    assert found.residual_px["cam2"] < 1


def test_the_first_is_the_reference_without_a_name(seen) -> None:
    pictures, _ = seen
    turned = dict(reversed(pictures.items()))
    np.testing.assert_array_equal(mcsl.align(turned).homographies["cam2"], np.eye(3))


def test_a_picture_of_something_else_is_weak(seen) -> None:
    pictures, _ = seen
    noise = np.random.default_rng(1).integers(0, 255, (360, 640, 3), dtype=np.uint8)
    found = mcsl.align({**pictures, "cam3": noise})
    assert [w.camera for w in found.weak] == ["cam3"]
    assert set(found.homographies) == {"cam1", "cam2"}


@pytest.mark.parametrize(
    ("pictures", "how", "told"),
    [
        ({"a": np.zeros((9, 9, 3), np.uint8)}, {}, "two pictures or more are aligned, got 1"),
        ({"a": np.zeros((9, 9, 3), np.uint8), "b": np.zeros((9, 9))}, {}, r"b: .*got float64 of shape \(9, 9\)"),
        ({"a": np.zeros((9, 9, 3), np.uint8), "b": [[1]]}, {}, "b: .*got list"),
        (dict.fromkeys("ab", np.zeros((9, 9, 3), np.uint8)), {"reference": "c"}, "no picture of 'c'. Take one of a, b"),
        (dict.fromkeys("ab", np.zeros((9, 9, 3), np.uint8)), {"matcher": "best"}, "no matcher named 'best'"),
    ],
)
def test_what_cannot_be_aligned_is_told(pictures, how, told: str) -> None:
    with pytest.raises(UsageError, match=told):
        mcsl.align(pictures, **how)
