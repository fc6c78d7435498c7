"""Closer looks: coded video whose views go dark between two samples, and where it is looked again."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import attrs
import numpy as np
import pytest
from brightness import Brightness
from hypothesis import given
from hypothesis import strategies as st

from mcsl_core.alignment.aligned_views import AlignedPose
from mcsl_core.edl import Camera, Media, Movement, Shot
from mcsl_core.hooks.registry import discover
from mcsl_core.imaging.planes import bgr_to_planes
from mcsl_core.media.writing import VideoWriter
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.occlusion.scoring import ScoringSegment, SegmentSamples
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import Footage
from mcsl_core.selection.close_looks import (
    Doubt,
    doubts,
    look_around_movements,
    look_closer,
    unseen_edges,
    without_doubts,
)
from mcsl_core.selection.selectors import Fixed, ShortestPath
from mcsl_core.timing import FrameRange

RATE, FRAMES, SIZE = 10, 120, (64, 48)
CAMERAS = ("cam1", "cam2")
DARK = FrameRange(63, 87)  # of cam1; cam2 shows half the field throughout


def bright(camera: str, frame: int) -> int:
    return 120 if camera == "cam2" else 30 if frame in DARK else 230


def filmed(folder: Path, rate: int) -> Footage:
    cameras = []
    for name in CAMERAS:
        with VideoWriter(folder / f"{name}.mp4", size=SIZE, rate=Fraction(rate)) as writer:
            for n in range(FRAMES):
                writer.write(bgr_to_planes(np.full((SIZE[1], SIZE[0], 3), bright(name, n), np.uint8)))
        cameras.append(Camera(name, (Media(f"{name}.mp4", FRAMES, ""),), SIZE, Fraction(rate)))
    return Footage(cameras, rate=Fraction(rate), frames=FRAMES, base=folder)


@pytest.fixture(scope="module")
def footage(tmp_path_factory: pytest.TempPathFactory) -> Footage:
    return filmed(tmp_path_factory.mktemp("looks"), RATE)


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


def programme(table: ScoreTable) -> tuple[Shot, ...]:
    return ShortestPath().select(table, frames=FRAMES, rate=Fraction(RATE))


def looked(table: ScoreTable, footage: Footage, of: ScoringSegment | None = None, moving=(), choose=programme):
    where = footage, [of or segment()], moving
    return look_closer(look_around_movements(table, *where, Silent()), *where, choose, Silent())


def between(table: ScoreTable) -> list[int]:
    return sorted(set(table.frames.tolist()) - set(range(0, FRAMES, 10)))


def test_it_is_looked_closer_where_the_camera_on_air_is_covered_and_nowhere_else(footage: Footage) -> None:
    found = looked(sampled(), footage)
    assert between(found) == [62, 64, 66, 68, 82, 84, 86, 88, 119]  # and at the end, where no sample lies
    for frame, seen in zip(found.frames, found.visible, strict=True):
        assert seen == pytest.approx([bright(camera, int(frame)) / 255 for camera in CAMERAS], abs=0.02)
    assert found.usable.all()
    shots = programme(found)
    assert [s.camera for s in shots] == ["cam1", "cam2", "cam1"]
    assert [abs(s.range.start - edge) <= 1 for s, edge in zip(shots[1:], (DARK.start, DARK.stop), strict=True)]


def test_a_look_says_which_pictures_it_saw(tmp_path: Path) -> None:
    """Of thirty a second every other is left undecoded; those that no other picture needs."""
    found = looked(sampled(), filmed(tmp_path, 30), segment())
    looks = [i for i, n in enumerate(found.frames) if int(n) in between(found)]
    early = found.frames[looks, None] - found.shown[looks]
    assert early.min() >= 0
    assert 1 <= early.max() <= 3
    for shown, seen in zip(found.shown[looks], found.visible[looks], strict=True):
        assert seen == pytest.approx(
            [bright(camera, int(n)) / 255 for camera, n in zip(CAMERAS, shown, strict=True)], abs=0.02
        )


def test_a_camera_that_samples_show_free_is_looked_at_where_another_changes(footage: Footage) -> None:
    table = sampled(30)  # cam1 is dark from 63 to 86, and they do not say so
    assert {shot.camera for shot in programme(table)} == {"cam1"}
    assert between(looked(table, footage)) == [119]  # nobody comes or goes
    table.visible[table.frames > 60, 1] = 0.1  # somebody goes before cam2
    assert between(looked(table, footage)) == [*(n for n in range(62, 90, 2) if n % 10), 119]


def test_of_a_camera_on_air_that_stays_free_no_row_is_kept(footage: Footage) -> None:
    table = sampled()
    table.visible[:, 0] = np.where(table.visible[:, 0] > 0.5, 0.6, 0.1)  # somebody goes before cam1, which is no better
    table.frames[-1] = FRAMES - 1

    def mostly_second(told: ScoreTable) -> list[Shot]:
        return [Shot(FrameRange(0, FRAMES), "cam2" if np.nanmax(told.visible[:, 1]) > 0 else "cam1")]

    assert looked(table, footage, choose=mostly_second) is table


def test_of_a_choice_that_minds_no_scores_nothing_is_looked_at(footage: Footage) -> None:
    """But at the edges, which belong to the scores themselves."""
    fixed = Fixed(camera="cam1")
    found = looked(sampled(), footage, choose=lambda t: fixed.select(t, frames=FRAMES, rate=Fraction(RATE)))
    assert between(found) == [119]


def test_it_is_looked_again_where_the_programme_chosen_anew_is_in_doubt() -> None:
    """Three cameras that see as much by their samples; two of them are covered between these, one after another."""
    frames, cameras = np.arange(0, 120, 10), ("a", "b", "c", "d")
    visible = np.full((12, 4), 0.9)
    visible[:, 1:3] = 0.85, 0.8
    visible[6:, 3] = 0.1  # who goes before d between frames 50 and 60 may have gone before others
    truth = {"a": range(52, 58), "b": range(51, 59)}
    asked: list[tuple[str, ...]] = []

    def look(names, stretches):
        at = [n for stretch in stretches for n in range(stretch.start, stretch.stop, 2)]
        asked.extend([tuple(names)] * bool(at))
        every = dict(zip(cameras, (0.9, 0.85, 0.8, 0.1), strict=True))
        shown = {n: np.array([0.0 if n in truth.get(name, ()) else every[name] for name in names]) for n in at}
        return {n: (seen, np.ones(len(names), bool), np.full(len(names), n)) for n, seen in shown.items()}

    table = ScoreTable(frames, cameras, visible, np.ones(visible.shape, bool))
    assert {s.camera for s in programme(table)} == {"a"}
    found = without_doubts(table, programme, look, 2, 0.2)
    assert asked == [("a",), cameras, ("c",)]  # what a alone shows calls for all, and so c is chosen, and looked at
    assert [s.camera for s in programme(found) if 55 in s.range] == ["c"]


def test_what_a_keyframe_stood_for_is_replaced_by_the_frame_itself(footage: Footage) -> None:
    table = sampled()
    table.visible[6, 0] = 0.1  # of a keyframe half a second later
    assert looked(table, footage).visible[[6, 10]][0, 0] == pytest.approx(0.9, abs=0.02)


def test_nothing_is_looked_at_in_a_movement_or_outside_of_every_segment(footage: Footage) -> None:
    moving = [Movement(FrameRange(61, 66), 1.0)]
    assert between(looked(sampled(), footage, segment(0, 85), moving)) == [66, 67, 82, 84]


def test_right_before_and_after_a_movement_is_looked_though_no_sample_lies_there(footage: Footage) -> None:
    table, moving = sampled(20), [Movement(FrameRange(70, 85), 1.0)]  # cam1 is dark from 63 to 86
    table.visible[4] = np.nan  # of frame 80
    found = looked(table, footage, moving=moving)
    near = {int(n): found.visible[i].round(1).tolist() for i, n in enumerate(found.frames) if 60 <= n < 90}
    assert {68: [0.1, 0.5], 86: [0.1, 0.5]}.items() <= near.items()
    assert {62, 64, 66} <= near.keys()  # where cam2 became the better one before the lamp moved
    shots = ShortestPath().select(found, frames=FRAMES, rate=Fraction(RATE))
    assert [s.camera for s in shots] == ["cam1", "cam2", "cam1"]
    assert shots[1].range.start in range(62, 66)


@pytest.mark.parametrize(
    ("movements", "expected"),
    [
        ([], [119]),
        ([(61, 66)], [67, 119]),  # 59 lies by the sample of 60, 67 by none
        ([(63, 68)], [119]),  # both lie by samples
        ([(1, 5), (112, 119)], [6, 119]),  # -1 and 120 are outside; 110 is a sample
        ([(43, 44), (45, 53)], [54, 119]),  # what lies in another movement is no place to look
    ],
)
def test_edges_of_movements_where_nothing_is_known(movements, expected) -> None:
    found = unseen_edges(sampled(), [Movement(FrameRange(*m), 1.0) for m in movements], FRAMES, 2)
    assert found == expected


def test_where_nobody_comes_or_goes_nothing_is_looked_at(footage: Footage) -> None:
    table = sampled()
    table.visible[:, 0] = 0.9
    table.visible[5:7, 1] = np.nan
    table.frames[-1] = FRAMES - 1
    assert looked(table, footage) is table


def doubtful(table: ScoreTable, change: float = 0.2) -> list[Doubt]:
    return doubts(table, [Shot(FrameRange(0, 75), "cam1"), Shot(FrameRange(75, FRAMES), "cam2")], 2, change)


def test_a_programme_is_in_doubt_between_samples_in_which_somebody_came() -> None:
    assert doubtful(sampled(2)) == []
    before, after = Doubt(FrameRange(60, 71), ("cam1",), True), Doubt(FrameRange(80, 91), ("cam2",), True)
    assert doubtful(sampled(10)) == [before, Doubt(FrameRange(70, 81), ("cam1", "cam2"), True), after]
    assert doubtful(sampled(10), 0.9) == []
    table = sampled(10)
    table.visible[:, 1] = np.where(table.frames == 70, 0.3, 0.9)  # covered while cam1 is on air
    table.visible[:, 0] = 0.9
    beside = [Doubt(FrameRange(60, 71), ("cam1",), False), Doubt(FrameRange(70, 81), ("cam1", "cam2"), True)]
    assert doubtful(table) == beside


def test_a_programme_is_in_doubt_where_somebody_came_just_before_and_just_after() -> None:
    table = sampled(10)
    table.visible[:, 1] = np.where((table.frames < 40) | (table.frames > 50), 0.9, 0.1)
    table.visible[:, 0] = 0.9
    assert [d.stretch.start for d in doubtful(table)] == [30, 40, 50]
    table.visible[6, 1] = 0.1  # one longer: who stays is no crowd
    assert [d.stretch.start for d in doubtful(table)] == [30, 60]


def test_a_camera_that_may_not_be_used_is_no_reason_to_look() -> None:
    table = sampled()
    table.usable[:, 0] = False
    assert doubtful(table) == []


@given(st.integers(0, 2**32), st.integers(1, 12), st.floats(0, 1))
def test_doubts_rise_from_sample_to_sample_and_looking_ends(seed: int, step: int, change: float) -> None:
    rng = np.random.default_rng(seed)
    frames = np.cumsum(rng.integers(1, 30, 12))
    visible = rng.random((12, 2))
    visible[rng.random(visible.shape) < 0.2] = np.nan
    table = ScoreTable(frames, CAMERAS, visible, rng.random(visible.shape) < 0.8)
    shots = [Shot(FrameRange(0, 50), "cam1"), Shot(FrameRange(50, int(frames[-1]) + 9), "cam2")]
    found = doubts(table, shots, step, change)
    assert [d.stretch for d in found] == sorted(d.stretch for d in found)
    pairs = set(zip(frames.tolist(), frames[1:].tolist(), strict=False))
    assert {(d.stretch.start, d.stretch.stop - 1) for d in found} <= pairs

    def look(names, stretches):
        at = [n for stretch in stretches for n in range(stretch.start, stretch.stop, step)]
        return {n: (rng.random(len(names)), np.ones(len(names), bool), np.full(len(names), n)) for n in at}

    last = int(frames[-1]) + 9
    closer = without_doubts(
        table, lambda t: ShortestPath().select(t, frames=last, rate=Fraction(10)), look, step, change
    )
    assert set(frames.tolist()) <= set(closer.frames.tolist())
