"""A pose's relief over programme pixels: the same cameras in other terms, told to the estimator, kept by the EDL."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import pytest
from hand_over_slope import PROJECTIONS, SIZE

from mcsl_core.alignment.aligned_views import AlignedPose
from mcsl_core.alignment.relief.cameras import ReliefCameras
from mcsl_core.alignment.relief.estimation import estimate_relief
from mcsl_core.alignment.relief.hand_masks import hand_masks
from mcsl_core.alignment.relief.matching import Views
from mcsl_core.alignment.relief.pose_relief import PoseRelief
from mcsl_core.alignment.relief.protocol import PlaneRelief, ReliefScene, ReliefSurface
from mcsl_core.alignment.steady import SteadyView, steady_view
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


CLOTH, GLOVE, SKIN, SLEEVE = (70, 110, 40), (225, 230, 235), (120, 150, 210), (150, 90, 50)  # BGR
STANDS = 24.0  # gamma of the hand above the flat scene


def painted(picture: np.ndarray, projection: np.ndarray, x, y, gamma: float, colour: tuple[int, int, int]) -> None:
    """A level rectangle of the scene, as a camera sees it at half its size."""
    x, y = np.meshgrid(x, y)
    corners = np.column_stack([x.ravel(), y.ravel(), np.full(4, gamma)])[[0, 1, 3, 2]]
    cv2.fillConvexPoly(picture, np.round(project(projection, corners) / 2).astype(np.int32), colour)


def worked_on(glove: tuple[int, int, int], rests: bool) -> Views:
    """Skin amid cloth, gloves that pass at a corner, and a hand that rests above the skin where each camera sees it."""
    rng, samples = np.random.default_rng(3), []
    for n in range(12):
        sample = {}
        for name, projection in PROJECTIONS.items():
            picture = np.full((270, 480, 3), CLOTH, np.uint8)
            painted(picture, projection, (240, 720), (120, 420), 0.0, SKIN)
            if rests:
                painted(picture, projection, (300, 600), (200, 300), STANDS, glove)
            if n % 3 == 0:
                picture[5:60, 30 * n : 30 * n + 60] = glove
                picture[:9, 30 * n : 30 * n + 60] = SLEEVE
            sample[name] = np.clip(picture + rng.normal(0, 2, picture.shape), 0, 255).astype(np.uint8)
        samples.append(sample)
    steady = {name: steady_view([sample[name] for sample in samples]) for name in PROJECTIONS}
    return Views("ref", dict.fromkeys(PROJECTIONS, SIZE), steady, samples)


IN_FIELD = np.zeros((270, 480), bool)
IN_FIELD[60:210, 120:360] = True
X, Y = np.meshgrid(np.linspace(0, 959, 96), np.linspace(0, 539, 54))
STANDING = (X > 300) & (X < 600) & (Y > 200) & (Y < 300)


def estimated(shown: Views) -> tuple[PoseRelief, Told]:
    """What stands above the flat scene in the surface may be a hand or not."""
    flat = ReliefCameras(PROJECTIONS, np.column_stack([POINTS, np.zeros(len(POINTS))]), dict.fromkeys(PROJECTIONS, 0.1))
    told = Told(list(PROJECTIONS))
    told.surface = ReliefSurface(STANDS * STANDING, np.full((54, 96), 0.9), frozenset(PROJECTIONS))
    planes = {name: np.linalg.inv(p[:, :3]) for name, p in PROJECTIONS.items()}
    made = estimate_relief(told, flat, shown, planes, None, IN_FIELD)
    assert made is not None
    return made, told


def aligned() -> AlignedPose:
    planes = {name: np.linalg.inv(p[:, :3]) for name, p in PROJECTIONS.items()}
    return AlignedPose((480, 270), "ref", planes, dict.fromkeys(PROJECTIONS, SIZE), IN_FIELD)


def test_a_hand_that_rests_is_taken_off_the_surface_and_known_in_every_view() -> None:
    shown = worked_on(GLOVE, rests=True)
    made, told = estimated(shown)
    assert told.scene is not None
    assert not told.scene.cameras["ref"].views[0].steady[104:146, 154:296].any(), "its colours are not the scene's"
    assert (made.hands & STANDING).sum() > 0.9 * STANDING.sum()
    assert (made.hands & ~STANDING).sum() < 0.1 * STANDING.sum()
    assert abs(made.surface.gamma[STANDING]).max() < 0.1 * STANDS
    np.testing.assert_array_equal(made.over, told.surface.gamma)
    masks = hand_masks(made, aligned())
    assert masks.keys() == PROJECTIONS.keys()
    for view in aligned().views(shown.samples[1]):
        glove, mask, by_plane = view.inside & (view.aligned[..., 0] > 170), masks[view.camera], masks["ref"]
        assert (mask & glove).sum() > 0.85 * (mask | glove).sum(), view.camera
        assert view.camera == "ref" or (by_plane & glove).sum() < 0.8 * (by_plane | glove).sum(), "or this says nothing"


@pytest.mark.parametrize("glove", [GLOVE, SKIN], ids=["gloves", "bare hands"])
def test_what_stands_as_high_and_has_the_scenes_colours_is_no_hand(glove: tuple[int, int, int]) -> None:
    made, told = estimated(worked_on(glove, rests=False))
    assert not made.hands.any()
    assert hand_masks(made, aligned()) == {}
    np.testing.assert_array_equal(made.surface.gamma, told.surface.gamma)
