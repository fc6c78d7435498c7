"""A cloth over a hill, as exact cameras of a rig see it."""

from __future__ import annotations

import cv2
import numpy as np
from relief_scene import shown_at

SIZE = (480, 270)
RIG = {
    "ref": np.eye(3, 4),
    "b": np.array([[0.31, -0.95, 290.0, 0.9], [0.95, 0.31, -175.0, 0.4], [2e-5, 4e-5, 1.0, 1e-4]]),
    "c": np.array([[-0.81, -0.59, 515.0, -0.5], [0.59, -0.81, 100.0, 0.8], [-4e-5, 2e-5, 1.0, 2e-4]]),
}
_AROUND = 200  # pixels that the cloth reaches beyond the picture


def hill(points: np.ndarray) -> np.ndarray:
    """(N,): gamma at (N, 2) pixels of the reference."""
    return 7 * np.exp(-(((points - (240, 135)) / (70, 50)) ** 2).sum(axis=1)) - 1


def cloth() -> np.ndarray:
    """(H, W, 3) uint8, BGR, grey structure of several sizes."""
    rng = np.random.default_rng(7)
    size = (SIZE[0] + 2 * _AROUND, SIZE[1] + 2 * _AROUND)
    grey = sum(
        cv2.resize(rng.normal(0, 1, (size[1] // k + 2, size[0] // k + 2)).astype(np.float32), size) * k**0.5
        for k in (3, 6, 15)
    )
    return cv2.cvtColor(cv2.normalize(grey, None, 30, 220, cv2.NORM_MINMAX).astype(np.uint8), cv2.COLOR_GRAY2BGR)


def waves(points: np.ndarray) -> np.ndarray:
    """(N,): another surface than the hill, bent all over."""
    return 5 * np.sin(points[:, 0] / 45) * np.cos(points[:, 1] / 35)


def taken(projection: np.ndarray, over: np.ndarray, surface=hill) -> np.ndarray:
    """What a camera sees of a `cloth` ``over`` the surface."""
    return cv2.remap(over, shown_at(projection, surface, SIZE) + _AROUND, None, cv2.INTER_CUBIC)
