"""A slope with a hand that rests on it, as exact cameras see it: a pose's relief without any picture."""

from __future__ import annotations

import numpy as np

from mcsl_core.alignment.relief.pose_relief import PoseRelief
from mcsl_core.alignment.relief.protocol import ReliefCamera, ReliefScene, ReliefSurface

SIZE = (960, 540)
PROJECTIONS = {
    "ref": np.eye(3, 4),
    "b": np.array([[0.3, -0.95, 600.0, 0.9], [0.95, 0.3, -200.0, 0.4], [1e-5, 2e-5, 1.0, 1e-4]]),
    "c": np.array([[-0.8, -0.6, 1000.0, -0.5], [0.6, -0.8, 300.0, 0.8], [-2e-5, 1e-5, 1.0, 2e-4]]),
}
HAND = np.zeros((54, 96), bool)
HAND[20:30, 30:60] = True
HIGH = 20.0


def slope(x: np.ndarray) -> np.ndarray:
    """Gamma at columns of the programme's picture."""
    return 0.1 * x * 95 / 959


def under_hand() -> PoseRelief:
    """The slope, and the hand 20 px of gamma above it."""
    gamma = slope(np.linspace(0, SIZE[0] - 1, 96)) * np.ones((54, 1))
    surface = ReliefSurface(gamma, np.full((54, 96), 0.9), frozenset(PROJECTIONS))
    cameras = {name: ReliefCamera(SIZE, p, np.eye(3), ()) for name, p in PROJECTIONS.items()}
    return PoseRelief(ReliefScene(SIZE, cameras), surface, {}, HAND, gamma + HIGH * HAND, 1.0)
