"""A textured relief with known gamma, as exact cameras around see it."""

from __future__ import annotations

import cv2
import numpy as np
from attrs import frozen
from relief_scene import shown_at

from mcsl_core.alignment.relief.protocol import ReliefCamera, ReliefScene, ReliefView

SIZE = (640, 360)
# camera -> (turn in degrees, what a gamma of 1 moves: x, y, and a share of the depth)
AROUND = {
    "cam1": (0.0, (0.0, 0.0, 0.0)),
    "cam2": (25.0, (0.9, 0.3, 1e-4)),
    "cam3": (-40.0, (-0.7, 0.6, -1e-4)),
    "cam4": (70.0, (0.1, -0.9, 2e-4)),
}


@frozen(eq=False)
class Relief:
    """gamma: (H, W) at every pixel of the perspective. texture: (H, W, 3) BGR, what lies there."""

    gamma: np.ndarray
    texture: np.ndarray

    def scene(self, *, noise: float = 1.0, points: int = 0) -> ReliefScene:
        """All cameras with one view each, and some of the true points."""
        rng = np.random.default_rng(5)
        cameras = {}
        for name, (turn, parallax) in AROUND.items():
            plane = plane_of(turn)
            picture = self.seen(plane, np.array(parallax))
            noisy = np.clip(picture + rng.normal(0, noise, picture.shape), 0, 255).astype(np.uint8)
            view = ReliefView(noisy, np.ones(noisy.shape[:2], bool))
            cameras[name] = ReliefCamera(SIZE, np.column_stack([plane, parallax]), plane, (view,))
        x, y = rng.integers(0, SIZE[0], points), rng.integers(0, SIZE[1], points)
        return ReliefScene(SIZE, cameras, np.stack([x, y, self.gamma[y, x]], axis=1).astype(float))

    def seen(self, plane: np.ndarray, parallax: np.ndarray) -> np.ndarray:
        """The camera's picture."""
        heights = self.gamma.astype(np.float32)
        at = shown_at(np.column_stack([plane, parallax]), lambda points: sampled(heights, points), SIZE)
        return sampled(self.texture, at.reshape(-1, 2)).reshape(SIZE[1], SIZE[0], 3)


def plane_of(turn: float) -> np.ndarray:
    """Perspective pixel -> camera pixel: turned about the middle, and tilted a little."""
    middle, angle = np.array([[1, 0, 319.5], [0, 1, 179.5], [0, 0, 1]]), np.deg2rad(turn)
    turned = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [1e-4, -5e-5, 1]])
    plane = middle @ turned @ np.linalg.inv(middle)
    return plane / plane[2, 2]


def sampled(picture: np.ndarray, at: np.ndarray) -> np.ndarray:
    """(N, ...) values of a picture at (N, 2) pixels."""
    maps = (at[:, k].astype(np.float32).reshape(-1, SIZE[0]) for k in (0, 1))
    found = cv2.remap(picture, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return found.reshape(len(at), *picture.shape[2:])


def hill(height: float = 12.0) -> np.ndarray:
    """(H, W) gamma of a hill in the middle, and a hollow beside it."""
    x, y = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    top = np.exp(-(((x - 300) / 90) ** 2) - ((y - 170) / 70) ** 2)
    return height * (top - 0.5 * np.exp(-(((x - 450) / 60) ** 2) - ((y - 220) / 60) ** 2))


def rough(seed: int) -> np.ndarray:
    """(H, W, 3) uint8 with structure of several sizes."""
    rng = np.random.default_rng(seed)
    grey = sum(
        cv2.resize(rng.normal(0, 1, (SIZE[1] // k + 2, SIZE[0] // k + 2)).astype(np.float32), SIZE) * k**0.5
        for k in (2, 5, 13, 40)
    )
    grey = cv2.normalize(grey, None, 30, 220, cv2.NORM_MINMAX).astype(np.uint8)
    return cv2.merge([grey // 2, grey, grey // 3])


def at_pixels(nodes: np.ndarray) -> np.ndarray:
    """(H, W): nodes from the first to the last pixel, linearly between."""
    rows, columns = nodes.shape
    x, y = np.meshgrid(np.linspace(0, columns - 1, SIZE[0]), np.linspace(0, rows - 1, SIZE[1]))
    return cv2.remap(nodes.astype(np.float32), x.astype(np.float32), y.astype(np.float32), cv2.INTER_LINEAR)
