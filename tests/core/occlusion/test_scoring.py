"""The scores of a recording stand at the frames that its pictures really belong to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from fractions import Fraction
from pathlib import Path

import attrs
import numpy as np
import pytest
from coded_video import SIZE, read_number, write_coded

from mcsl_core.alignment.aligned_views import AlignedPose, AlignedView
from mcsl_core.alignment.observations import SolvedPose
from mcsl_core.edl import Camera, Clock, Media, Movement, Pose
from mcsl_core.hooks.registry import discover
from mcsl_core.imaging.geometry import to_edl_matrix
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.occlusion.scoring import score_views, scoring_segments
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.timing import FrameRange

RATE, FRAMES = 10, 80
OFFSETS = {"cam1": 0.0, "cam2": 0.4, "cam3": -0.3}


class Numbers:
    """A detector by which so many thousandths of the field are visible as the picture's number says."""

    name = "numbers"

    def scorer(self, aligned: AlignedPose, samples: Sequence[Sequence[AlignedView]]) -> Numbers:
        return self

    def score(self, views: Sequence[AlignedView]) -> Mapping[str, float]:
        return {view.camera: read_number(view.picture) / 1000 for view in views}


def scored(folder: Path, movements: Sequence[Movement] = ()) -> ScoreTable:
    """Of cameras whose picture of programme frame n is number n + 100, a keyframe a second of their own clocks."""
    cameras = []
    for name, offset in OFFSETS.items():
        first = round(offset * RATE)
        path = write_coded(folder / f"{name}.mp4", range(100 + first, 100 + FRAMES), gop=RATE, rate=RATE)
        cameras.append(Camera(name, (Media(path.name, FRAMES - first),), SIZE, Fraction(RATE), Clock(offset)))
    footage = Footage(cameras, rate=Fraction(RATE), frames=FRAMES, base=folder, threads=1)
    same = dict.fromkeys(OFFSETS, np.eye(3))
    aligned = AlignedPose(SIZE, "cam1", same, dict.fromkeys(OFFSETS, SIZE), np.ones(SIZE[::-1], bool))
    pose = Pose(range=FrameRange(0, FRAMES), homographies={name: to_edl_matrix(h) for name, h in same.items()})
    solved = [SolvedPose(pose, aligned, (), {})]
    detector = attrs.evolve(discover().choose("occlusion"), implementation=Numbers()).checked
    with closing(SampleStore.record(footage, folder / "samples", Silent())) as samples:
        segments = scoring_segments(samples, solved, movements, detector)
        return score_views(samples, solved, segments, movements, Silent())


def test_scores_stand_at_the_frames_that_pictures_are_of(tmp_path: Path) -> None:
    table = scored(tmp_path)
    np.testing.assert_allclose(table.visible[1:], (table.shown[1:] + 100) / 1000)
    assert table.visible[0] == pytest.approx([0.1, np.nan, 0.097], nan_ok=True)  # cam2 begins later, cam3 before
    assert [set((table.shown - table.frames[:, None])[1:-1, c]) for c in range(3)] == [{0}, {4}, {-3}]
    inside = (table.frames >= 20) & (table.frames < 70)
    np.testing.assert_allclose(table.seen[inside], np.repeat((table.frames[inside, None] + 100) / 1000, 3, axis=1))


def test_a_picture_of_the_moving_lamp_has_no_score_though_its_sample_stands_still(tmp_path: Path) -> None:
    table = scored(tmp_path, [Movement(FrameRange(33, 40), 1.0)])
    at = int(np.flatnonzero(table.frames == 30)[0])
    assert np.isnan(table.visible[at]).tolist() == [False, True, False]  # of 30, 34 and 27
    assert np.isnan(table.visible[at + 1]).tolist() == [False, False, True]  # of 40, 44 and 37
    assert table.usable[1:].all()
    assert np.isnan(table.visible[1:]).sum() == 2
