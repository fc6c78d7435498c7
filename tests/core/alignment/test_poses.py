"""Poses in which the reference camera has no picture: it stopped, and the lamp moved after that."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from notes import Notes
from remuxed import remux

from mcsl_core.alignment.aligned_views import AlignedPose
from mcsl_core.alignment.observations import NOTHING, Observations, SolvedPose
from mcsl_core.alignment.poses import with_needed_points
from mcsl_core.analysis.pipeline import analyse
from mcsl_core.analysis.settings import AnalysisSettings
from mcsl_core.delivery.direct import write_direct
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.edl import Pose
from mcsl_core.hooks.registry import discover
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import footage_of
from mcsl_core.simulation import Scenario, alignment_error, best_plane, best_plane_error, simulate
from mcsl_core.timing import FrameRange

SCENARIO = Scenario(seed=3, duration_s=36, size=(480, 270), rate=Fraction(10), cameras=4, movements=((26.5, 2.0),))


def _pose(number: int, perspective: int) -> SolvedPose:
    size, field = (16, 9), np.zeros((9, 16), bool)
    pose = Pose(range=FrameRange(10 * number, 10 * number + 10), homographies={}, perspective=perspective)
    aligned = AlignedPose(size, "cam1", {"cam1": np.eye(3)}, {"cam1": size}, field)
    return SolvedPose(pose, aligned, (number,), {"cam1": Observations((NOTHING,), field)})


def test_points_are_kept_of_the_last_pose_and_of_the_one_that_began_its_perspective_alone() -> None:
    solved: list[SolvedPose] = []
    kept = []
    for number, perspective in enumerate((0, 0, 0, 1, 1, 1, 2)):
        solved = with_needed_points([*solved, _pose(number, perspective)])
        kept.append([n for n, pose in enumerate(solved) if pose.observations])
    assert kept == [[0], [0, 1], [0, 2], [3], [3, 4], [3, 5], [6]]


@pytest.mark.slow
def test_the_programme_goes_on_when_the_reference_camera_stops(tmp_path: Path) -> None:
    truth = simulate(SCENARIO, tmp_path / "whole", Silent())
    folder = tmp_path / "recording"
    folder.mkdir()
    for path in sorted((tmp_path / "whole").glob("cam*.mp4")):
        remux(path, folder / path.name, stop_s=Fraction(12) if path.stem == "cam1" else None)
    progress = Notes()
    settings = AnalysisSettings(sync="none")
    made = analyse([folder], tmp_path / "edl.json", settings=settings, plugins=discover(), progress=progress)
    assert made.frames >= 359
    assert any("cam1, the reference camera, ends at 0:00:12" in note for note in progress.notes)
    assert any("cam1, the reference camera, has no picture; the others lie by" in note for note in progress.notes)
    footage = footage_of(made, tmp_path)
    for shot in made.shots:
        frames = range(shot.range.start, min(shot.range.stop, 358), 10)
        assert all(picture is not None for _, picture in footage.pictures(shot.camera, frames, height=90))
    assert [pose.perspective for pose in made.poses] == [0, 0]
    assert not any(pose.weak for pose in made.poses)
    _tied_to_each_other(truth, made)
    source = ProgrammeSource(made, tmp_path)
    write_direct(source, tmp_path / "end.mp4", piece=FrameRange(330, 340))


def _tied_to_each_other(truth, made) -> None:
    """Of the last pose against the truth, once the stand-in is laid where it truly lies: it is a few pixels off.

    How it lay before the movement it lies only nearly after it; the anchor takes that up.
    """
    homographies = {name: np.array(h) for name, h in made.poses[-1].homographies.items()}
    assert set(homographies) == set(truth.cameras)
    right = best_plane(truth, 1, "cam2") @ np.linalg.inv(homographies["cam2"])
    for camera in ("cam3", "cam4"):
        error = alignment_error(truth, 1, camera, right @ homographies[camera])
        assert error < 3 * best_plane_error(truth, 1, camera), camera
