"""The lamp calibrated from projections alone, against the simulator's rig, and followed through pictures it drew."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from mcsl_core.alignment.steady import SteadyView
from mcsl_core.alignment.tracking.fitting import Sighting, fit_view
from mcsl_core.alignment.tracking.following import End, Instant, follow
from mcsl_core.alignment.tracking.lamp import AT_REST, Lamp, LampView, calibrate
from mcsl_core.alignment.tracking.templates import Ground, templates
from mcsl_core.imaging.geometry import inverse, project
from mcsl_core.simulation import Scenario
from mcsl_core.simulation.rig import LampPose, Rig

SIZE = (480, 270)
NAMES = ("cam1", "cam2", "cam3", "cam4", "cam5")
HEIGHT = 1.5e-3  # of inverse distance that gamma 1 stands above gamma 0


def true_lamp() -> Lamp:
    """The simulator's rig, as a lamp at rest."""
    rig = Rig.of(Scenario(seed=7, size=SIZE, cameras=5))
    pose = LampPose(np.array([0.0, 0.0, 1000.0]), np.array([0.0, 0.0, 5.0]))
    cameras = [rig.pinhole(n, pose) for n in range(5)]
    home = cameras[0]
    distance = float((home.R @ np.zeros(3) + home.t)[2])
    mounts = {
        name: np.column_stack([c.R @ home.R.T, (c.t - c.R @ home.R.T @ home.t) / distance])
        for name, c in zip(NAMES, cameras, strict=True)
    }
    to_metric = np.zeros((4, 4))
    to_metric[:3, :3] = np.linalg.inv(home.K)
    to_metric[3] = [1e-4, -2e-4, 1 - 1e-4 * 240 + 2e-4 * 135, HEIGHT]
    return Lamp(dict.fromkeys(NAMES, SIZE), {n: float(c.K[0, 0]) for n, c in zip(NAMES, cameras, strict=True)},
                mounts, to_metric)  # fmt: skip


def scene(count: int = 60) -> np.ndarray:
    rng = np.random.default_rng(3)
    return np.column_stack([rng.uniform(40, 440, count), rng.uniform(30, 240, count), rng.uniform(-8, 16, count)])


MOVED = LampView(np.array([0.05, -0.11, 0.35]), np.array([0.12, -0.05, 0.03]), 0.04)


def seen(lamp: Lamp, view: LampView) -> dict[str, np.ndarray]:
    return {name: lamp.projection(name, view) for name in NAMES}


def test_a_rig_is_calibrated_from_its_projections() -> None:
    """Over another scale and sign of gamma and with noise of a tenth of a pixel, as reliefs have them."""
    true, points = true_lamp(), scene()
    rng = np.random.default_rng(1)

    def noisy(projection: np.ndarray) -> np.ndarray:
        at = project(projection, points) + rng.normal(0, 0.1, (len(points), 2))
        rows = [
            row
            for (x, y, g), (u, v) in zip(points, at, strict=True)
            for row in ([x, y, 1, g, 0, 0, 0, 0, -u * x, -u * y, -u, -u * g],
                        [0, 0, 0, 0, x, y, 1, g, -v * x, -v * y, -v, -v * g])
        ]  # fmt: skip
        found = np.linalg.svd(np.array(rows) / np.abs(rows).mean(axis=0))[2][-1] / np.abs(rows).mean(axis=0)
        return (found / found[10]).reshape(3, 4)

    poses = [seen(true, AT_REST), seen(true, MOVED)]
    poses = [{n: p if n == "cam1" and i == 0 else noisy(p) for n, p in pose.items()} for i, pose in enumerate(poses)]
    found = calibrate(poses, points, "cam1", dict.fromkeys(NAMES, SIZE))
    assert found is not None
    lamp, views = found
    for name in NAMES:
        assert lamp.focal[name] == pytest.approx(true.focal[name], rel=0.1)
        for view, pose in zip(views, poses, strict=True):
            off = np.hypot(*(project(lamp.projection(name, view), points) - project(pose[name], points)).T)
            assert np.median(off) < 0.5
    assert views[1].turn == pytest.approx(MOVED.turn, abs=0.02)
    assert views[1].zoom == pytest.approx(MOVED.zoom, abs=0.02)


def test_views_may_count_from_a_later_pose() -> None:
    """In which the reference camera does not see what the programme's pixels are."""
    true, points = true_lamp(), scene()
    poses = [seen(true, MOVED), seen(true, AT_REST)]
    found = calibrate(poses, points, "cam1", dict.fromkeys(NAMES, SIZE))
    assert found is not None
    lamp, views = found
    for view, pose in zip(views, poses, strict=True):
        for name in NAMES:
            off = project(lamp.projection(name, view), points) - project(pose[name], points)
            assert np.hypot(*off.T).max() < 0.1
    assert lamp.focal["cam2"] == pytest.approx(true.focal["cam2"] * np.exp(MOVED.zoom), rel=0.02)


def test_what_no_rigid_rig_explains_is_refused() -> None:
    true, points = true_lamp(), scene()
    poses = [seen(true, AT_REST), seen(true, MOVED)]
    rng = np.random.default_rng(2)
    bent = {n: p + rng.normal(0, 0.2, (3, 4)) * np.abs(p) for n, p in poses[1].items()}
    assert calibrate([poses[0], bent], points, "cam1", dict.fromkeys(NAMES, SIZE)) is None
    assert calibrate([{"cam1": poses[0]["cam1"]}], points, "cam1", dict.fromkeys(NAMES, SIZE)) is None


def test_a_view_is_found_among_many_wrong_places() -> None:
    lamp, points, rng = true_lamp(), scene(200), np.random.default_rng(4)
    sightings = []
    for name in NAMES:
        at = project(lamp.projection(name, MOVED), points) + rng.normal(0, 0.2, (200, 2))
        at[:100] += rng.uniform(4, 30, (100, 2))  # an arm that goes another way
        sightings.append(Sighting(name, SIZE[0], points, at))
    near = LampView.of(MOVED.numbers + 0.004)
    fit = fit_view(sightings, lamp.projection, near)
    assert 0.4 < fit.share < 0.6
    for name in NAMES:
        off = project(lamp.projection(name, fit.view), points) - project(lamp.projection(name, MOVED), points)
        assert np.hypot(*off.T).max() < 0.4


def drawn(lamp: Lamp, ground: Ground, texture: np.ndarray, camera: str, view: LampView) -> np.ndarray:
    """A camera's picture of a texture that lies over the programme's pixels at gamma 0."""
    projection = lamp.projection(camera, view)
    back = inverse(projection[:, :3])
    picture = cv2.warpPerspective(texture, np.linalg.inv(back) @ np.diag([0.5, 0.5, 1.0]), SIZE, flags=cv2.INTER_AREA)
    return np.asarray(picture, np.uint8)


def test_a_lamp_is_followed_from_both_ends_past_an_arm() -> None:
    """A camera is late by half a frame; an arm covers a third of every picture, another in each frame."""
    lamp, rng = true_lamp(), np.random.default_rng(5)
    texture = cv2.GaussianBlur(rng.integers(0, 255, (2 * SIZE[1], 2 * SIZE[0])).astype(np.uint8), (0, 0), 3)
    texture = cv2.normalize(texture, None, 0, 255, cv2.NORM_MINMAX)  # pyright: ignore[reportCallIssue, reportArgumentType]
    ground = Ground.of(SIZE, np.zeros((8, 12)))
    ends = []
    for view in (AT_REST, MOVED):
        whole = np.ones(SIZE[::-1], bool)
        views = {
            n: SteadyView(cv2.cvtColor(drawn(lamp, ground, texture, n, view), cv2.COLOR_GRAY2BGR), whole)  # pyright: ignore
            for n in NAMES
        }
        made = templates(ground, views, seen(lamp, view), lamp.sizes)
        ends.append(End(view, ground, made, dict.fromkeys(NAMES, np.eye(3))))
    way = [0.0, 0.0, *np.linspace(0, 1, 21) ** 2 * (3 - 2 * np.linspace(0, 1, 21)), 1.0, 1.0]
    late = {"cam3": 0.5}

    def at(frame: float) -> LampView:
        return LampView.of(np.interp(frame, range(len(way)), way) * MOVED.numbers)

    instants = []
    for frame in range(len(way)):
        pictures = {n: drawn(lamp, ground, texture, n, at(frame - late.get(n, 0.0))) for n in NAMES}
        for picture in pictures.values():
            x = int(rng.integers(0, 2 * SIZE[0] // 3))
            picture[:, x : x + SIZE[0] // 3] = 120
        instants.append(Instant(frame, pictures, late))
    found = follow(lamp, ends[0], ends[1], instants)
    points = scene()
    for instant, view in zip(instants, found, strict=True):
        assert view is not None
        for name in NAMES:
            off = project(lamp.projection(name, view), points) - project(
                lamp.projection(name, at(instant.frame)), points
            )
            assert np.median(np.hypot(*off.T)) < 0.8, instant.frame
