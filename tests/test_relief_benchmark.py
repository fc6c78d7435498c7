"""`benchmarks.relief` by warps and programmes whose displacement is known."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from benchmarks import ideal, relief
from benchmarks.ideal_geometry import Map, Points
from benchmarks.relief_baselines import SeenPose, baseline, fitted, moving_dlt, thin_plate
from benchmarks.relief_page import goal, markdown, reaches, worse
from benchmarks.relief_stills import planar_recording
from mcsl_core.alignment.correspondences import Correspondences
from mcsl_core.alignment.relief.matching import Views
from mcsl_core.edl import IDENTITY, Camera, Edl, Media, Pose, Shot
from mcsl_core.imaging.geometry import transform_points
from mcsl_core.timing import FrameRange

SIZE = (960, 540)
TILTED = np.array([[0.9, 0.2, 40.0], [-0.15, 1.0, 30.0], [1e-4, -5e-5, 1.0]])
FITS = [moving_dlt, thin_plate]


def bump(points: Points, height: float = 15.0) -> Points:
    """What a hill in the middle adds to where a plane lies."""
    far = np.square((points - np.array(SIZE) / 2) / (150, 120)).sum(axis=1)
    return np.column_stack([height * np.exp(-far), -0.5 * height * np.exp(-far)])


def matches(height: float, *, wrong: int = 0) -> Correspondences:
    """Camera "b"'s pixels and where the reference has them: a plane with a hill, some of them wrong."""
    x, y = np.meshgrid(np.arange(20, 940, 16.0), np.arange(20, 520, 16.0))
    b = np.stack([x.ravel(), y.ravel()], axis=1)
    a = transform_points(TILTED, b) + bump(b, height)
    a[: wrong * 7 : 7] += 300
    return Correspondences(a, b, np.ones(len(a)), np.ones(len(a), np.int64))


def some(count: int = 200, margin: float = 100) -> Points:
    return np.random.default_rng(4).uniform(margin, np.array(SIZE) - margin, (count, 2))


@pytest.mark.parametrize("fit", FITS)
def test_a_plane_is_a_plane_beyond_the_matches_too_and_wrong_ones_are_left_out(fit: Callable) -> None:
    lay = fitted(fit, matches(0.0, wrong=60), [SIZE, SIZE])
    assert lay is not None
    for points in (some(), some(margin=-60)):
        assert np.abs(lay(points) - transform_points(TILTED, points)).max() < 0.05


@pytest.mark.parametrize("fit", FITS)
def test_a_hill_is_followed_where_there_are_matches(fit: Callable) -> None:
    lay = fitted(fit, matches(15.0), [SIZE, SIZE])
    assert lay is not None
    at = some()
    off = np.linalg.norm(lay(at) - transform_points(TILTED, at) - bump(at), axis=1)
    assert np.percentile(np.linalg.norm(bump(at), axis=1), 95) > 8
    assert np.percentile(off, 95) < 1.0


def test_few_matches_make_no_warp() -> None:
    few = matches(0.0).where(np.arange(len(matches(0.0))) < 19)
    assert fitted(thin_plate, few, [SIZE, SIZE]) is None


# ------------------------------------------------------------------------------------------------------- a programme


def programme(*, shift: float = 0.0) -> Edl:
    """Two cameras in one pose; "b" lies by its plane, off by ``shift`` pixels."""
    move = np.array([[1, 0, shift], [0, 1, 0], [0, 0, 1.0]])
    rows = tuple(tuple(float(v) for v in row) for row in move @ TILTED)
    pose = Pose(FrameRange(0, 10), {"a": IDENTITY, "b": rows})  # pyright: ignore[reportArgumentType]
    cameras = tuple(Camera(name, (Media(f"{name}.mp4", 10),), SIZE, 10) for name in "ab")  # pyright: ignore
    return Edl(
        rate=10, size=SIZE, frames=10, reference="a", cameras=cameras, movements=(), poses=(pose,),
        shots=(Shot(FrameRange(0, 10), "a"),),
    )  # fmt: skip


def seen_pose(height: float) -> SeenPose:
    return SeenPose(Views("a", {"a": SIZE, "b": SIZE}, {}, []), None, {("a", "b"): matches(height)})


def test_what_is_off_by_so_much_is_told_and_the_warps_follow_the_hill(tmp_path: Path) -> None:
    made, at = programme(shift=3.0), some()
    plane = np.array(made.poses[0].homographies["b"])
    views = [(0, "b", at, transform_points(TILTED, at) + bump(at))]
    own = relief.Recorded("501", "", made, tmp_path, views)
    warps = baseline(made, [seen_pose(15.0)], thin_plate)
    ways: dict[str, Callable[[int, str], Map]] = {
        "plane": lambda index, camera: lambda points: transform_points(plane, points),
        "spline": lambda index, camera: warps[index, camera],
        "surface": lambda index, camera: lambda points: transform_points(TILTED, points) + bump(points),
    }
    figures = relief.off(own, ways)
    (view,) = figures["views"]
    assert figures["pooled"]["surface"] == [0, 0, 0]
    assert figures["pooled"]["spline"][2] < 1
    assert view["plane"][1] == pytest.approx(np.sqrt(np.square(bump(at) - (3, 0)).sum(axis=1).mean()), abs=0.002)
    assert view["moved"] == view["plane"]
    assert 0 < view["best plane"][1] < view["plane"][1]
    assert set(baseline(made, [None], thin_plate)) == set()


@pytest.mark.slow
def test_the_wall_in_two_photographs_is_a_recording_with_a_truth(tmp_path: Path, shared_data: Path) -> None:
    source = shared_data / "planar"
    if not source.is_dir():
        pytest.skip("no shared data here")
    made = planar_recording(source, tmp_path / "planar")
    assert sorted(path.name for path in made.iterdir()) == ["graf1.mp4", "graf3.mp4"]


# ------------------------------------------------------------------------------------------------------------ the page


def figures(name: str, surface: list[float], plane: float = 6.0) -> dict:
    ways = {way: [3.0, plane, 9.0] for way in ("plane", "best plane", "APAP", "spline", "flow")} | {"surface": surface}
    moved = {"moved": [0.1, 0.2, 0.3]}
    steady = {"manual": [20.0, 10.0], "surface": [25.0, 2.5], "plane": [22.0, None]}
    return {
        "name": name, "scene": "10 mm", "views": [{"pose": 0, "camera": "cam2", **ways, **moved}], "pooled": ways,
        "reliefs": [4], "cameras": 5, "cost": {"seconds": [4.0, 6.0], "yardstick": 0.5},
        "steadiness": {"switches": 7, "rows": steady},
    }  # fmt: skip


def test_goals_are_those_of_the_kind_of_recording() -> None:
    assert goal("701") == (0.4, 0.9, 2.0)
    assert goal("suturing:623") == goal("limb:616") == (0.7, 1.5, 3.0)
    assert goal("suturing") == (1.0, 2.5, 5.0)
    assert reaches(figures("701", [0.4, 0.9, 2.0]))
    assert not reaches(figures("701", [0.4, 0.9, 2.1]))


def test_the_page_tells_what_reaches_its_goals_and_what_is_worse_than_its_plane() -> None:
    good, bad = figures("701", [0.3, 0.8, 1.9]), figures("limb:616", [0.6, 7.0, 9.0])
    assert worse(good) == []
    page = markdown([good, bad, figures("planar", [1.0, 1.0, 1.0]), figures("board", [1.0, 1.0, 1.0])])
    assert "1 of 2 recordings reach their goals; 1 of 2 views are worse" in page
    assert "**0.30 / 0.80 / 1.90** | 0.40 / 0.90 / 2.00 | none |" in page
    assert "cam2 in pose 0 (6.00 to 7.00)" in page
    assert "| 701 | 2 | 5.0 / 6.0 | 0.50 | 10 |" in page
    assert "| +25 % | -75 % |" in page
    assert "22.0 / no data" in page
    assert "| planar | 10 mm | 1 of 4 | 4 | 0.10 / 0.20 / 0.30 | 3.00 / 6.00 / 9.00 | 1.00 / 1.00 / 1.00 |" in page
    assert "| board | 10 mm | 1 of 4 | 4 | 0.10 / 0.20 / 0.30 | – | – |" in page


def test_recordings_to_tune_on_are_kept_apart() -> None:
    finals, tuning = (*relief.PLAIN, *relief.FAMILIES), relief.TUNING
    assert len(relief.PLAIN) == 8
    assert all(ideal.is_tuning({"name": name}) for name in tuning)
    assert not any(ideal.is_tuning({"name": name}) for name in finals)
