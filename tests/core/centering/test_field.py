"""Centering keys: the bound on acceleration and what must not move; gaze from files to resting places."""

import math
from fractions import Fraction
from pathlib import Path

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcsl_core.centering.field import FieldCenterer, field_middle
from mcsl_core.centering.gaze import Gaze, fixations, read_gaze
from mcsl_core.centering.places import gaze_places
from mcsl_core.centering.protocol import FieldPlace
from mcsl_core.edl import IDENTITY, Camera, Correction, Edl, Media, Override, Pose, Shot
from mcsl_core.edl.resolve import ACCELERATION, offset_at, resolve, shift_at
from mcsl_core.errors import DocumentError, InputError
from mcsl_core.timing import FrameRange

SIZE = (960, 540)


@st.composite
def programmes(draw):
    """Places that tile a programme, a picture's size and a rate."""
    size = draw(st.sampled_from([(320, 180), (960, 540), (1920, 1080), (3840, 2160)]))
    lengths = draw(st.lists(st.integers(1, 2000), min_size=1, max_size=8))
    starts = np.cumsum([0, *lengths]).tolist()
    middle = st.one_of(st.none(), st.tuples(st.floats(-100, size[0] + 100), st.floats(-100, size[1] + 100)))
    places = [FieldPlace(FrameRange(a, b), draw(middle)) for a, b in zip(starts, starts[1:], strict=False)]
    return places, size, draw(st.sampled_from([8.0, 25.0, 29.97, 60.0]))


def path_of(keys, frames):
    at, dx, dy = zip(*keys, strict=True) if keys else ((0,), (0,), (0,))
    path = np.stack([np.interp(range(frames), at, d) for d in (dx, dy)], axis=1)
    for frame in (0, frames // 2, frames - 1):
        assert offset_at(tuple(keys), frame) == pytest.approx(tuple(path[frame]))
    return path


@given(programmes())
def test_the_picture_never_jerks(programme):
    places, size, rate = programme
    keys = FieldCenterer().centre(places, size=size, rate=rate)
    frames = places[-1].range.stop
    assert all(0 <= frame < frames for frame, _, _ in keys)
    assert all(a[0] < b[0] for a, b in zip(keys, keys[1:], strict=False))
    path = path_of(keys, frames)
    changes = np.abs(np.diff(path, n=2, axis=0))
    assert changes.max(initial=0) <= ACCELERATION * size[0] + 1e-6
    assert np.abs(path).max(initial=0) <= 0.25 * max(size)
    assert len(keys) <= 9 * len(places)


@given(programmes())
def test_what_lies_near_the_middle_stays_and_nothing_is_shifted_more_than_it_must(programme):
    places, size, rate = programme
    centerer = FieldCenterer()
    near = [p for p in places if p.middle and _away(p.middle, size) <= centerer.near]
    if len(near) == sum(p.middle is not None for p in places):
        assert all((dx, dy) == (0, 0) for _, dx, dy in centerer.centre(places, size=size, rate=rate))
    if len(places) == 1 and places[0].middle:
        ((_, dx, dy),) = centerer.centre(places, size=size, rate=rate)
        for extent, at, shift in zip(size, places[0].middle, (dx, dy), strict=True):
            away = (extent - 1) / 2 - at
            left = abs(away - shift)
            assert abs(shift) <= abs(away)
            # By even whole pixels: up to two short of the least that brings it near.
            near = min(abs(away), centerer.near * extent) - 1e-6 <= left <= centerer.near * extent + 2
            assert near or abs(shift) > centerer.most * extent - 2


def _away(middle, size):
    return max(abs((extent - 1) / 2 - at) / extent for extent, at in zip(size, middle, strict=True))


def test_each_pose_is_centred_and_the_glide_lies_about_the_boundary():
    places = [FieldPlace(FrameRange(0, 1000), (380.0, 270.0)), FieldPlace(FrameRange(1000, 2000), (700.0, 330.0))]
    keys = FieldCenterer().centre(places, size=SIZE, rate=25.0)
    path = path_of(keys, 2000)
    assert path[0] == pytest.approx((99.5 - 48, 0.0), abs=2)
    assert path[-1] == pytest.approx((-220.5 + 48, -60.5 + 27), abs=2)
    glides = np.flatnonzero(np.abs(np.diff(path, axis=0)).max(axis=1) > 0)
    assert glides[0] + glides[-1] == pytest.approx(2000, abs=4)
    assert 50 < len(glides) < 400


def test_a_stretch_too_short_to_glide_to_keeps_its_neighbours_offset():
    places = [
        FieldPlace(FrameRange(0, 1000), (380.0, 270.0)),
        FieldPlace(FrameRange(1000, 1020), (800.0, 270.0)),
        FieldPlace(FrameRange(1020, 2000), (380.0, 270.0)),
    ]
    assert len(FieldCenterer().centre(places, size=SIZE, rate=25.0)) == 1


def test_the_middle_does_not_follow_a_hand_over_part_of_the_field():
    mask = np.zeros((54, 96), bool)
    mask[20:40, 30:70] = True
    whole = field_middle(mask, np.diag([10.0, 10, 1]))
    mask[20:40, 60:70] = False  # a quarter of it hidden, at one side: the middle moves by an eighth at most
    hidden = field_middle(mask, np.diag([10.0, 10, 1]))
    assert whole == pytest.approx((495, 295))
    assert abs(hidden[0] - whole[0]) <= 400 / 8
    assert field_middle(np.zeros((4, 4), bool), np.eye(3)) is None


# ----------------------------------------------------------------------------------------------------------- by hand


def by_hand(*overrides, shots=None, poses=1, centering=((0, 20.0, -6.0),), frames=1200):
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
    path = shifts_of(by_hand(Override(FrameRange(400, 800), offset=(90.0, 40.0))))
    assert (path[:400] == (20, -6)).all()
    assert (path[800:] == (20, -6)).all()
    assert (path[480:720] == (90, 40)).all()
    assert 20 < path[400, 0] < 21
    assert 20 < path[799, 0] < 21
    assert np.abs(np.diff(path, n=2, axis=0)).max() <= ACCELERATION * SIZE[0]


def test_it_jumps_where_there_is_a_cut_anyway():
    shots = (Shot(FrameRange(0, 400), "a"), Shot(FrameRange(400, 1200), "b"))
    path = shifts_of(by_hand(Override(FrameRange(400, 600), offset=(90.0, 40.0)), shots=shots, poses=2))
    assert (path[400] == (90, 40)).all()  # the camera changes
    assert (path[599] == (90, 40)).all()  # and here the pose does
    assert (path[600] == (20, -6)).all()


def test_of_two_centres_that_meet_the_later_eases_and_other_overrides_do_not_matter():
    first, second = (
        Override(FrameRange(200, 600), offset=(90.0, 40.0)),
        Override(FrameRange(600, 1000), offset=(0.0, 0.0)),
    )
    path = shifts_of(by_hand(first, second))
    assert (path[400:600] == (90, 40)).all()
    assert np.abs(np.diff(path, n=2, axis=0)).max() <= ACCELERATION * SIZE[0]
    fill = [Override(FrameRange(a, a + 7), fill=False) for a in (210, 595, 604)]
    assert np.array_equal(shifts_of(by_hand(first, second, *fill)), path)


@given(
    st.lists(
        st.tuples(st.integers(0, 1100), st.integers(100, 600), st.floats(-200, 200), st.floats(-99, 99)), max_size=4
    ),
    st.booleans(),
)
def test_centres_by_hand_never_jerk_where_there_is_room(drawn, automatic):
    ends = [(start, min(1200, start + length), x, y) for start, length, x, y in drawn]
    overrides = [Override(FrameRange(a, b), offset=(x, y)) for a, b, x, y in ends]
    edl = by_hand(*overrides, centering=((0, 20.0, -6.0),) if automatic else ())
    path = shifts_of(edl)
    runs = [len(piece) for piece, decision in resolve(edl) if decision.offset is not None]
    if min(runs, default=0) >= 230:  # twice the ease of 440 pixels, the furthest apart two of them can be
        assert np.abs(np.diff(path, n=2, axis=0)).max() <= ACCELERATION * SIZE[0] + 1e-9


def test_the_frames_of_an_ease_are_conformed_anew_when_its_other_side_changes():
    """What an ease depends on is in the decision, and so in the key of a chunk."""
    near = resolve(by_hand(Override(FrameRange(400, 800), offset=(90.0, 40.0))))
    far = resolve(
        by_hand(Override(FrameRange(400, 800), offset=(90.0, 40.0)), Override(FrameRange(0, 400), centering=False))
    )
    assert near[1][1] != far[1][1]


# -------------------------------------------------------------------------------------------------------------- gaze


def nowhere(frame, camera):
    return None


def looks_at(x, y, start_s, stop_s, observer="a", rate=25.0, noise=0.0, seed=0):
    rng = np.random.default_rng(seed)
    return [
        Gaze(t * rate, observer, x + noise * rng.normal(), y + noise * rng.normal())
        for t in np.arange(start_s, stop_s, 0.1)
    ]


def test_observers_are_averaged_and_gaps_bridged():
    looks = looks_at(400, 200, 0, 20, "a", noise=8) + looks_at(440, 240, 5, 60, "b", noise=8, seed=1)
    looks += looks_at(400, 200, 40, 60, "a", noise=8, seed=2)
    ((piece, (x, y)),) = fixations(looks, nowhere, frames=1500, size=SIZE, rate=25.0)
    assert piece == FrameRange(0, 1500)
    assert 400 < x < 440
    assert 200 < y < 240
    both = fixations(looks_at(400, 200, 0, 9) + looks_at(440, 240, 0, 9, "b"), nowhere, frames=225, size=SIZE, rate=25)
    assert both[0][1] == pytest.approx((420, 220))


def test_an_observer_with_more_samples_weighs_no_more():
    often = [Gaze(n, "a", 400, 200) for n in range(200)]
    seldom = [Gaze(n, "b", 440, 240) for n in range(0, 200, 20)]
    assert fixations(often + seldom, nowhere, frames=200, size=SIZE, rate=25)[0][1] == pytest.approx((420, 220))


def test_a_glance_aside_moves_nothing_and_a_new_place_is_followed():
    looks = looks_at(400, 200, 0, 20, noise=5) + looks_at(800, 400, 20, 23) + looks_at(400, 200, 23, 60, noise=5)
    assert len(fixations(looks, nowhere, frames=1500, size=SIZE, rate=25.0)) == 1
    looks = looks_at(400, 200, 0, 30, noise=5) + looks_at(700, 300, 30, 60, noise=5)
    (first, at_first), (second, at_second) = fixations(looks, nowhere, frames=1500, size=SIZE, rate=25.0)
    assert first.stop == second.start == 750
    assert at_first == pytest.approx((400, 200), abs=6)
    assert at_second == pytest.approx((700, 300), abs=6)


def test_camera_pixels_go_through_the_poses():
    shift = np.array([[1.0, 0, 100], [0, 1, -50], [0, 0, 1]])
    looks = [Gaze(n, "a", 300, 250, "cam2") for n in range(200)] + [Gaze(n, "a", 0, 0, "cam3") for n in range(200)]
    found = fixations(looks, lambda frame, camera: shift if camera == "cam2" else None, frames=200, size=SIZE, rate=25)
    assert found[0][1] == pytest.approx((400, 200))
    assert fixations([], nowhere, frames=200, size=SIZE, rate=25) == []


@given(
    st.lists(st.tuples(st.floats(0, 600), st.integers(0, 900), st.integers(0, 500)), max_size=60), st.integers(1, 600)
)
def test_resting_places_tile_the_programme(points, frames):
    places = fixations([Gaze(f, "a", x, y) for f, x, y in points], nowhere, frames=frames, size=SIZE, rate=2.0)
    assert not places or (places[0][0].start, places[-1][0].stop) == (0, frames)
    assert all(a[0].stop == b[0].start for a, b in zip(places, places[1:], strict=False))


def write(path: Path, text: str) -> Path:
    path.write_text(text, "utf-8")
    return path


def test_files_by_frame_or_time_with_blinks_and_a_byte_order_mark(tmp_path):
    a = write(tmp_path / "視線.csv", "\ufefftime,x,y\n1.5,10,20\n1.6,,\n")
    b = write(tmp_path / "b.csv", "frame,observer,x,y,camera\n3,Kim,1,2,cam1\n4,Kim,5,6,\n")
    looks = read_gaze([a, b], rate=30, cameras=["cam1"])
    assert looks == (Gaze(45, "視線.csv", 10, 20), Gaze(3, "Kim", 1, 2, "cam1"), Gaze(4, "Kim", 5, 6))
    assert all(math.isfinite(look.frame) for look in looks)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "columns none"),
        ("a,b\n1,2\n", "expected frame or time"),
        ("frame,x,y\n1,2,3\nsoon,2,3\n", "line 3"),
        ("frame,x,y\n1,nan,3\n", "not finite"),
        ("frame,x,y,camera\n1,2,3,cam9\n", "cam9"),
    ],
)
def test_a_wrong_file_is_refused_with_the_line(tmp_path, text, said):
    path = write(tmp_path / "gaze.csv", text)
    with pytest.raises(DocumentError, match=said) as caught:
        read_gaze([path], rate=25, cameras=["cam1"])
    assert str(path) in str(caught.value)


def test_a_missing_file_is_an_input_error(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        read_gaze([tmp_path / "none.csv"], rate=25, cameras=[])


def test_the_analysis_takes_a_cameras_gaze_through_its_pose_and_the_editors_correction():
    aside = ((1.0, 0.0, 100.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    edl = attrs.evolve(by_hand(poses=2), corrections=(Correction(FrameRange(600, 1200), "b", aside),))
    looks = [Gaze(frame, "a", 300.0, 200.0, "b") for frame in range(0, 1200, 5)]
    first, second = gaze_places(looks, edl)
    assert (first.range, first.middle) == (FrameRange(0, 600), (300.0, 200.0))
    assert (second.range, second.middle) == (FrameRange(600, 1200), (400.0, 200.0))
