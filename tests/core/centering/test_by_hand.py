"""Centres that an editor set by hand: how they ease into the automatic shift and out of it."""

from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mcsl_core.edl import IDENTITY, Camera, Edl, Media, Override, Pose, Shot
from mcsl_core.edl.resolve import ACCELERATION, resolve, shift_at
from mcsl_core.timing import FrameRange

SIZE = (960, 540)


def programme(*overrides, shots=None, poses=1, centering=((0, 20.0, -6.0),), frames=1200):
    cameras = tuple(Camera(n, (Media(f"{n}.mp4", frames),), SIZE, Fraction(25)) for n in ("a", "b"))
    step = frames // poses
    homographies = {"a": IDENTITY, "b": IDENTITY}
    return Edl(
        rate=Fraction(25),
        size=SIZE,
        frames=frames,
        reference="a",
        cameras=cameras,
        poses=tuple(Pose(FrameRange(n * step, (n + 1) * step), homographies) for n in range(poses)),
        shots=shots or (Shot(FrameRange(0, frames), "a"),),
        overrides=overrides,
        centering=centering,
    )


def shifts_of(edl):
    return np.array([shift_at(edl, decision, frame) for piece, decision in resolve(edl) for frame in piece])


def test_a_centre_by_hand_eases_in_and_out_inside_its_range():
    path = shifts_of(programme(Override(FrameRange(400, 800), offset=(90.0, 40.0))))
    assert (path[:400] == (20, -6)).all()
    assert (path[800:] == (20, -6)).all()
    assert (path[480:720] == (90, 40)).all()
    assert 20 < path[400, 0] < 21
    assert 20 < path[799, 0] < 21
    assert np.abs(np.diff(path, n=2, axis=0)).max() <= ACCELERATION * SIZE[0]


def test_it_jumps_where_there_is_a_cut_anyway():
    shots = (Shot(FrameRange(0, 400), "a"), Shot(FrameRange(400, 1200), "b"))
    path = shifts_of(programme(Override(FrameRange(400, 600), offset=(90.0, 40.0)), shots=shots, poses=2))
    assert (path[400] == (90, 40)).all()  # the camera changes
    assert (path[599] == (90, 40)).all()  # and here the pose does
    assert (path[600] == (20, -6)).all()


def test_of_two_centres_that_meet_the_later_eases_and_other_overrides_do_not_matter():
    first, second = (
        Override(FrameRange(200, 600), offset=(90.0, 40.0)),
        Override(FrameRange(600, 1000), offset=(0.0, 0.0)),
    )
    path = shifts_of(programme(first, second))
    assert (path[400:600] == (90, 40)).all()
    assert np.abs(np.diff(path, n=2, axis=0)).max() <= ACCELERATION * SIZE[0]
    fill = [Override(FrameRange(a, a + 7), fill=False) for a in (210, 595, 604)]
    assert np.array_equal(shifts_of(programme(first, second, *fill)), path)


@given(
    st.lists(
        st.tuples(st.integers(0, 1100), st.integers(100, 600), st.floats(-200, 200), st.floats(-99, 99)), max_size=4
    ),
    st.booleans(),
)
def test_centres_by_hand_never_jerk_where_there_is_room(drawn, automatic):
    ends = [(start, min(1200, start + length), x, y) for start, length, x, y in drawn]
    overrides = [Override(FrameRange(a, b), offset=(x, y)) for a, b, x, y in ends]
    edl = programme(*overrides, centering=((0, 20.0, -6.0),) if automatic else ())
    path = shifts_of(edl)
    runs = [len(piece) for piece, decision in resolve(edl) if decision.offset is not None]
    if min(runs, default=0) >= 230:  # twice the ease of 440 pixels, the furthest apart two of them can be
        assert np.abs(np.diff(path, n=2, axis=0)).max() <= ACCELERATION * SIZE[0] + 1e-9


def test_the_frames_of_an_ease_are_conformed_anew_when_its_other_side_changes():
    """What an ease depends on is in the decision, and so in the key of a chunk."""
    near = resolve(programme(Override(FrameRange(400, 800), offset=(90.0, 40.0))))
    far = resolve(
        programme(Override(FrameRange(400, 800), offset=(90.0, 40.0)), Override(FrameRange(0, 400), centering=False))
    )
    assert near[1][1] != far[1][1]
