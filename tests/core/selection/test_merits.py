"""Merits: cameras that are out of focus, smaller, slanted or far from the reference camera, and the shots they get."""

from __future__ import annotations

import json
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
import pytest
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.alignment.aligned_views import AlignedPose
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.selection.merits import resolution, sharpness, viewpoint, with_merits
from mcsl_core.selection.selectors import Fixed, LeastOccluded, ShortestPath
from mcsl_core.selection.worth import ViewingWorth
from mcsl_core.simulation import Scenario
from mcsl_core.simulation.rig import Rig
from mcsl_core.simulation.schedule import lamp_path
from mcsl_core.timing import FrameRange

SIZE = (640, 360)
DATA = Path(__file__).parents[4] / "shared" / "data"


@frozen(eq=False)
class Pictures:
    """Samples of cameras whose pictures lie in memory."""

    of: Mapping[str, list[NDArray[np.uint8]]]

    def picture(self, position: int, camera: str) -> NDArray[np.uint8] | None:
        return self.of[camera][position]


def pose(homographies: Mapping[str, NDArray], sizes: Mapping[str, tuple[int, int]] | None = None) -> AlignedPose:
    field = np.zeros((270, 480), bool)
    field[80:190, 140:340] = True
    return AlignedPose((480, 270), "cam1", homographies, sizes or dict.fromkeys(homographies, SIZE), field)


def tissue(seed: int) -> NDArray[np.float32]:
    """Detail of every size, as pictures have it."""
    rng = np.random.default_rng(seed)
    octaves = [
        cv2.resize(rng.normal(0, 1, (360 >> k, 640 >> k)), SIZE, interpolation=cv2.INTER_CUBIC) for k in range(6)
    ]
    return np.float32(110) + 5 * sum(2 ** (0.8 * k) * o for k, o in enumerate(octaves)).astype(np.float32)


def filmed(scene: NDArray, blur: float, noise: float, gain: float, count: int = 12) -> list[NDArray[np.uint8]]:
    rng = np.random.default_rng(7)
    seen = cv2.GaussianBlur(scene, (0, 0), 0.6 + blur) * gain
    return [np.clip(seen + rng.normal(0, noise, seen.shape), 0, 255).astype(np.uint8)[..., None].repeat(3, 2)
            for _ in range(count)]  # fmt: skip


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_camera_out_of_focus_is_told_from_a_dark_or_a_noisy_one(seed: int) -> None:
    scene = tissue(seed)
    kinds = {"cam1": (0, 2, 1), "dark": (0, 2, 0.6), "noisy": (0, 6, 1), "soft": (0.8, 2, 1), "lost": (2, 2, 1),
             "lost and noisy": (2, 6, 1)}  # fmt: skip
    samples = Pictures({name: filmed(scene, *kind) for name, kind in kinds.items()})
    found = sharpness(pose(dict.fromkeys(kinds, np.eye(3))), samples, range(12))  # pyright: ignore[reportArgumentType]
    assert min(found["cam1"], found["dark"], found["noisy"]) > 0.95
    assert found["soft"] < 0.75
    assert found["lost"] < found["soft"] - 0.1
    assert found["lost and noisy"] < found["soft"]


def test_of_a_plain_field_and_of_one_picture_nothing_is_said() -> None:
    plain = Pictures({"cam1": filmed(np.full((360, 640), 120, np.float32), 0, 3, 1)})
    single = Pictures({"cam1": filmed(tissue(1), 0, 3, 1, 1)})
    aligned = pose({"cam1": np.eye(3)})
    assert sharpness(aligned, plain, range(12)) == {}  # pyright: ignore[reportArgumentType]
    assert sharpness(aligned, single, range(1)) == {}  # pyright: ignore[reportArgumentType]


def test_the_real_camera_that_is_out_of_focus_is_found() -> None:
    """Where the truth says how the cameras lie."""
    folder, truth = DATA / "suturing", DATA / "suturing_truth" / "truth.json"
    if not truth.exists():
        pytest.skip("needs the recording of a suturing exercise in ../shared/data")
    av = pytest.importorskip("av")
    points = [np.array(p) for p in json.loads(truth.read_text())["poses"][0]["points"]]
    names = [f"cam{n + 1}" for n in range(len(points))]
    full = (960, 540)
    of = {}
    for name in names:
        with av.open(str(folder / f"{name}.mp4")) as film:
            frames = [f.to_ndarray(format="bgr24") for n, f in enumerate(film.decode(video=0)) if n % 20 == 0]
        of[name] = [cv2.resize(f, SIZE, interpolation=cv2.INTER_AREA) for f in frames]
    homographies = {n: cv2.findHomography(p, points[0])[0] for n, p in zip(names, points, strict=True)}
    field = np.zeros((270, 480), np.uint8)
    hull = cv2.convexHull((points[0] * 480 / full[0]).astype(np.float32).reshape(-1, 1, 2))
    cv2.fillConvexPoly(field, hull.astype(np.int32), 1)
    aligned = AlignedPose((480, 270), "cam1", homographies, dict.fromkeys(names, full), field > 0)
    found = sharpness(aligned, Pictures(of), range(len(of["cam1"])))  # pyright: ignore[reportArgumentType]
    assert found["cam4"] < 0.75
    assert min(value for name, value in found.items() if name != "cam4") > 0.9


def test_fineness_is_pixels_across_the_field() -> None:
    half = np.diag([2.0, 2.0, 1.0])  # this camera has half as many pixels across what the reference camera shows
    squeezed = np.diag([1.0, 4.0, 1.0])  # seen at a slant: a quarter as high
    larger = np.diag([1 / 3, 1 / 3, 1.0])
    found = resolution(pose({"cam1": np.eye(3), "half": half, "slant": squeezed}))
    assert found == pytest.approx({"cam1": 1, "half": 0.5, "slant": 0.5})
    sizes = {"cam1": SIZE, "larger": (1920, 1080)}
    assert resolution(pose({"cam1": np.eye(3), "larger": larger}, sizes)) == pytest.approx({"cam1": 1 / 3, "larger": 1})


def test_a_camera_that_looks_more_steeply_has_fewer_pixels_and_less_closeness() -> None:
    scenario = Scenario(seed=5, movements=0)
    rig, lamp = Rig.of(scenario), lamp_path(scenario).poses[0]
    plane = np.array([[x, y, 0.0] for x in (-60, 60) for y in (-60, 60)])
    seen = [rig.pinhole(camera, lamp).project(plane) for camera in range(scenario.cameras)]
    homographies = {f"cam{n + 1}": cv2.findHomography(px, seen[0])[0] for n, px in enumerate(seen)}
    aligned = pose(homographies, dict.fromkeys(homographies, scenario.size))
    near = viewpoint(aligned)
    assert near["cam1"] == 1
    assert min(near["cam2"], near["cam5"]) > max(near["cam3"], near["cam4"])  # neighbours on the pentagon
    assert all(0.85 < value <= 1 for value in resolution(aligned).values())


def test_merits_are_those_of_the_pose_a_sample_lies_in() -> None:
    table = ScoreTable(np.array([0, 10, 20]), ("a", "b"), np.full((3, 2), 0.5), np.ones((3, 2), bool))
    found = with_merits(table, [FrameRange(0, 20), FrameRange(20, 30)], {"sharpness": np.array([[1, 0.5], [0.2, 1]])})
    assert found.merits["sharpness"].tolist() == [[1, 0.5], [1, 0.5], [0.2, 1]]
    again = ScoreTable.from_arrays(found.arrays())
    assert again.merits["sharpness"].tolist() == found.merits["sharpness"].tolist()
    with pytest.raises(ValueError, match="the merit sharpness"):
        with_merits(table, [FrameRange(0, 30)], {"sharpness": np.array([[1.0, 1.5]])})


def test_a_defocused_camera_that_sees_as_much_is_not_chosen_and_why_says_so() -> None:
    seen = np.tile([0.90, 0.95], (30, 1))
    merits = {"sharpness": np.tile([1.0, 0.4], (30, 1)), "viewpoint": np.tile([1.0, 0.9], (30, 1))}
    table = ScoreTable(np.arange(30) * 25, ("sharp", "blurred"), seen, np.ones((30, 2), bool), merits)

    def chosen(selector: ShortestPath | LeastOccluded | Fixed) -> list[str]:
        return [shot.camera for shot in selector.select(table, frames=750, rate=Fraction(25))]

    (shot,) = ShortestPath().select(table, frames=750, rate=Fraction(25))
    assert shot.camera == "sharp"
    assert shot.why == "sees 90% of the field, next best blurred 95% (sharpness -18%)"
    assert chosen(ShortestPath(worth=ViewingWorth(sharpness=0, viewpoint=0))) == ["blurred"]
    assert chosen(LeastOccluded()) == ["blurred"], "the paper knows no merits"
    seen[:, 0] = 0.3
    assert chosen(ShortestPath()) == ["blurred"], "a blurred field is better than a covered one"


def test_a_covered_second_is_worth_a_switch_that_a_tenth_for_ten_seconds_is_not() -> None:
    covered, tenth = np.tile([0.95, 0.6], (40, 1)), np.tile([0.95, 0.6], (40, 1))
    covered[18:20] = 0.0, 0.9  # two seconds, in which the other camera shows 1.8 seconds of field more
    tenth[10:28] = 0.8, 0.9  # eighteen seconds, in which it shows as much more
    frames = np.arange(40) * 25

    def cameras(seen: NDArray, selector: ShortestPath) -> list[str]:
        table = ScoreTable(frames, ("a", "b"), seen, np.ones(seen.shape, bool))
        return [shot.camera for shot in selector.select(table, frames=1000, rate=Fraction(25))]

    costly = ShortestPath(switch_cost_s=1.5)
    assert cameras(covered, costly) == ["a", "b", "a"]
    assert cameras(tenth, costly) == ["a"]
    assert cameras(covered, ShortestPath(switch_cost_s=1.5, worth=ViewingWorth(covered=0))) == ["a"]
