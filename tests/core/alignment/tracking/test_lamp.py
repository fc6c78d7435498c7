"""The lamp calibrated from projections alone, against the simulator's rig, and followed through pictures it drew."""

from __future__ import annotations

import numpy as np
import pytest
from lamp_scene import MOVED, NAMES, SIZE, dense_slopes, scene, seen, true_lamp, turned

from mcsl_core.alignment.tracking.calibration import Calibration, calibrate
from mcsl_core.alignment.tracking.fitting import Sighting, fit_view
from mcsl_core.alignment.tracking.following import BackgroundTracker
from mcsl_core.alignment.tracking.lamp import AT_REST, LampView
from mcsl_core.hooks.guards import read_only
from mcsl_core.imaging.geometry import project


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
    lamp, views = found.lamp, found.views
    for name in NAMES:
        assert lamp.focal[name] == pytest.approx(true.focal[name], rel=0.1)
        for view, pose in zip(views, poses, strict=True):
            off = np.hypot(*(project(lamp.projection(name, view), points) - project(pose[name], points)).T)
            assert np.median(off) < 0.5
    assert views[1].turn == pytest.approx(MOVED.turn, abs=0.02)
    assert views[1].zoom == pytest.approx(MOVED.zoom, abs=0.02)


def test_the_calibrations_slopes_are_those_of_what_it_minimises() -> None:
    """By central differences, with poses that do not see every camera, and the views counted from the first."""
    true, points = true_lamp(), scene(12)
    poses = [seen(true, view) for view in (AT_REST, MOVED, LampView.of(-MOVED.numbers))]
    del poses[1]["cam3"], poses[2]["cam1"]
    problem = Calibration(poses, points, "cam1", NAMES[1:], dict.fromkeys(NAMES, SIZE))
    start = problem.start(1.5, 1)
    numbers = start + np.random.default_rng(6).normal(0, 0.02, len(start))
    steps = 1e-6 * np.eye(len(numbers))
    differences = [(problem.off(numbers + step) - problem.off(numbers - step)) / 2e-6 for step in steps]
    assert dense_slopes(problem, numbers) == pytest.approx(np.stack(differences, axis=-1), abs=1e-7)


def test_a_lamp_that_cannot_be_written_to_tells_the_same() -> None:
    """As plugins are handed it."""
    lamp, view = true_lamp(), MOVED
    locked, locked_view = read_only(lamp), read_only(view)
    for name in NAMES:
        assert (locked.projection(name, locked_view) == lamp.projection(name, view)).all()


def test_views_may_count_from_a_later_pose() -> None:
    """In which the reference camera does not see what the programme's pixels are."""
    true, points = true_lamp(), scene()
    poses = [seen(true, MOVED), seen(true, AT_REST)]
    found = calibrate(poses, points, "cam1", dict.fromkeys(NAMES, SIZE))
    assert found is not None
    lamp, views = found.lamp, found.views
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


def test_a_lamp_is_followed_from_both_ends_past_an_arm() -> None:
    """A camera is late by half a frame; an arm covers a third of every picture, another in each frame."""
    way = turned(arm=1 / 3)
    found = BackgroundTracker().follow(way.lamp, way.before, way.after, way.instants)
    for index, view in enumerate(found):
        assert view is not None
        assert way.off(index, view) < 0.8, index


OFF = np.array([[1.03, 0.02, 9.0], [-0.01, 0.98, 12.0], [4e-5, -3e-5, 1]])


@pytest.mark.parametrize(("pose", "camera"), [(0, "cam1"), (2, "cam3")])
def test_a_camera_that_one_pose_has_elsewhere_is_refused_there(pose: int, camera: str) -> None:
    """The reference camera of the first pose too, which all others are laid over."""
    true, points = true_lamp(), scene()
    poses = [dict(seen(true, view)) for view in (AT_REST, MOVED, LampView.of(-MOVED.numbers))]
    right = poses[pose][camera]
    poses[pose][camera] = OFF @ right
    found = calibrate(poses, points, "cam1", dict.fromkeys(NAMES, SIZE))
    assert found is not None
    assert found.refused == ((pose, camera),)
    off = project(found.lamp.projection(camera, found.views[pose]), points) - project(right, points)
    assert np.hypot(*off.T).max() < 0.5


def test_of_two_poses_that_have_a_camera_turned_otherwise_neither_is_refused() -> None:
    """It may be turned in its mount in either."""
    true, points = true_lamp(), scene()
    poses = [dict(seen(true, AT_REST)), dict(seen(true, MOVED))]
    middle = [[1, 0, (SIZE[0] - 1) / 2], [0, 1, (SIZE[1] - 1) / 2], [0, 0, 1]]
    turn = np.array([[0.9998, -0.02, 0], [0.02, 0.9998, 0], [0, 0, 1]])
    poses[1]["cam3"] = middle @ turn @ np.linalg.inv(middle) @ poses[1]["cam3"]
    found = calibrate(poses, points, "cam1", dict.fromkeys(NAMES, SIZE))
    assert found is not None
    assert not found.rigid
    assert not found.refused


def test_a_rig_without_a_camera_that_is_off_refuses_none() -> None:
    true, points = true_lamp(), scene()
    found = calibrate([seen(true, AT_REST), seen(true, MOVED)], points, "cam1", dict.fromkeys(NAMES, SIZE))
    assert found is not None
    assert found.rigid
    assert not found.refused
