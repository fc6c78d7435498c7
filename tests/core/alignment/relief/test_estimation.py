"""A pose's relief over programme pixels: the same cameras in other terms, told to the estimator, kept by the EDL."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import pytest

from mcsl_core.alignment.aligned_views import AlignedPose
from mcsl_core.alignment.relief.cameras import ReliefCameras
from mcsl_core.alignment.relief.estimation import PoseRelief, estimate_relief, resting_hands_in, surface_pairs
from mcsl_core.alignment.relief.matching import Views
from mcsl_core.alignment.relief.protocol import PlaneRelief, ReliefCamera, ReliefScene, ReliefSurface
from mcsl_core.alignment.steady import SteadyView
from mcsl_core.imaging.geometry import project, transform_points

SIZE = (960, 540)
PROJECTIONS = {
    "ref": np.eye(3, 4),
    "b": np.array([[0.3, -0.95, 600.0, 0.9], [0.95, 0.3, -200.0, 0.4], [1e-5, 2e-5, 1.0, 1e-4]]),
    "c": np.array([[-0.8, -0.6, 1000.0, -0.5], [0.6, -0.8, 300.0, 0.8], [-2e-5, 1e-5, 1.0, 2e-4]]),
}
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


HAND = np.zeros((54, 96), bool)
HAND[20:30, 30:60] = True


def under_hand() -> PoseRelief:
    """A slope, and a hand 20 px of gamma above it."""
    x = np.arange(96.0) * np.ones((54, 1))
    surface = ReliefSurface(0.1 * x, np.full((54, 96), 0.9), frozenset(PROJECTIONS))
    cameras = {name: ReliefCamera(SIZE, p, np.eye(3), ()) for name, p in PROJECTIONS.items()}
    return PoseRelief(ReliefScene(SIZE, cameras), surface, {}, HAND, 0.1 * x + 20.0 * HAND, 1.0)


def test_a_resting_hand_lies_in_every_view_where_its_height_puts_it() -> None:
    relief = under_hand()
    lifted = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0.0]])
    planes = {name: np.linalg.inv(p @ lifted) for name, p in PROJECTIONS.items()}
    planes["tied by points alone"] = np.eye(3)
    aligned = AlignedPose((480, 270), "ref", planes, dict.fromkeys(planes, SIZE), FIELD)
    masks = resting_hands_in(relief, aligned)
    np.testing.assert_array_equal(masks.pop("tied by points alone"), masks["ref"])
    assert masks.keys() == PROJECTIONS.keys()
    place = np.array([450.0, 250.0])  # a node of the hand, its gamma 4.5 above 0
    for name, mask in masks.items():
        seen = project(PROJECTIONS[name], np.array([[*place, 0.1 * place[0] * 95 / 959 + 20]]))
        x, y = transform_points(planes[name], seen)[0] / 2
        assert mask[round(y), round(x)]
        assert mask.sum() == pytest.approx(HAND.sum() * 25, rel=0.25)


def test_under_a_hand_the_surface_is_carried_on_and_ties_nothing() -> None:
    seen = under_hand().seen
    assert not seen.confidence[HAND].any()
    assert seen.confidence[5, 5] == 0.9


def test_planes_under_hands_are_told_of_the_surface_and_not_of_the_hand() -> None:
    pairs = surface_pairs(under_hand(), "ref", FIELD)
    assert pairs.keys() == {("ref", "b"), ("ref", "c")}
    for (_, name), matches in pairs.items():
        scene = np.column_stack([matches.a, 0.1 * matches.a[:, 0] * 95 / 959])
        in_field = matches.weight == 1
        assert in_field.sum() > 300
        off = np.hypot(*(project(PROJECTIONS[name], scene) - matches.b)[in_field].T)
        assert np.median(off) < 0.3
        assert off.max() < 2
