"""A camera whose field a head hides through one pose lies as another pose of the recording has it, before or after.

With the reference and another hidden through the first pose the other two were 42 times their best plane's error off.
"""

from contextlib import closing
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
import pytest

from mcsl_core.alignment.observations import SolvedPose
from mcsl_core.alignment.pose_solver import PoseSolver
from mcsl_core.alignment.poses import solve_poses
from mcsl_core.alignment.settings import SolveSettings
from mcsl_core.edl import Camera, Media, Movement
from mcsl_core.hooks.registry import discover
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.simulation import Scenario, Truth, alignment_error, best_plane_error, simulate
from mcsl_core.timing import FrameRange

MOVE = FrameRange(50, 60)
SCENARIO = Scenario(
    seed=5,
    duration_s=22,
    size=(480, 270),
    rate=Fraction(5),
    cameras=4,
    movements=((10.0, 2.0),),
    clock_offset_s=0,
    drift_ppm=0,
    heads=0,
    audio=False,
)
FRAMES = 110


@pytest.fixture(scope="module")
def plain(tmp_path_factory) -> tuple[Path, Truth]:
    """Nobody leans in."""
    folder = tmp_path_factory.mktemp("plain")
    return folder, simulate(SCENARIO, folder, Silent())


def behind_a_head(path: Path, to: Path, hidden: range) -> None:
    """The film, in those frames with a head that hides all but its rims and is never still."""
    film, rng = cv2.VideoCapture(str(path)), np.random.default_rng(8)
    writer = cv2.VideoWriter(str(to), cv2.VideoWriter.fourcc(*"mp4v"), 5, (480, 270))
    shade = cv2.GaussianBlur(rng.normal(0, 120, (270, 480)), (0, 0), 4)[..., None]
    cap = np.clip(np.array([150, 100, 40]) * (1 + shade / 20), 0, 255).astype(np.uint8)
    for n in range(FRAMES):
        found, picture = film.read()
        assert found
        if n in hidden:
            head = np.zeros((270, 480), np.uint8)
            x, y = np.array([240, 135]) + rng.integers(-12, 13, 2)
            cv2.ellipse(head, (int(x), int(y)), (150, 118), 0, 0, 360, 255, -1)
            picture = np.where(head[..., None] > 0, np.roll(cap, (int(y), int(x)), (0, 1)), picture)
        writer.write(picture)
    writer.release()


def solved(folder: Path, plain: Path, hidden: dict[str, range]) -> list[SolvedPose]:
    cameras = []
    for name in SCENARIO.camera_names:
        behind_a_head(plain / f"{name}.mp4", folder / f"{name}.mp4", hidden.get(name, range(0)))
        cameras.append(Camera(name, (Media(f"{name}.mp4", FRAMES),), SCENARIO.size, SCENARIO.rate))
    offers = discover()
    solver = PoseSolver(
        dict.fromkeys(SCENARIO.camera_names, SCENARIO.size),
        "cam1",
        offers.choose("matcher", None).checked,
        offers.choose("aligner", None).checked,
        SolveSettings(),
    )
    footage = Footage(cameras, rate=SCENARIO.rate, frames=FRAMES, base=folder)
    with closing(SampleStore.record(footage, folder / "samples", Silent())) as samples:
        return solve_poses(solver, samples, [Movement(MOVE)], FRAMES, Silent())


def ratios(truth: Truth, pose: SolvedPose, number: int) -> dict[str, float]:
    """Each camera's error over the field, in its best plane's."""
    planes = {name: np.array(h) for name, h in pose.pose.homographies.items() if name != "cam1"}
    return {n: alignment_error(truth, number, n, h) / best_plane_error(truth, number, n) for n, h in planes.items()}


@pytest.mark.slow
@pytest.mark.parametrize(("hidden", "number"), [("cam4", 0), ("cam1 cam3", 0), ("cam1 cam3", 1)])
def test_a_camera_hidden_through_one_pose_is_known_by_the_other(
    plain, tmp_path: Path, hidden: str, number: int
) -> None:
    folder, truth = plain
    frames = (range(55), range(55, FRAMES))[number]
    poses = solved(tmp_path, folder, dict.fromkeys(hidden.split(), frames))
    for k, pose in enumerate(poses):
        assert not pose.pose.weak
        found = ratios(truth, pose, k)
        assert set(found) == {"cam2", "cam3", "cam4"}
        assert max(found.values()) < 1.5, (k, found)
