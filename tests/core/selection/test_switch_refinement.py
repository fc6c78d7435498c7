"""Switches at the very frame: coded video whose views go dark at a known frame, and what refinement must keep."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from math import ceil

import attrs
import numpy as np
import pytest
from brightness import Brightness
from hypothesis import given, settings
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
from mcsl_core.selection.protocol import MIN_SHOT_S, Selector
from mcsl_core.selection.selectors import LeastOccluded, ShortestPath
from mcsl_core.selection.switch_refinement import moved_switches, refine_switches, with_switches_at
from mcsl_core.timing import FrameRange, check_tiles

RATE, FRAMES, SIZE = 10, 120, (64, 48)
GOES_DARK = 57  # cam1 shows the field before this frame, cam2 from it on


@pytest.fixture(scope="module")
def footage(tmp_path_factory: pytest.TempPathFactory) -> Footage:
    folder = tmp_path_factory.mktemp("switches")
    cameras = []
    for name in ("cam1", "cam2"):
        with VideoWriter(folder / f"{name}.mp4", size=SIZE, rate=Fraction(RATE)) as writer:
            for n in range(FRAMES):
                bright = (n < GOES_DARK) == (name == "cam1")
                writer.write(bgr_to_planes(np.full((SIZE[1], SIZE[0], 3), 220 if bright else 30, np.uint8)))
        cameras.append(Camera(name, (Media(f"{name}.mp4", FRAMES, ""),), SIZE, Fraction(RATE)))
    return Footage(cameras, rate=Fraction(RATE), frames=FRAMES, base=folder)


def segment() -> ScoringSegment:
    offer = attrs.evolve(discover().choose("occlusion"), implementation=Brightness())
    names = ("cam1", "cam2")
    field = np.ones((SIZE[1], SIZE[0]), bool)
    aligned = AlignedPose(SIZE, "cam1", dict.fromkeys(names, np.eye(3)), dict.fromkeys(names, SIZE), field)
    samples = SegmentSamples(None, aligned, np.zeros(0, np.int64))  # pyright: ignore[reportArgumentType]
    return ScoringSegment(FrameRange(0, FRAMES), samples, offer.checked)


def shots(*switches: int) -> tuple[Shot, ...]:
    ends = [0, *switches, FRAMES]
    return tuple(Shot(FrameRange(a, b), f"cam{1 + n % 2}", 0.5, "") for n, (a, b) in enumerate(pairwise(ends)))


def refined(
    footage: Footage, *switches: int, movements: Sequence[Movement] = (), min_shot_s: float = 2.0
) -> tuple[int, ...]:
    before = shots(*switches)
    found = refine_switches(before, footage, [segment()], movements, Silent(), min_shot_s=min_shot_s)
    after = with_switches_at(before, found)
    check_tiles((s.range for s in after), FRAMES, "shots")
    assert [s.camera for s in after] == [s.camera for s in before]
    for old, new in zip(before, after, strict=True):
        assert len(new.range) >= min(len(old.range), min_shot_s * RATE)
    return found


@pytest.mark.parametrize("switch", [50, 56, 57, 60, 65])
def test_a_switch_goes_to_where_the_field_changes_sides(footage: Footage, switch: int) -> None:
    # Scored every 2 frames, the change is found to within one.
    assert abs(refined(footage, switch)[0] - GOES_DARK) <= 1


def test_a_switch_moves_by_a_second_at_most(footage: Footage) -> None:
    assert refined(footage, 35) == (45,)
    assert refined(footage, 80) == (70,)


def test_no_shot_becomes_shorter_than_two_seconds_or_than_it_was(footage: Footage) -> None:
    # cam1, cam2, cam1: in the middle shot the switch towards 57 would leave 13 frames of it.
    assert refined(footage, 50, 70)[0] == 50
    assert refined(footage, 50, 62)[0] == 50, "a shot that a selector made short is not made shorter"


def test_the_minimum_is_the_selectors(footage: Footage) -> None:
    assert refined(footage, 60, min_shot_s=5)[0] in (56, 57, 58)
    assert refined(footage, 60, min_shot_s=6) == (60,), "the shot before would last 5.7 s"
    movement = Movement(FrameRange(40, 62), 1.0)
    assert refined(footage, 60, movements=[movement], min_shot_s=5) == (51,)
    assert refined(footage, 60, movements=[movement], min_shot_s=6) == (60,), "not for a movement's middle either"


def test_a_switch_near_a_movement_stays_and_one_in_it_goes_to_its_middle(footage: Footage) -> None:
    moved = Movement(FrameRange(58, 64), 1.0)
    assert refined(footage, 50, movements=[moved]) == (50,)
    assert refined(footage, 58, movements=[moved]) == (61,)
    assert refined(footage, 30, 58, movements=[Movement(FrameRange(20, 60), 1.0)])[1] == 58, "the shot before is short"


# ------------------------------------------------------------------------------------- the minimum, end to end


def selectors() -> st.SearchStrategy[Selector]:
    """The built-in ones with any minimum, and every selector that is installed."""
    installed = [offer.checked for offer in discover().offers if offer.stage == "selector"]
    return st.one_of(
        st.builds(
            ShortestPath,
            min_shot_s=st.sampled_from([0.0, 0.05, 1.0, 2.0, 2.02, 6.0]),
            switch_cost_s=st.sampled_from([0.0, 0.5]),
        ),
        st.just(LeastOccluded()),
        st.sampled_from(installed),
    )


@st.composite
def tables(draw: st.DrawFn) -> tuple[ScoreTable, int]:
    """A table of up to eighty samples about a second apart, in which the best camera changes often."""
    samples, cameras = draw(st.integers(1, 80)), draw(st.integers(1, 4))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    frames = np.cumsum(rng.integers(8, 40, samples)) - 8
    visible = np.repeat(rng.random((samples, cameras)), draw(st.integers(1, 6)), axis=0)[:samples]
    visible[rng.random(samples) < 0.1] = np.nan
    usable = rng.random(visible.shape) < 0.95
    table = ScoreTable(frames, tuple(f"cam{c}" for c in range(cameras)), visible, usable)
    return table, int(frames[-1]) + draw(st.integers(1, 40))


@st.composite
def movements_in(draw: st.DrawFn, frames: int) -> list[Movement]:
    ends = sorted(draw(st.sets(st.integers(0, frames), max_size=8)))
    return [Movement(FrameRange(a, b), 1.0) for a, b in list(pairwise(ends))[::2]]


@pytest.mark.parametrize("frames", [56, 99, 100, 101])  # about two minimum shots, and less
def test_who_promises_a_minimum_keeps_it_and_who_promises_none_is_not_made_worse(frames: int) -> None:
    """The best camera changes 15 frames before the end: at 25 a second a shot of 0.6 s, if it is shown."""
    at = np.array([frames - 29, frames - 1])
    seen = np.array([[0.9, 0.1], [0.1, 0.9]])
    for usable in (np.ones((2, 2), bool), np.array([[True, False], [False, True]])):  # and by the cameras' gaps
        table = ScoreTable(at, ("a", "b"), seen, usable)
        rate = Fraction(25)
        offers = {offer.name: offer for offer in discover(entry_points=False).offers if offer.stage == "selector"}
        patient = offers["shortest-path"].checked.select(table, frames=frames, rate=rate)
        assert [len(s.range) for s in patient] == [frames]
        assert not hasattr(offers["least-occluded"].implementation, "min_shot_s")
        greedy = offers["least-occluded"].checked
        before = greedy.select(table, frames=frames, rate=rate)
        assert [len(s.range) for s in before] == [frames - 15, 15]
        for end in (0, -1):
            moved = moved_switches(before, [], rate, greedy.min_shot_s, lambda _, span, end=end: [*span][end])
            assert len(with_switches_at(before, tuple(moved))[1].range) >= 15


@given(
    tables(),
    selectors(),
    st.sampled_from([Fraction(25), Fraction(30000, 1001), Fraction(12), Fraction(121, 10)]),
    st.data(),
)
@settings(max_examples=150, deadline=None)
def test_what_a_selector_promises_holds_after_the_refinement(drawn, selector, rate: Fraction, data) -> None:
    """Whatever the pictures say, and wherever the lamp moves."""
    table, frames = drawn
    promised_s = getattr(selector, "min_shot_s", MIN_SHOT_S)
    promised = getattr(getattr(selector, "implementation", selector), "min_shot_s", None)
    before = selector.select(table, frames=frames, rate=rate)
    movements = data.draw(movements_in(frames))
    # The worst that pictures can do: each switch goes to either end of where it may, or anywhere.
    worst = data.draw(st.sampled_from(["first", "last", "any"]))

    def choose_frame(number: int, span: FrameRange) -> int:
        assert before[number + 1].range.start in span
        ends = {"first": span.start, "last": span.stop - 1}
        return ends[worst] if worst in ends else data.draw(st.integers(span.start, span.stop - 1))

    switches = tuple(moved_switches(before, movements, rate, promised_s, choose_frame))
    after = with_switches_at(before, switches)
    check_tiles((s.range for s in after), frames, "shots")
    for old, new in zip(before, after, strict=True):
        assert len(new.range) >= min(len(old.range), ceil(promised_s * float(rate) - 1e-9))
    if promised is not None and len(after) > 1:
        assert min(len(s.range) for s in after) / float(rate) >= promised - 1e-9
