"""Least squares in blocks, against scipy's of the whole."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from attrs import frozen
from lamp_scene import NAMES, SIZE, dense_slopes, scene, seen, true_lamp
from scipy.optimize import least_squares

from mcsl_core.alignment.tracking.calibration import Calibration
from mcsl_core.alignment.tracking.lamp import AT_REST, LampView
from mcsl_core.alignment.tracking.least_squares import Blocks, minimum
from mcsl_core.imaging.geometry import project

SCALE = 1.0 / 960


def whole(problem: Blocks, start: np.ndarray, scale: float) -> tuple[float, np.ndarray]:
    """The cost and the numbers that scipy finds, of the whole Jacobian's singular values."""
    found = least_squares(
        problem.off,
        start,
        lambda numbers: dense_slopes(problem, numbers),  # pyright: ignore[reportArgumentType]
        loss="soft_l1",
        f_scale=scale,
        x_scale="jac",
        max_nfev=60,
    )
    return found.cost, found.x


@pytest.mark.parametrize("count", [1, 2, 3])
def test_a_rig_is_calibrated_as_by_the_whole_jacobian(count: int) -> None:
    """With cameras that bend by some tenths of a pixel, one that a pose has elsewhere, and one that a pose lacks."""
    rng, true, points = np.random.default_rng(count), true_lamp(), scene(30)
    turns = rng.normal(0, 1, (count - 1, 7)) * [0.1, 0.1, 0.2, 0.1, 0.1, 0.1, 0.08]
    poses = [dict(seen(true, view)) for view in (AT_REST, *map(LampView.of, turns))]
    for pose in poses:
        for name in NAMES:
            bent = rng.normal(0, 1, (3, 3)) * [[3e-4, 3e-4, 0.1], [3e-4, 3e-4, 0.1], [3e-7, 3e-7, 0]]
            pose[name] = (np.eye(3) + bent) @ pose[name]
    poses[-1]["cam4"] = np.array([[1, 0, 6], [0, 1, -4], [0, 0, 1]]) @ poses[-1]["cam4"]
    if count > 1:
        del poses[-1]["cam2"]
    problem = Calibration(poses, points, "cam1", NAMES[1:], dict.fromkeys(NAMES, SIZE))
    starts = [problem.start(focal, sign) for focal in (1.1, 1.9) for sign in (1, -1)]
    _, rough = min((problem.solved(start) for start in starts), key=lambda found: found[0])
    cost, numbers = problem.solved(rough)  # twice, as a rig is calibrated
    _, rough = min((whole(problem, start, SCALE) for start in starts), key=lambda found: found[0])
    of_dense, dense = whole(problem, rough, SCALE)
    assert cost == pytest.approx(of_dense, rel=1e-6)
    for view, other, pose in zip(problem.views(numbers), problem.views(dense), poses, strict=True):
        for name in pose:
            apart = project(problem.lamp(numbers).projection(name, view), points) - project(
                problem.lamp(dense).projection(name, other), points
            )
            assert np.hypot(*apart.T).max() < 0.001


@frozen(eq=False)
class Curves:
    """Residuals a exp(b t) + c_i - y of curves: a and b are all curves', an offset is one's alone."""

    t: np.ndarray
    y: np.ndarray  # (curves, len(t))

    def off(self, numbers: np.ndarray) -> np.ndarray:
        a, b, *offsets = numbers
        return np.concatenate([a * np.exp(b * self.t) + c - y for c, y in zip(offsets, self.y, strict=False)])

    def slopes(self, numbers: np.ndarray) -> Iterator[tuple[list[int], np.ndarray]]:
        a, b = numbers[:2]
        rise = np.exp(b * self.t)
        for index in range(len(self.y)):
            yield [0, 1, 2 + index], np.column_stack([rise, a * self.t * rise, np.ones(len(self.t))])


def test_curves_with_outliers_are_found_as_by_the_whole_jacobian() -> None:
    rng, t = np.random.default_rng(0), np.linspace(0, 2, 30)
    y = 1.5 * np.exp(-0.7 * t) + rng.normal(0, 3, (8, 1)) + rng.normal(0, 0.02, (8, 30))
    y[:, ::7] += 4
    curves, start = Curves(t, y), np.array([1.0, 0.1, *np.zeros(8)])
    _, numbers = minimum(curves, start, 0.02, 2, 1, 300)
    assert numbers == pytest.approx(whole(curves, start, 0.02)[1], abs=1e-4)
    assert numbers[:2] == pytest.approx([1.5, -0.7], abs=0.1)


def test_a_number_that_nothing_tells_of_stays_where_it_is() -> None:
    t = np.linspace(0, 2, 30)
    curves = Curves(t, (1.5 * np.exp(-0.7 * t) + 1)[None])
    _, numbers = minimum(curves, np.array([1.0, -0.1, 0.0, 5.0]), 0.02, 2, 1, 300)
    assert numbers == pytest.approx([1.5, -0.7, 1.0, 5.0], abs=1e-5)


def test_steps_from_where_little_is_told_do_not_overflow(recwarn: pytest.WarningsRecorder) -> None:
    """Of a curve that is nearly flat nothing says how fast it rises."""
    t = np.linspace(0, 2, 30)
    curves = Curves(t, (1.5 * np.exp(-0.7 * t) + 1)[None])
    start = np.array([1e-6, 0.0, 0.0])
    cost, _ = minimum(curves, start, 0.02, 2, 1)
    assert cost < 0.5 * 0.02**2 * np.sum(2 * (np.hypot(1, curves.off(start) / 0.02) - 1))
    assert not recwarn.list
