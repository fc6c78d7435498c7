"""Gamma between its points: what a smooth relief has there, and nothing wild where there are none."""

from __future__ import annotations

import numpy as np

from mcsl_core.alignment.relief.interpolation import gamma_map

SIZE = (240, 135)


def test_a_smooth_relief_is_met_between_its_points() -> None:
    rng = np.random.default_rng(1)
    x, y = rng.uniform(0, 239, 900), rng.uniform(0, 134, 900)

    def hill(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return 8 * np.exp(-((x - 120) ** 2 + (y - 70) ** 2) / 40**2)

    made = gamma_map(np.column_stack([x, y, hill(x, y)]), SIZE)
    assert made.shape == (135, 240)
    columns, rows = np.meshgrid(np.arange(240), np.arange(135))
    off = np.abs(made - hill(columns, rows))[10:-10, 10:-10]
    assert np.median(off) < 0.15
    assert off.max() < 1.5


def test_far_from_all_points_it_is_their_median() -> None:
    near = np.column_stack([np.linspace(2, 8, 30), np.linspace(2, 8, 30), np.linspace(3, 5, 30)])
    made = gamma_map(near, (600, 400))
    np.testing.assert_allclose(made[-5:, -5:], 4, atol=0.2)
    np.testing.assert_allclose(made[3, 3], 3.3, atol=0.5)
    assert made.min() >= 2.9, "nothing beyond what is known"
    assert made.max() <= 5.1
    outside = near + np.array([1000, 1000, 0])
    np.testing.assert_allclose(gamma_map(outside, (60, 40)), 4, atol=1e-6)
