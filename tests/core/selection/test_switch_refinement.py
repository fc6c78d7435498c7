"""Switches at the very frame: coded video whose views go dark at a known frame, and what refinement must keep."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import pairwise

import attrs
import numpy as np
import pytest

from mcsl_core.alignment.aligned_views import AlignedPose, AlignedView
from mcsl_core.edl import Camera, Media, Movement, Shot
from mcsl_core.hooks.registry import discover
from mcsl_core.imaging.planes import bgr_to_planes
from mcsl_core.media.writing import VideoWriter
from mcsl_core.occlusion.scoring import ScoringSegment, SegmentSamples
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import Footage
from mcsl_core.selection.switch_refinement import refine_switches, with_switches_at
from mcsl_core.timing import FrameRange, check_tiles

RATE, FRAMES, SIZE = 10, 120, (64, 48)
GOES_DARK = 57  # cam1 shows the field before this frame, cam2 from it on


@attrs.frozen
class Brightness:
    """A detector for this test: the field is visible as far as the picture is bright."""

    name = "brightness"

    def scorer(self, scene: AlignedPose, moments: Sequence[Sequence[AlignedView]]) -> Brightness:
        return self

    def score(self, views: Sequence[AlignedView]) -> Mapping[str, float]:
        return {v.camera: min(1.0, float(v.aligned.mean()) / 255) for v in views}


@pytest.fixture(scope="module")
def footage(tmp_path_factory: pytest.TempPathFactory) -> Footage:
    folder = tmp_path_factory.mktemp("cuts")
    cameras = []
    for name in ("cam1", "cam2"):
        with VideoWriter(folder / f"{name}.mp4", size=SIZE, rate=Fraction(RATE)) as writer:
            for n in range(FRAMES):
                bright = (n < GOES_DARK) == (name == "cam1")
                writer.write(bgr_to_planes(np.full((SIZE[1], SIZE[0], 3), 220 if bright else 30, np.uint8)))
        cameras.append(Camera(name, (Media(f"{name}.mp4", FRAMES, ""),), SIZE, Fraction(RATE)))
    return Footage(cameras, rate=Fraction(RATE), frames=FRAMES, base=folder)


def stretch() -> ScoringSegment:
    offer = attrs.evolve(discover().choose("occlusion"), implementation=Brightness())
    scene = AlignedPose(SIZE, "cam1", dict.fromkeys(("cam1", "cam2"), np.eye(3)), dict.fromkeys(("cam1", "cam2"), SIZE),
                  np.ones((SIZE[1], SIZE[0]), bool))  # fmt: skip
    return ScoringSegment(FrameRange(0, FRAMES), SegmentSamples(None, scene, np.zeros(0, np.int64)), offer.checked)  # pyright: ignore


def shots(*cuts: int) -> tuple[Shot, ...]:
    ends = [0, *cuts, FRAMES]
    return tuple(Shot(FrameRange(a, b), f"cam{1 + n % 2}", 0.5, "") for n, (a, b) in enumerate(pairwise(ends)))


def refined(footage: Footage, *cuts: int, movements: Sequence[Movement] = ()) -> tuple[int, ...]:
    before = shots(*cuts)
    found = refine_switches(before, footage, [stretch()], movements, Silent())
    after = with_switches_at(before, found)
    check_tiles((s.range for s in after), FRAMES, "shots")
    assert [s.camera for s in after] == [s.camera for s in before]
    for old, new in zip(before, after, strict=True):
        assert len(new.range) >= min(len(old.range), 2 * RATE)
    return found


@pytest.mark.parametrize("cut", [50, 56, 57, 60, 65])
def test_a_switch_goes_to_where_the_field_changes_sides(footage: Footage, cut: int) -> None:
    # Looked at every 2 frames, the change is found to within one.
    assert abs(refined(footage, cut)[0] - GOES_DARK) <= 1


def test_a_switch_moves_by_a_second_at_most(footage: Footage) -> None:
    assert refined(footage, 35) == (45,)
    assert refined(footage, 80) == (70,)


def test_no_shot_becomes_shorter_than_two_seconds_or_than_it_was(footage: Footage) -> None:
    # cam1, cam2, cam1: in the middle shot the switch towards 57 would leave 13 frames of it.
    assert refined(footage, 50, 70)[0] == 50
    assert refined(footage, 50, 62)[0] == 50, "a shot that a selector made short is not made shorter"


def test_a_switch_near_a_movement_stays_and_one_in_it_goes_to_its_middle(footage: Footage) -> None:
    moved = Movement(FrameRange(58, 64), 1.0)
    assert refined(footage, 50, movements=[moved]) == (50,)
    assert refined(footage, 58, movements=[moved]) == (61,)
    assert refined(footage, 30, 58, movements=[Movement(FrameRange(20, 60), 1.0)])[1] == 58, "the shot before is short"
