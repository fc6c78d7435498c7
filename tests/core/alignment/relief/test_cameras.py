"""Projections from matches alone: right to a fraction of the matches' noise, whatever else was matched."""

from __future__ import annotations

import numpy as np
import pytest

from mcsl_core.alignment.correspondences import Correspondences
from mcsl_core.alignment.relief.cameras import confirmed, locate, solve_cameras, tracks_of
from mcsl_core.imaging.geometry import project

SIZE = (960, 540)
SIZES = {name: SIZE for name in ("ref", "b", "c", "d", "poor")}


def turned(degrees: float) -> np.ndarray:
    """(3, 3): a turn in the picture's plane, then a tilt of a few degrees."""
    a, t = np.radians(degrees), np.radians(8)
    turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    return np.array([[1, 0, 0], [0, np.cos(t), -np.sin(t)], [0, np.sin(t), np.cos(t)]]) @ turn


class Rig:
    """Pinholes of 1200 px about a relief some 900 mm away; all in the reference camera's frame, mm."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.K = np.array([[1200.0, 0, 480], [0, 1200.0, 270], [0, 0, 1]])
        self.poses = {"ref": (np.eye(3), np.zeros(3))}
        for number, name in enumerate(("b", "c", "d", "poor"), start=1):
            R = turned(72 * number)
            aim = np.array([0, 0, 900.0])
            self.poses[name] = (R, aim - R @ aim + self.rng.normal(0, 60, 3) * (1, 1, 0.3))

    def scene(self, count: int) -> np.ndarray:
        """(N, 3): a plane of drapes with a hill of 50 mm in the middle."""
        x, y = self.rng.uniform(-330, 330, count), self.rng.uniform(-180, 180, count)
        return np.column_stack([x, y, 900 - 50 * np.exp(-(x**2 + y**2) / 90**2) + 0.05 * x])

    def seen(self, name: str, points: np.ndarray) -> np.ndarray:
        R, t = self.poses[name]
        moved = (points @ R.T + t) @ self.K.T
        return moved[:, :2] / moved[:, 2:]

    def plane(self, name: str) -> np.ndarray:
        """Camera pixel -> reference pixel over the plane Z = 900, a little off, as points would have it."""
        R, t = self.poses[name]
        there = self.K @ (R + np.outer(t, [0, 0, 1 / 900])) @ np.linalg.inv(self.K)
        off = np.array([[1, 0.002, 6.0], [-0.002, 1, -5.0], [0, 1e-6, 1]])
        return off @ np.linalg.inv(there / there[2, 2])


@pytest.fixture(scope="module")
def rig() -> Rig:
    return Rig(3)


def matches(rig: Rig, a: str, b: str, scene: np.ndarray, noise: float, wrong: float) -> Correspondences:
    """Of a pair of cameras: that much noise in b, that share of false ones."""
    p, q = rig.seen(a, scene), rig.seen(b, scene) + rig.rng.normal(0, noise, (len(scene), 2))
    false = rig.rng.random(len(scene)) < wrong
    q[false] += rig.rng.uniform(-25, 25, (int(false.sum()), 2))
    ones = np.ones(len(scene))
    return Correspondences(p, q, ones, ones.astype(np.int64))


def test_projections_are_found_among_false_matches(rig: Rig) -> None:
    scene = rig.scene(900)
    names = ["ref", "b", "c", "d"]
    pairs = {("ref", n): matches(rig, "ref", n, scene[i::2], 0.2, 0.2) for i, n in enumerate(("b", "c"))}
    pairs["ref", "d"] = matches(rig, "ref", "d", scene[::3], 0.2, 0.2)
    pairs["b", "c"] = matches(rig, "b", "c", rig.scene(200), 0.2, 0.2)
    pairs["c", "d"] = matches(rig, "c", "d", rig.scene(200), 0.2, 0.2)
    planes = {n: rig.plane(n) if n != "ref" else np.eye(3) for n in names}
    tracks = tracks_of(pairs, names)
    projections = solve_cameras(tracks, planes, SIZES)
    np.testing.assert_allclose(projections["ref"], np.eye(3, 4))

    # Points that nothing was matched at: each has one gamma by which all cameras see it where they do.
    fresh = rig.scene(300)
    at = rig.seen("ref", fresh)
    own = {("ref", n): matches(rig, "ref", n, fresh, 0.0, 0.0) for n in ("b", "c", "d")}
    there = locate(tracks_of(own, names), projections, SIZES)
    assert len(there.points) == len(fresh)
    order = np.lexsort(at.round(1).T[::-1])
    for name in names[1:]:
        off = project(projections[name], there.points) - rig.seen(name, fresh)[order]
        assert np.median(np.hypot(*off.T)) < 0.15, name
        assert np.percentile(np.hypot(*off.T), 95) < 0.5, name
    # The plane leaves some pixels, or this would say nothing.
    left = project(projections["b"], there.points * (1, 1, 0)) - rig.seen("b", fresh)[order]
    assert np.hypot(*left.T).max() > 4


def test_one_false_match_does_not_move_a_point_that_the_others_agree_on(rig: Rig) -> None:
    scene = rig.scene(400)
    names = ["ref", "b", "c", "d"]
    pairs = {("ref", n): matches(rig, "ref", n, scene, 0.1, 0.0) for n in names[1:]}
    planes = {n: rig.plane(n) if n != "ref" else np.eye(3) for n in names}
    projections = solve_cameras(tracks_of(pairs, names), planes, SIZES)
    good = locate(tracks_of(pairs, names), projections, SIZES)
    assert len(good.points) == 400
    assert max(good.residual_px.values()) < 0.3
    right = pairs["ref", "b"]
    astray = right.b + np.where(np.arange(400)[:, None] % 4 == 0, 17.0, 0.0)
    pairs["ref", "b"] = Correspondences(right.a, astray, right.weight, right.seen)
    kept = locate(tracks_of(pairs, names), projections, SIZES)
    assert len(kept.points) > 390
    near = np.hypot(*(kept.points[:, None, :2] - good.points[None, :, :2]).transpose(2, 0, 1)).argmin(axis=1)
    off = project(projections["d"], kept.points) - project(projections["d"], good.points[near])
    assert np.percentile(np.hypot(*off.T), 95) < 1


def test_tracks_join_what_the_reference_shares_with_all(rig: Rig) -> None:
    scene = rig.scene(50)
    pairs = {("ref", n): matches(rig, "ref", n, scene, 0.0, 0.0) for n in ("b", "c")}
    pairs["b", "c"] = matches(rig, "b", "c", scene, 0.0, 0.0)
    pairs["b", "poor"] = matches(rig, "b", "poor", scene, 0.0, 0.0)
    tracks = tracks_of(pairs, ["ref", "b", "c"])
    assert tracks.counted() == {"ref": 50, "b": 100, "c": 100}
    first = tracks.seen[:50]
    order = np.lexsort(rig.seen("ref", scene).round(1).T[::-1])
    for k, name in enumerate(("ref", "b", "c")):
        np.testing.assert_allclose(first[:, k], rig.seen(name, scene)[order], atol=1e-9)
    assert len(tracks_of({}, ["ref", "b"]).seen) == 0


def test_a_camera_that_was_tied_by_chance_is_told_by_the_others(rig: Rig) -> None:
    scene = rig.scene(500)
    names = ["ref", "b", "c", "d"]
    pairs = {("ref", n): matches(rig, "ref", n, scene, 0.1, 0.05) for n in names[1:]}
    chance = pairs["ref", "d"]
    astray = chance.b + rig.rng.uniform(-12, 12, chance.b.shape)
    planes = {n: rig.plane(n) if n != "ref" else np.eye(3) for n in names}
    right = confirmed(tracks_of(pairs, names), solve_cameras(tracks_of(pairs, names), planes, SIZES), SIZES)
    assert set(right) == {"b", "c", "d"}
    assert all(judged > 400 and share > 0.9 for judged, share in right.values())
    pairs["ref", "d"] = Correspondences(chance.a, astray, chance.weight, chance.seen)
    tracks = tracks_of(pairs, names)
    found = confirmed(tracks, solve_cameras(tracks, planes, SIZES), SIZES)
    assert found["d"][1] < 0.6
    assert min(found["b"][1], found["c"][1]) > 0.9
    alone = {pair: m for pair, m in pairs.items() if pair != ("ref", "d")}
    two = tracks_of({("ref", "b"): alone["ref", "b"]}, names[:2])
    assert confirmed(two, {n: np.eye(3, 4) for n in names[:2]}, SIZES) == {"b": (0, 0.0)}


def test_nothing_is_located_by_no_points() -> None:
    nothing = locate(tracks_of({}, ["ref", "b"]), {"ref": np.eye(3, 4), "b": np.eye(3, 4)}, SIZES)
    assert nothing.points.shape == (0, 3)
    assert set(nothing.residual_px) == {"ref", "b"}


def test_a_camera_that_no_match_speaks_for_stays_where_it_was(rig: Rig) -> None:
    scene = rig.scene(300)
    names = ["ref", "b", "c"]
    pairs = {("ref", "b"): matches(rig, "ref", "b", scene, 0.2, 0.0)}
    start = {n: rig.plane(n) if n != "ref" else np.eye(3) for n in names}
    found = solve_cameras(tracks_of(pairs, names), start, SIZES)
    flat = np.column_stack([np.linalg.inv(start["c"]), np.zeros(3)])
    np.testing.assert_allclose(found["c"], flat / flat[2, 2], rtol=1e-6, atol=1e-6)
