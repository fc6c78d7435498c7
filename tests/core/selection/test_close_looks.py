"""Closer looks: coded video whose views go dark between two samples, and where it is looked again."""

from __future__ import annotations

from fractions import Fraction

import attrs
import numpy as np
import pytest
from brightness import Brightness
from hypothesis import given
from hypothesis import strategies as st

from mcsl_core.alignment.aligned_views import AlignedPose
from mcsl_core.edl import Camera, Media, Movement
from mcsl_core.hooks.registry import discover
from mcsl_core.imaging.planes import bgr_to_planes
from mcsl_core.media.writing import VideoWriter
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.occlusion.scoring import ScoringSegment, SegmentSamples
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import Footage
from mcsl_core.selection.close_looks import fast_changes, look_closer, unseen_edges
from mcsl_core.selection.selectors import ShortestPath
from mcsl_core.timing import FrameRange

RATE, FRAMES, SIZE = 10, 120, (64, 48)
CAMERAS = ("cam1", "cam2")
DARK = FrameRange(63, 87)  # of cam1; cam2 shows half the field throughout


def bright(camera: str, frame: int) -> int:
    return 120 if camera == "cam2" else 30 if frame in DARK else 230


@pytest.fixture(scope="module")
def footage(tmp_path_factory: pytest.TempPathFactory) -> Footage:
    folder = tmp_path_factory.mktemp("looks")
    cameras = []
    for name in CAMERAS:
        with VideoWriter(folder / f"{name}.mp4", size=SIZE, rate=Fraction(RATE)) as writer:
            for n in range(FRAMES):
                writer.write(bgr_to_planes(np.full((SIZE[1], SIZE[0], 3), bright(name, n), np.uint8)))
        cameras.append(Camera(name, (Media(f"{name}.mp4", FRAMES, ""),), SIZE, Fraction(RATE)))
    return Footage(cameras, rate=Fraction(RATE), frames=FRAMES, base=folder)


def segment(start: int = 0, stop: int = FRAMES) -> ScoringSegment:
    offer = attrs.evolve(discover().choose("occlusion"), implementation=Brightness())
    field = np.ones((SIZE[1], SIZE[0]), bool)
    aligned = AlignedPose(SIZE, "cam1", dict.fromkeys(CAMERAS, np.eye(3)), dict.fromkeys(CAMERAS, SIZE), field)
    samples = SegmentSamples(None, aligned, np.zeros(0, np.int64))  # pyright: ignore[reportArgumentType]
    return ScoringSegment(FrameRange(start, stop), samples, offer.checked)


def sampled(every: int = 10) -> ScoreTable:
    frames = np.arange(0, FRAMES, every)
    visible = np.array([[bright(camera, n) / 255 for camera in CAMERAS] for n in frames])
    return ScoreTable(frames, CAMERAS, visible, np.ones(visible.shape, bool))


def test_it_is_looked_closer_where_the_best_camera_changes_and_nowhere_else(footage: Footage) -> None:
    found = look_closer(sampled(), footage, [segment()], [], Silent())
    between = sorted(set(found.frames) - set(range(0, FRAMES, 10)))
    assert between == [62, 64, 66, 68, 82, 84, 86, 88]
    for frame, seen in zip(found.frames, found.visible, strict=True):
        assert seen == pytest.approx([bright(camera, int(frame)) / 255 for camera in CAMERAS], abs=0.02)
    assert found.usable.all()
    shots = ShortestPath().select(found, frames=FRAMES, rate=Fraction(RATE))
    assert [s.camera for s in shots] == ["cam1", "cam2", "cam1"]
    assert [abs(s.range.start - edge) <= 1 for s, edge in zip(shots[1:], (DARK.start, DARK.stop), strict=True)]


def test_what_a_keyframe_stood_for_is_replaced_by_the_frame_itself(footage: Footage) -> None:
    table = sampled()
    table.visible[6, 0] = 0.1  # of a keyframe half a second later
    assert look_closer(table, footage, [segment()], [], Silent()).visible[[6, 10]][0, 0] == pytest.approx(0.9, abs=0.02)


def test_nothing_is_looked_at_in_a_movement_or_outside_of_every_segment(footage: Footage) -> None:
    moving = [Movement(FrameRange(61, 66), 1.0)]
    found = look_closer(sampled(), footage, [segment(0, 85)], moving, Silent())
    assert sorted(set(found.frames) - set(range(0, FRAMES, 10))) == [66, 67, 82, 84]


def test_right_before_and_after_a_movement_is_looked_though_no_sample_lies_there(footage: Footage) -> None:
    table, moving = sampled(20), [Movement(FrameRange(70, 85), 1.0)]  # cam1 is dark from 63 to 86
    table.visible[4] = np.nan  # of frame 80
    found = look_closer(table, footage, [segment()], moving, Silent())
    near = {int(n): found.visible[i].round(1).tolist() for i, n in enumerate(found.frames) if 60 <= n < 90}
    assert {68: [0.1, 0.5], 86: [0.1, 0.5]}.items() <= near.items()
    assert {62, 64, 66} <= near.keys()  # where cam2 became the better one before the lamp moved
    shots = ShortestPath().select(found, frames=FRAMES, rate=Fraction(RATE))
    assert [s.camera for s in shots] == ["cam1", "cam2", "cam1"]
    assert shots[1].range.start in range(62, 66)


@pytest.mark.parametrize(
    ("movements", "expected"),
    [
        ([], []),
        ([(61, 66)], [67]),  # 59 lies by the sample of 60, 67 by none
        ([(63, 68)], []),  # both lie by samples
        ([(1, 5), (112, 119)], [6]),  # -1 and 120 are outside; 110 is a sample
        ([(43, 44), (45, 53)], [54]),  # what lies in another movement is no place to look
    ],
)
def test_edges_of_movements_where_nothing_is_known(movements, expected) -> None:
    found = unseen_edges(sampled(), [Movement(FrameRange(*m), 1.0) for m in movements], FRAMES, 2)
    assert found == expected


def test_where_nothing_changes_fast_nothing_is_looked_at(footage: Footage) -> None:
    table = sampled()
    table.visible[:, 0] = 0.9
    table.visible[5:7, 1] = np.nan
    assert look_closer(table, footage, [segment()], [], Silent()) is table


def test_samples_that_are_close_already_are_close_enough() -> None:
    assert fast_changes(sampled(2), 2, 0.2) == []
    assert fast_changes(sampled(10), 2, 0.2) == [FrameRange(60, 71), FrameRange(80, 91)]
    assert fast_changes(sampled(10), 2, 0.9) == []


def test_a_camera_that_may_not_be_used_is_no_reason_to_look() -> None:
    table = sampled()
    table.usable[:, 0] = False
    assert fast_changes(table, 2, 0.2) == []


@given(st.integers(0, 2**32), st.integers(1, 12), st.floats(0, 1))
def test_stretches_rise_apart_and_begin_and_end_at_samples(seed: int, step: int, change: float) -> None:
    rng = np.random.default_rng(seed)
    frames = np.cumsum(rng.integers(1, 30, 40))
    visible = rng.random((40, 3))
    visible[rng.random(visible.shape) < 0.2] = np.nan
    table = ScoreTable(frames, ("a", "b", "c"), visible, rng.random(visible.shape) < 0.8)
    last = -1
    for stretch in fast_changes(table, step, change):
        assert stretch.start > last
        assert {stretch.start, stretch.stop - 1} <= set(frames.tolist())
        last = stretch.stop - 1
