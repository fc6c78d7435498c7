"""A camera that one pose cannot see is told by another, as long as the rig is the same."""

from __future__ import annotations

import numpy as np

from mcsl_core.alignment.relief.rig import moved_rig
from mcsl_core.imaging.geometry import project

SIZES = dict.fromkeys(("ref", "b", "c", "d"), (960, 540))
K = np.array([[1200.0, 0, 480], [0, 1200.0, 270], [0, 0, 1]])


def rotation(degrees: float) -> np.ndarray:
    a, t = np.radians(degrees), np.radians(8)
    turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    return np.array([[1, 0, 0], [0, np.cos(t), -np.sin(t)], [0, np.sin(t), np.cos(t)]]) @ turn


def rig(focal: float = 1200.0) -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    aim = np.array([0, 0, 900.0])
    k = np.array([[focal, 0, 480], [0, focal, 270], [0, 0, 1]])
    made = {"ref": (K, np.eye(3), np.zeros(3))}
    for n, name in enumerate(("b", "c", "d"), start=1):
        R = rotation(72 * n)
        made[name] = (k, R, aim - R @ aim + (40 * n, -30, 10))
    return made


def pose(cameras, plane: np.ndarray, unit: float) -> dict[str, np.ndarray]:
    """Projections over the plane 1/Z = plane . x, gamma in that unit: all that a pose alone can tell."""
    made = {}
    for name, (k, R, t) in cameras.items():
        A = k @ R @ np.linalg.inv(K) + np.outer(k @ t, plane)
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
