"""Views that a lamp can hold, and ties that no lamp makes."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from mcsl_core.alignment.plausibility import plausible
from mcsl_core.alignment.protocol import Alignment
from mcsl_core.imaging.geometry import Array
from mcsl_core.simulation.rig import Rig
from mcsl_core.simulation.scenario import Scenario
from mcsl_core.simulation.schedule import lamp_path
from mcsl_core.simulation.truth import fit_homography

SIZES = {"ref": (960, 540), "b": (960, 540)}


def kept(homography: Array, size: tuple[int, int] = (960, 540)) -> bool:
    """Whether camera "b" is left, and else told of, beside the reference."""
    given = Alignment({"ref": np.eye(3), "b": homography}, {"b": 1.0}, {"b": 100}, ())
    found = plausible(given, {**SIZES, "b": size}, "ref")
    left = "b" in found.homographies
    assert "ref" in found.homographies
    assert left == (not found.weak) == ("b" in found.support) == ("b" in found.residual_px)
    return left


@pytest.mark.parametrize("seed", range(6))
def test_every_view_of_a_simulated_lamp_may_be(seed: int) -> None:
    scenario = Scenario(seed=seed, duration_s=10.0, size=(960, 540))
    rig, (at, _) = Rig.of(scenario), lamp_path(scenario).pose(0.0)
    x, y = np.meshgrid(np.linspace(-80, 80, 5), np.linspace(-60, 60, 5))
    plane = np.column_stack([x.ravel(), y.ravel(), np.zeros(25)])
    seen = [rig.camera(n, at).project(plane) for n in range(scenario.cameras)]
    assert all(kept(fit_homography(own, seen[0])) for own in seen[1:])


@pytest.mark.parametrize("turn", [0, 72, 180])
def test_turned_zoomed_and_of_another_size_they_may_be(turn: int) -> None:
    turned = np.vstack([cv2.getRotationMatrix2D((480, 270), turn, 1.8), [0, 0, 1]])
    assert kept(turned)
    assert kept(turned @ np.diag([0.25, 0.25, 1]), (3840, 2160))
    assert not kept(turned, (3840 * 2, 2160 * 2))  # of that size its picture is shown 14 times as large


@pytest.mark.parametrize(
    "wrong",
    [
        np.diag([-1.0, 1, 1]),  # mirrored
        np.diag([0.1, 0.1, 1]),  # shrunk
        np.diag([1.0, 0.15, 1]),  # squeezed
        np.array([[1, 0, 0], [0, 1, 0], [0, -1 / 270, 1.0]]),  # its horizon passes through the middle
        np.array([[1, 0, 0], [0, 1, 0], [0.01, 0, 1.0]]),  # much larger on one side than on the other
    ],
)
def test_no_lamp_holds_a_camera_so(wrong: Array) -> None:
    assert not kept(wrong)
