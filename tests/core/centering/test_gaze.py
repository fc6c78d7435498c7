"""Gaze to fixations, and through the poses to what is centred."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcsl_core.centering.gaze import Gaze, fixations
from mcsl_core.centering.positions import gaze_positions
from mcsl_core.edl import IDENTITY, Camera, Correction, Edl, Media, Pose, Shot
from mcsl_core.timing import FrameRange

SIZE = (960, 540)


def nowhere(frame, camera):
    return None


def rest(x, y, start_s, stop_s, observer="a", *, noise=0.0, seed=0):
    """Eyes that rest on one point, ten samples a second of a programme at 25 frames a second."""
    rng = np.random.default_rng(seed)
    times_s = np.arange(start_s, stop_s, 0.1)
    return [Gaze(t * 25.0, observer, x + noise * rng.normal(), y + noise * rng.normal()) for t in times_s]


def test_observers_are_averaged_and_gaps_bridged():
    gaze = rest(400, 200, 0, 20, "a", noise=8) + rest(440, 240, 5, 60, "b", noise=8, seed=1)
    gaze += rest(400, 200, 40, 60, "a", noise=8, seed=2)
    ((piece, (x, y)),) = fixations(gaze, nowhere, frames=1500, size=SIZE, rate=25.0)
    assert piece == FrameRange(0, 1500)
    assert 400 < x < 440
    assert 200 < y < 240
    both = fixations(rest(400, 200, 0, 9) + rest(440, 240, 0, 9, "b"), nowhere, frames=225, size=SIZE, rate=25)
    assert both[0][1] == pytest.approx((420, 220))


def test_an_observer_with_more_samples_weighs_no_more():
    often = [Gaze(n, "a", 400, 200) for n in range(200)]
    seldom = [Gaze(n, "b", 440, 240) for n in range(0, 200, 20)]
    assert fixations(often + seldom, nowhere, frames=200, size=SIZE, rate=25)[0][1] == pytest.approx((420, 220))


def test_a_glance_aside_moves_nothing_and_a_new_point_is_followed():
    gaze = rest(400, 200, 0, 20, noise=5) + rest(800, 400, 20, 23) + rest(400, 200, 23, 60, noise=5)
    assert len(fixations(gaze, nowhere, frames=1500, size=SIZE, rate=25.0)) == 1
    gaze = rest(400, 200, 0, 30, noise=5) + rest(700, 300, 30, 60, noise=5)
    (first, at_first), (second, at_second) = fixations(gaze, nowhere, frames=1500, size=SIZE, rate=25.0)
    assert first.stop == second.start == 750
    assert at_first == pytest.approx((400, 200), abs=6)
    assert at_second == pytest.approx((700, 300), abs=6)


def test_camera_pixels_go_through_the_poses():
    shift = np.array([[1.0, 0, 100], [0, 1, -50], [0, 0, 1]])
    gaze = [Gaze(n, "a", 300, 250, "cam2") for n in range(200)] + [Gaze(n, "a", 0, 0, "cam3") for n in range(200)]
    found = fixations(gaze, lambda frame, camera: shift if camera == "cam2" else None, frames=200, size=SIZE, rate=25)
    assert found[0][1] == pytest.approx((400, 200))
    assert fixations([], nowhere, frames=200, size=SIZE, rate=25) == []


@given(
    st.lists(st.tuples(st.floats(0, 600), st.integers(0, 900), st.integers(0, 500)), max_size=60), st.integers(1, 600)
)
def test_fixations_tile_the_programme(points, frames):
    found = fixations([Gaze(f, "a", x, y) for f, x, y in points], nowhere, frames=frames, size=SIZE, rate=2.0)
    assert not found or (found[0][0].start, found[-1][0].stop) == (0, frames)
    assert all(a[0].stop == b[0].start for a, b in pairwise(found))


def test_the_analysis_takes_a_cameras_gaze_through_its_pose_and_the_editors_correction():
    aside = ((1.0, 0.0, 100.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    edl = Edl(
        rate=Fraction(25),
        size=SIZE,
        frames=1200,
        reference="a",
        cameras=tuple(Camera(name, (Media(f"{name}.mp4", 1200),), SIZE, Fraction(25)) for name in ("a", "b")),
        poses=tuple(Pose(FrameRange(at, at + 600), {"a": IDENTITY, "b": IDENTITY}) for at in (0, 600)),
        shots=(Shot(FrameRange(0, 1200), "a"),),
        corrections=(Correction(FrameRange(600, 1200), "b", aside),),
    )
    gaze = [Gaze(frame, "a", 300.0, 200.0, "b") for frame in range(0, 1200, 5)]
    first, second = gaze_positions(gaze, edl)
    assert (first.range, first.middle) == (FrameRange(0, 600), (300.0, 200.0))
    assert (second.range, second.middle) == (FrameRange(600, 1200), (400.0, 200.0))
