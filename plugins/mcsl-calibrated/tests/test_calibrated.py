"""The calibration against a scene whose cameras and places are known; the scene shares no code with it."""

from __future__ import annotations

import subprocess
import sys
from itertools import combinations

import cv2
import mcsl_calibrated as calibrated
import numpy as np
import pytest
from mcsl_calibrated.calibration import calibrate
from mcsl_calibrated.tracks import CalibrationSettings, build_tracks

from mcsl_core.hooks import Correspondences, discover

SIZE = (960, 540)


def pentagon(focal_per_width: float, height_mm: float = 1000.0) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """camera -> (intrinsics, (3, 4) pose) of five cameras on a circle of 30 cm that look at the origin."""
    cameras = {}
    for number in range(5):
        turn = np.deg2rad(72 * number - 90)
        at = np.array([300 * np.cos(turn), 300 * np.sin(turn), height_mm])
        ahead = -at / np.linalg.norm(at)
        right = np.cross(ahead, [np.cos(turn), np.sin(turn), 0])
        right /= np.linalg.norm(right)
        turned = np.stack([right, np.cross(ahead, right), ahead])
        focal = focal_per_width * SIZE[0]
        inner = np.array([[focal, 0, (SIZE[0] - 1) / 2], [0, focal, (SIZE[1] - 1) / 2], [0, 0, 1.0]])
        cameras[f"cam{number}"] = (inner, np.column_stack([turned, -turned @ at]))
    return cameras


def shown(camera: tuple[np.ndarray, np.ndarray], places: np.ndarray) -> np.ndarray:
    own = (places @ camera[1][:, :3].T + camera[1][:, 3]) @ camera[0].T
    return own[:, :2] / own[:, 2:]


def matches(cameras, places, *, seed=0, noise_px=0.3, share=0.6, weight=None):
    """Correspondences of all camera pairs: a random share of the places, found to ``noise_px``."""
    rng = np.random.default_rng(seed)
    weight = np.ones(len(places)) if weight is None else weight
    pairs = {}
    for a, b in combinations(sorted(cameras), 2):
        points = [shown(cameras[name], places) + rng.normal(0, noise_px, (len(places), 2)) for name in (a, b)]
        kept = np.all([(p > 0).all(axis=1) & (p < SIZE).all(axis=1) for p in points], axis=0)
        kept &= rng.random(len(places)) < share
        pairs[a, b] = Correspondences(points[0][kept], points[1][kept], weight[kept], np.ones(kept.sum(), np.int64))
    return pairs


def relief(seed: int, count: int = 500, height_mm: float = 30.0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-110, 110, count), rng.uniform(-60, 60, count)
    return np.column_stack([x, y, height_mm / 2 * np.sin(x / 30) * np.cos(y / 25)])


@pytest.mark.parametrize("focal", [1.1, 1.85])
def test_the_focal_length_and_the_places_are_found(focal):
    cameras, places = pentagon(focal), relief(1)
    names = sorted(cameras)
    pairs = {(names.index(a), names.index(b)): p for (a, b), p in matches(cameras, places).items()}
    tracks = build_tracks(pairs)
    model = calibrate(tracks, dict.fromkeys(range(5), SIZE), 1.5, CalibrationSettings())
    assert model is not None
    assert sorted(model.poses) == [0, 1, 2, 3, 4]
    assert model.cameras[0][0, 0] / SIZE[0] == pytest.approx(focal, rel=0.02)
    assert model.error * np.hypot(*SIZE) < 1.0
    # Distances between the cameras agree with the pentagon's, up to one scale.
    found = [-model.poses[c][:, :3].T @ model.poses[c][:, 3] for c in range(5)]
    true = [-cameras[n][1][:, :3].T @ cameras[n][1][:, 3] for n in names]
    ratio = [
        np.linalg.norm(found[i] - found[j]) / np.linalg.norm(true[i] - true[j]) for i, j in combinations(range(5), 2)
    ]
    assert np.ptp(ratio) / np.mean(ratio) < 0.03


def test_a_flat_scene_is_laid_right_though_it_leaves_the_focal_length_open():
    """All on one plane: many calibrations explain it, and each of them must induce the one true homography."""
    cameras, places = pentagon(1.6), relief(2, height_mm=0.0)
    result = calibrated.Calibrated().align(matches(cameras, places), dict.fromkeys(cameras, SIZE), "cam0")
    assert len(result.homographies) + len(result.weak) == 5
    assert len(result.homographies) >= 3
    for name, homography in result.homographies.items():
        moved = cv2.perspectiveTransform(shown(cameras[name], places)[None], homography)[0]
        assert np.sqrt(np.square(moved - shown(cameras["cam0"], places)).sum(axis=1).mean()) < 1.0


def test_hands_above_the_field_do_not_draw_the_plane_to_themselves():
    """A fifth of the weight lies 20 cm beside the field and 8 cm above it."""
    cameras, field = pentagon(1.6), relief(3)
    hands = relief(4, 120) * [0.2, 0.5, 0.3] + [170, 0, 80]
    places = np.vstack([field, hands])
    result = calibrated.Calibrated().align(matches(cameras, places), dict.fromkeys(cameras, SIZE), "cam0")
    target = shown(cameras["cam0"], field)
    for name in sorted(set(cameras) - {"cam0"}):
        source = shown(cameras[name], field)
        best, _ = cv2.findHomography(source, target, 0)
        off, least = (
            np.sqrt(np.square(cv2.perspectiveTransform(source[None], h)[0] - target).sum(axis=1).mean())
            for h in (result.homographies[name], best)
        )
        assert off < 1.15 * least


def test_cameras_of_two_sizes_are_calibrated_together():
    cameras, places = pentagon(1.6), relief(5)
    half = np.array([[0.5, 0, -0.25], [0, 0.5, -0.25], [0, 0, 1.0]])
    pairs = matches(cameras, places)
    for (a, b), pair in list(pairs.items()):
        if b == "cam4":
            pairs[a, b] = Correspondences(pair.a, pair.b * 0.5 - 0.25, pair.weight, pair.seen)
    sizes = dict.fromkeys(cameras, SIZE) | {"cam4": (480, 270)}
    result = calibrated.Calibrated().align(pairs, sizes, "cam0")
    source, target = shown((half @ cameras["cam4"][0], cameras["cam4"][1]), places), shown(cameras["cam0"], places)
    best, _ = cv2.findHomography(source, target, 0)
    off, least = (
        np.sqrt(np.square(cv2.perspectiveTransform(source[None], h)[0] - target).sum(axis=1).mean())
        for h in (result.homographies["cam4"], best)
    )
    assert off < 1.15 * least


def test_a_track_never_holds_two_cells_of_one_camera():
    rng = np.random.default_rng(6)
    pairs = {
        (a, b): Correspondences(
            rng.uniform(0, 60, (300, 2)),
            rng.uniform(0, 60, (300, 2)),
            rng.uniform(0.01, 1, 300),
            np.ones(300, np.int64),
        )
        for a, b in combinations(range(4), 2)
    }
    tracks = build_tracks(pairs)
    assert len(np.unique(np.column_stack([tracks.place, tracks.camera]), axis=0)) == len(tracks.place)
    assert np.bincount(tracks.place).min() >= 2
    assert (tracks.weight > 0).all()


def test_tracks_join_what_all_cameras_see():
    cameras, places = pentagon(1.6), relief(7, 60)
    pairs = matches(cameras, places, noise_px=0.0, share=1.0)
    tracks = build_tracks({(int(a[3]), int(b[3])): p for (a, b), p in pairs.items()})
    assert np.mean(np.bincount(tracks.place) == 5) > 0.9


def test_the_plane_of_flat_places_is_exact():
    rng = np.random.default_rng(8)
    x, y = rng.uniform(-100, 100, (2, 50))
    places = np.column_stack([x, y, 900 + 0.2 * x - 0.1 * y])
    normal = calibrated.fit_plane(places, np.ones(50))
    np.testing.assert_allclose(places @ normal, 1, atol=1e-9)


def test_it_is_on_offer_under_its_name():
    offer = discover().choose("aligner", "calibrated")
    assert offer.package == "mcsl-calibrated"
    assert isinstance(offer.implementation, calibrated.Calibrated)


def test_the_package_leaves_the_process_alone() -> None:
    """Every `mcsl` process imports its plugins, and pycolmap's logging library takes over SIGTERM when it is loaded."""
    code = "import mcsl_calibrated, sys; sys.exit('pycolmap' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
