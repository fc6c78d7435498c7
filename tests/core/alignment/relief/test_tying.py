"""A pose's scene found in the one before by pictures alone: the lamp has moved, the hill has not."""

from __future__ import annotations

import cloth_scene
import cv2
import numpy as np
import pytest
from cloth_scene import RIG, SIZE, hill, taken

from mcsl_core.alignment.relief.protocol import ReliefCamera, ReliefScene, ReliefSurface, ReliefView
from mcsl_core.alignment.relief.tying import tie_scene
from mcsl_core.imaging.geometry import project

# Programme pixel and gamma -> own: the lamp turned by 20 degrees, tilted, came nearer; gamma on another scale.
MOVED = np.eye(4)
MOVED[:2, :3] = cv2.getRotationMatrix2D((240, 135), 20, 1.04)
MOVED[:2, 2] += 9, -6
MOVED[2] = 8e-5, -5e-5, 1, 1e-4
MOVED[:2, 3] = 0.5, -0.7
MOVED[3] = 2e-3, -1e-3, 0.2, -1.7


@pytest.fixture(scope="module")
def cloth() -> np.ndarray:
    return cloth_scene.cloth()


def scene(to_own: np.ndarray, cloth: np.ndarray) -> ReliefScene:
    """The rig where ``to_own`` has it; its planes a few pixels wrong, as an anchor leaves them."""
    shift = np.array([[1, 0, 3.0], [0, 1, -2.0], [0, 0, 1]])
    cameras = {}
    for name, own in RIG.items():
        view = ReliefView(taken(own @ to_own, cloth), np.ones(SIZE[::-1], bool))
        cameras[name] = ReliefCamera(SIZE, own, shift @ own[:, :3] @ to_own[:3, :3], (view,))
    return ReliefScene(SIZE, cameras)


def surface(bent: float = 0.0, confidence: float = 1.0) -> ReliefSurface:
    """The hill, bent in and out by so many pixels of gamma."""
    x, y = np.meshgrid(np.linspace(0, SIZE[0] - 1, 96), np.linspace(0, SIZE[1] - 1, 54))
    gamma = hill(np.stack([x.ravel(), y.ravel()], axis=1)).reshape(54, 96) + bent * np.sin(x / 20) * np.cos(y / 20)
    return ReliefSurface(gamma, np.full((54, 96), confidence), frozenset(RIG))


START = np.eye(4)
START[:3, :3] = MOVED[:3, :3]


def test_the_scene_lies_where_the_lamp_has_gone(cloth: np.ndarray) -> None:
    before, now = scene(np.eye(4), cloth), scene(MOVED, cloth)
    tied = tie_scene(before, surface(), now, START)
    assert tied is not None
    pixels = np.random.default_rng(3).uniform((60, 40), (420, 230), (300, 2))
    points = np.column_stack([pixels, hill(pixels)])
    for name, own in RIG.items():
        there = project(own @ MOVED, points)
        shown = ((there > 5) & (there < np.array(SIZE) - 5)).all(axis=1)
        off = np.hypot(*(project(own @ tied, points) - there).T)[shown]
        assert np.median(off) < 0.15, name
        assert np.percentile(off, 95) < 0.5, name
        by_plane = np.hypot(*(project(own @ START, points) - there).T)[shown]
        assert np.percentile(by_plane, 95) > 2, "or this says nothing"


def test_another_scene_is_not_tied(cloth: np.ndarray) -> None:
    before, now = scene(np.eye(4), cloth), scene(MOVED, np.ascontiguousarray(cloth[::-1, ::-1]))
    assert tie_scene(before, surface(), now, START) is None


@pytest.mark.parametrize(("bent", "tied"), [(0.5, True), (2.5, False)])
def test_a_scene_whose_shape_has_changed_is_not_tied(cloth: np.ndarray, bent: float, tied: bool) -> None:
    before, now = scene(np.eye(4), cloth), scene(MOVED, cloth)
    assert (tie_scene(before, surface(bent), now, START) is not None) == tied


def test_what_the_surface_does_not_know_ties_nothing(cloth: np.ndarray) -> None:
    before, now = scene(np.eye(4), cloth), scene(MOVED, cloth)
    assert tie_scene(before, surface(confidence=0.35), now, START) is not None
    assert tie_scene(before, surface(confidence=0.25), now, START) is None
