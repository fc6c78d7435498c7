"""A camera that one pose cannot see is told by another, as long as the rig is the same."""

from __future__ import annotations

import numpy as np
import pytest

from mcsl_core.alignment.relief.cameras import Tracks
from mcsl_core.alignment.relief.rig import Rig, helpful, moved_rig, zoomed_rig
from mcsl_core.imaging.geometry import project

SIZES = dict.fromkeys(("ref", "b", "c", "d"), (960, 540))


def rotation(degrees: float) -> np.ndarray:
    a, t = np.radians(degrees), np.radians(8)
    turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    return np.array([[1, 0, 0], [0, np.cos(t), -np.sin(t)], [0, np.sin(t), np.cos(t)]]) @ turn


def lens(focal: float) -> np.ndarray:
    return np.array([[focal, 0, 479.5], [0, focal, 269.5], [0, 0, 1]])


def rig(focal: float = 1200.0, own: float = 1200.0) -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Cameras of a focal length, the reference of its ``own``."""
    aim, k = np.array([0, 0, 900.0]), lens(focal)
    made = {"ref": (lens(own), np.eye(3), np.zeros(3))}
    for n, name in enumerate(("b", "c", "d"), start=1):
        R = rotation(72 * n)
        made[name] = (k, R, aim - R @ aim + (40 * n, -30, 10))
    return made


def pose(cameras, plane: np.ndarray, unit: float) -> dict[str, np.ndarray]:
    """Projections over the plane 1/Z = plane . x, gamma in that unit: all that a pose alone can tell."""
    made = {}
    for name, (k, R, t) in cameras.items():
        A = k @ R @ np.linalg.inv(cameras["ref"][0]) + np.outer(k @ t, plane)
        own = np.column_stack([A, k @ t * unit])
        made[name] = own / own[2, 2]
    return made


def points(plane: np.ndarray, unit: float) -> np.ndarray:
    """Scene points in pixels of the reference and that pose's gamma."""
    rng = np.random.default_rng(2)
    x = np.column_stack([rng.uniform(200, 760, 500), rng.uniform(100, 440, 500)])
    inverse_depth = 1 / (900 - 40 * np.exp(-(((x - (480, 270)) / 150) ** 2).sum(axis=1)))
    return np.column_stack([x, (inverse_depth - np.column_stack([x, np.ones(500)]) @ plane) / unit])


BEFORE, NOW = np.array([1e-9, -2e-8, 1 / 880]), np.array([3e-8, 1e-8, 1 / 910])


def test_the_hidden_camera_lies_where_the_rig_has_it() -> None:
    known, here, scene = pose(rig(), BEFORE, 1e-6), pose(rig(), NOW, -2e-6), points(NOW, -2e-6)
    shake = np.random.default_rng(1).normal(0, 0.1, (2, 3))  # some tenths of a pixel, as bundle adjustment leaves them
    sure = {name: here[name].copy() for name in ("ref", "b", "c")}
    for name, off in zip(("b", "c"), shake, strict=True):
        sure[name][:, 2] += off * (1, 1, 0)
    told = moved_rig(known, sure, scene, "ref", SIZES)
    assert told is not None
    off = np.hypot(*(project(told["d"], scene) - project(here["d"], scene)).T)
    assert np.median(off) < 0.3
    assert np.median(np.hypot(*(project(known["d"], scene) - project(here["d"], scene)).T)) > 2, "or this says nothing"


def test_another_zoom_is_not_the_same_rig() -> None:
    known, here, scene = pose(rig(1260.0), BEFORE, 1e-6), pose(rig(), NOW, -2e-6), points(NOW, -2e-6)
    sure = {name: here[name] for name in ("ref", "b", "c")}
    assert moved_rig(known, sure, scene, "ref", SIZES) is None


def test_one_camera_in_common_tells_nothing() -> None:
    known, here, scene = pose(rig(), BEFORE, 1e-6), pose(rig(), NOW, -2e-6), points(NOW, -2e-6)
    assert moved_rig(known, {"ref": here["ref"], "b": here["b"]}, scene, "ref", SIZES) is None


def seen(here: dict[str, np.ndarray], scene: np.ndarray, wrong: float = 0.15) -> Tracks:
    """What the cameras see of scene points, to some tenths of a pixel, a share of it anywhere."""
    rng = np.random.default_rng(3)
    own = np.stack([project(p, scene) for p in here.values()], axis=1)
    own[:, 1:] += rng.normal(0, 0.2, own[:, 1:].shape)
    own[rng.uniform(size=own.shape[:2]) < 0.2] = np.nan  # not everything is seen by every camera
    astray = rng.uniform(size=own.shape[:2]) < wrong
    astray[:, 0] = False
    own[astray] += rng.normal(0, 60, (int(astray.sum()), 2))
    return Tracks(tuple(here), own)


@pytest.mark.parametrize("zoom", [0.8, 0.97, 1.0, 1.035, 1.3])
def test_the_common_zoom_is_told_by_matches_alone_wherever_the_plane_lies(zoom: float) -> None:
    focal = 1200 * zoom
    known, here, scene = pose(rig(), BEFORE, 1e-6), pose(rig(focal, focal), NOW, -2e-6), points(NOW, -2e-6)
    tied = ("ref", "b", "c")
    told = zoomed_rig(known, seen({name: here[name] for name in tied}, scene), SIZES)
    assert told is not None
    moved = moved_rig(told, {name: here[name] for name in tied}, scene, "ref", SIZES)
    assert moved is not None
    assert np.median(np.hypot(*(project(moved["d"], scene) - project(here["d"], scene)).T)) < 0.3
    unzoomed = moved_rig(known, {name: here[name] for name in tied}, scene, "ref", SIZES)
    assert (unzoomed is not None) == (zoom == 1), "a zoom that is not reckoned with fits nothing"


def test_a_rig_that_was_bent_in_between_agrees_with_no_zoom() -> None:
    known, scene = pose(rig(), BEFORE, 1e-6), points(NOW, -2e-6)
    bent = rig()
    k, R, t = bent["c"]
    bent["c"] = k, rotation(12) @ R, t + np.array([60, 25, 0])
    k, R, t = bent["b"]
    bent["b"] = k, rotation(-9) @ R, t + np.array([0, -50, 40])
    here = pose(bent, NOW, -2e-6)
    assert zoomed_rig(known, seen({name: here[name] for name in ("ref", "b", "c")}, scene), SIZES) is None


def test_matches_of_no_camera_of_the_rig_tell_no_zoom() -> None:
    nothing = Tracks(("ref", "b", "c"), np.zeros((0, 3, 2)))
    assert zoomed_rig(pose(rig(), BEFORE, 1e-6), nothing, SIZES) is None


def test_of_the_rigs_that_are_sure_of_what_is_asked_the_one_of_most_helps() -> None:
    poor = Rig({}, {"ref": 900, "b": 900, "c": 0})
    one = Rig({}, {"ref": 900, "b": 5000, "c": 700})
    both = Rig({}, {"ref": 900, "c": 700, "d": 700})
    assert helpful([poor, one, both], {"c", "d"}) is both
    assert helpful([poor, one], {"c", "d"}) is one
    assert helpful([poor], {"c", "d"}) is None
    assert helpful([poor, one, both], ()) is None
