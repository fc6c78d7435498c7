"""A pose's relief over programme pixels: the same cameras in other terms, told to the estimator, kept by the EDL."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import pytest
from hand_over_slope import PROJECTIONS, SIZE

from mcsl_core.alignment.relief.cameras import ReliefCameras
from mcsl_core.alignment.relief.estimation import estimate_relief
from mcsl_core.alignment.relief.matching import Views
from mcsl_core.alignment.relief.pose_relief import PoseRelief
from mcsl_core.alignment.relief.protocol import PlaneRelief, ReliefScene, ReliefSurface
from mcsl_core.alignment.steady import SteadyView
from mcsl_core.imaging.geometry import project, transform_points

FIELD = np.zeros((270, 480), bool)
FIELD[90:180, 160:320] = True
POINTS = np.random.default_rng(5).uniform((60, 60), (900, 480), (400, 2))


def hill(points: np.ndarray) -> np.ndarray:
    return 12 * np.exp(-(((points - (480, 270)) / (200, 150)) ** 2).sum(axis=1))


def found() -> ReliefCameras:
    """Bundle adjustment's own plane and scale are anybody's guess."""
    gamma = hill(POINTS) / 400 + POINTS @ (1e-4, 2e-4) - 0.05
    cameras = {name: np.column_stack([p[:, :3], p[:, 3] * 400]) for name, p in PROJECTIONS.items()}
    return ReliefCameras(cameras, np.column_stack([POINTS, gamma]), dict.fromkeys(PROJECTIONS, 0.1))


def views(count: int = 9) -> Views:
    samples = [{name: np.full((36, 64, 3), 20 * i, np.uint8) for name in PROJECTIONS} for i in range(count)]
    steady = {name: SteadyView(samples[0][name], np.ones((36, 64), bool)) for name in PROJECTIONS}
    return Views("ref", dict.fromkeys(PROJECTIONS, SIZE), steady, samples)


class Told:
    """An estimator that keeps what it is told, and has the surface that it is made with."""

    name = "told"

    def __init__(self, served: Sequence[str]) -> None:
        self.surface = ReliefSurface(np.full((54, 96), 1.2345678), np.full((54, 96), 0.804), frozenset(served))
        self.scene: ReliefScene | None = None

    def estimate(self, scene: ReliefScene) -> ReliefSurface | None:
        self.scene = scene
        return self.surface


@pytest.mark.parametrize("turn", [0.0, 25.0])
def test_the_scene_is_told_over_programme_pixels_with_gamma_in_pixels(turn: float) -> None:
    anchor = np.vstack([cv2.getRotationMatrix2D((480, 270), turn, 1.05), [0, 0, 1]])
    anchor[2, :2] = 3e-5 * turn, -2e-5 * turn
    planes = {name: anchor @ np.linalg.inv(p[:, :3]) for name, p in PROJECTIONS.items()}
    told, own = Told(["ref", "b"]), found()
    made = estimate_relief(told, own, views(), planes, None, FIELD)
    assert made is not None
    scene = told.scene
    assert scene is not None
    np.testing.assert_allclose(scene.points[:, :2], transform_points(anchor, POINTS), atol=1e-6)
    for name, camera in scene.cameras.items():
        before = project(own.projections[name], own.points)
        np.testing.assert_allclose(project(camera.projection, scene.points), before, atol=1e-5, err_msg=name)
        np.testing.assert_allclose(camera.plane @ planes[name], np.eye(3), atol=1e-9)
        assert len(camera.views) == 4, "all samples together, and three groups"
    middle = np.array([[480.0, 270.0, 0.0], [480.0, 270.0, 1.0]])
    moves = [np.hypot(*np.diff(project(c.projection, middle), axis=0)[0]) for c in scene.cameras.values()]
    assert max(moves) == pytest.approx(1, abs=0.02), "gamma is in pixels of the camera moved most"
    near = np.hypot(*(scene.points[:, :2] - (480, 270)).T) < 60
    assert abs(np.median(scene.points[near, 2])) < 6, "gamma 0 lies in the scene"

    document = made.document()
    assert set(document.projections) == {"ref", "b"}, "a camera that the surface does not serve keeps its plane"
    assert document.gamma[3][4] == 1.235
    assert document.confidence[0][0] == 80
    for name, matrix in document.projections.items():
        np.testing.assert_allclose(np.array(matrix), scene.cameras[name].projection)
        assert matrix[2][2] == 1


def test_a_camera_without_a_plane_has_no_relief_either() -> None:
    planes = {name: np.linalg.inv(p[:, :3]) for name, p in PROJECTIONS.items() if name != "c"}
    told = Told(["ref", "b", "c"])
    made = estimate_relief(told, found(), views(), planes, None, FIELD)
    assert made is not None
    assert set(made.document().projections) == {"ref", "b"}
    assert estimate_relief(told, found(), views(), {"ref": np.eye(3)}, None, FIELD) is None, "one camera sees no relief"


def test_without_a_surface_the_plane_stays() -> None:
    planes = {name: np.linalg.inv(p[:, :3]) for name, p in PROJECTIONS.items()}
    assert estimate_relief(PlaneRelief(), found(), views(1), planes, None, FIELD) is None
    assert estimate_relief(Told([]), found(), views(1), planes, None, FIELD) is None, "a surface that serves no camera"


def test_a_pose_that_shares_nothing_with_the_one_before_stands_by_its_plane() -> None:
    planes = {name: np.linalg.inv(p[:, :3]) for name, p in PROJECTIONS.items()}
    first = estimate_relief(Told(["ref", "b"]), found(), views(), planes, None, FIELD)
    assert isinstance(first, PoseRelief)
    told = Told(["ref", "b", "c"])
    second = estimate_relief(told, found(), views(), planes, first, FIELD)
    assert second is not None
    assert told.scene is not None
    assert set(told.scene.cameras) == set(PROJECTIONS), "blank pictures tie nothing"
