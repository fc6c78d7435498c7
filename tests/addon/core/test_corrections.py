# SPDX-License-Identifier: GPL-3.0-or-later
"""Camera strips moved by hand: what becomes a correction, and that it shows again as it was set."""

from __future__ import annotations

import cmath
import math
import struct

import attrs
import numpy as np
import pytest
from builders import CAMERAS, small_edl, state_of
from hypothesis import given, settings
from hypothesis import strategies as st

from blender_addon.core.read_overrides import SequencerState, read_edl
from blender_addon.core.similarity import Transform, matrix_of, transform_of
from blender_addon.core.strip_plan import camera_transform, make_plan
from mcsl_core.edl import IDENTITY, Camera, Correction, Edl, Media, Pose, Weak, dumps, loads
from mcsl_core.edl.placement import placement_matrix
from mcsl_core.errors import InputError
from mcsl_core.timing import FrameRange

R = FrameRange
TURNED = ((0.9, -0.4, 30.0), (0.38, 0.88, -12.0), (1e-4, -2e-4, 1.0))


def two_poses(**fields) -> Edl:
    homographies = {"cam1": IDENTITY, "cam2": TURNED, "cam3": IDENTITY}
    poses = (Pose(R(0, 120), homographies), Pose(R(120, 300), homographies))
    return small_edl(**{"poses": poses, **fields})


def built(edl: Edl) -> SequencerState:
    return state_of(make_plan(edl))


def nudge(state: SequencerState, camera: str, start: int, **fields) -> SequencerState:
    """The camera's strip that begins at ``start`` with other numbers in its transform."""
    cameras = []
    for strip in state.cameras:
        if (strip.camera, strip.start) == (camera, start):
            assert strip.transform is not None
            strip = attrs.evolve(strip, transform=attrs.evolve(strip.transform, **fields))
        cameras.append(strip)
    assert tuple(cameras) != state.cameras
    return attrs.evolve(state, cameras=tuple(cameras))


def moved(edl: Edl, by: float) -> Edl:
    """cam2 of the second pose ``by`` pixels to the right of where it stands."""
    strip = next(s for s in built(edl).cameras if (s.camera, s.start) == ("cam2", 120))
    assert strip.transform is not None
    return read_edl(edl, nudge(built(edl), "cam2", 120, offset_x=strip.transform.offset_x + by))


def test_untouched_strips_decide_nothing():
    assert read_edl(two_poses(), built(two_poses())) == two_poses()


def test_a_shift_is_a_correction_of_that_pose_alone():
    new = moved(two_poses(), 7.5)
    [correction] = new.corrections
    assert (correction.range, correction.camera) == (R(120, 300), "cam2")
    np.testing.assert_allclose(correction.matrix, [[1, 0, 7.5], [0, 1, 0], [0, 0, 1]], atol=1e-9)
    assert new.overrides == ()


def test_up_is_up():
    edl = two_poses()
    new = read_edl(edl, nudge(built(edl), "cam3", 0, offset_y=4.0))  # y up in Blender, down in the programme
    np.testing.assert_allclose(new.corrections[0].matrix, [[1, 0, 0], [0, 1, -4], [0, 0, 1]], atol=1e-9)


def test_a_turn_is_about_the_middle_of_the_picture_as_it_is_shown():
    edl = two_poses()
    new = read_edl(edl, nudge(built(edl), "cam3", 0, rotation=math.radians(90)))
    to = np.array(new.corrections[0].matrix)
    middle = np.array([159.5, 89.5, 1])
    np.testing.assert_allclose(to @ middle, middle, atol=1e-9)
    np.testing.assert_allclose(to @ [169.5, 89.5, 1], [159.5, 79.5, 1], atol=1e-9)  # counter-clockwise to the eye


def test_set_back_to_its_automatic_place_the_correction_goes():
    edl = moved(two_poses(), 7.5)
    planned = next(s.planned for s in built(edl).cameras if (s.camera, s.start) == ("cam2", 120))
    assert planned is not None
    state = nudge(built(edl), "cam2", 120, **attrs.asdict(planned))
    assert read_edl(edl, state) == two_poses()


def test_less_than_can_be_seen_is_no_nudge():
    assert moved(two_poses(), 0.04) == two_poses()
    assert moved(two_poses(), 0.06) != two_poses()
    edl = moved(two_poses(), 7.5)
    assert moved(edl, 0.04) == edl


def test_a_note_and_the_place_in_the_list_stay_with_a_correction_that_changes():
    edl = moved(two_poses(), 7.5)
    edl = attrs.evolve(
        edl,
        corrections=(
            attrs.evolve(edl.corrections[0], note="by eye"),
            Correction(R(0, 120), "cam3", ((1.0, 0.0, 3.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))),
        ),
    )
    new = moved(edl, 1)
    assert [(c.camera, c.note, round(c.matrix[0][2], 6)) for c in new.corrections] == [
        ("cam2", "by eye", 8.5),
        ("cam3", "", 3.0),
    ]


def test_a_correction_over_two_poses_stays_over_the_other():
    shift = ((1.0, 0.0, 5.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    edl = two_poses(corrections=(Correction(R(0, 300), "cam2", shift),))
    new = moved(edl, 2)
    assert sorted((c.range, round(c.matrix[0][2], 6)) for c in new.corrections) == [
        (R(0, 120), 5.0),
        (R(120, 300), 7.0),
    ]


def test_one_file_touched_holds_for_the_pose_and_two_that_differ_are_refused():
    files = (Media("a.mp4", 100), Media("b.mp4", 200))
    cameras = tuple(attrs.evolve(c, media=files) if c.name == "cam3" else c for c in small_edl().cameras)
    edl = small_edl(cameras=cameras)
    state = nudge(built(edl), "cam3", 100, offset_x=3.0)
    [correction] = read_edl(edl, state).corrections
    assert correction.range == R(0, 300)
    with pytest.raises(InputError, match=r"strips 'cam3\.0' and 'cam3\.100' of cam3: stand differently in one pose"):
        read_edl(edl, nudge(state, "cam3", 0, offset_x=5.0))
    assert read_edl(edl, nudge(state, "cam3", 0, offset_x=3.0)).corrections == (correction,)


def test_a_deleted_or_older_strip_says_nothing():
    edl = moved(two_poses(), 7.5)
    state = built(edl)
    kept = tuple(s for s in state.cameras if (s.camera, s.start) != ("cam2", 120))
    assert read_edl(edl, attrs.evolve(state, cameras=kept)) == edl
    older = tuple(attrs.evolve(s, planned=None, transform=Transform(9, 9, 2, 1)) for s in state.cameras)
    assert read_edl(edl, attrs.evolve(state, cameras=older)) == edl


@pytest.mark.parametrize("fields", [{"scale": 0.0}, {"scale": -1.0}, {"scale_y": -1.0}])
def test_a_mirrored_or_vanished_picture_is_refused(fields):
    edl = two_poses()
    with pytest.raises(InputError, match=r"strip 'cam3\.0' of cam3, frame 1: is mirrored or scaled to nothing"):
        read_edl(edl, nudge(built(edl), "cam3", 0, **fields))


def test_a_weak_camera_is_placed_by_hand():
    """Its base is the whole programme, edge on edge, while its strip stood upright and whole: the sizes differ here."""
    cameras = tuple(attrs.evolve(c, size=(300, 100)) if c.name == "cam3" else c for c in small_edl().cameras)
    pose = Pose(R(0, 300), {"cam1": IDENTITY, "cam2": IDENTITY}, weak=(Weak("cam3", "no matches"),))
    edl = small_edl(cameras=cameras, poses=(pose,))
    state = nudge(built(edl), "cam3", 0, offset_x=20.0, rotation=0.3, scale=0.8)
    new = read_edl(edl, state)
    set_to = Transform(20.0, 0.0, 0.8, 0.3)
    np.testing.assert_allclose(
        placement_matrix(new, pose, "cam3"), matrix_of(set_to, (300, 100), (320, 180)), atol=1e-6
    )
    shown = camera_transform(new, cameras[2], pose)
    assert attrs.astuple(shown)[:4] == pytest.approx(attrs.astuple(set_to)[:4])
    assert read_edl(new, built(new)) == new


def test_a_correction_no_strip_can_show_is_shown_as_nearly_as_it_can_and_stays():
    bent = Correction(R(0, 300), "cam2", ((1.0, 0.05, 3.0), (0.0, 1.0, 2.0), (1e-5, 0.0, 1.0)), "made elsewhere")
    edl = small_edl(corrections=(bent,))
    assert read_edl(edl, built(edl)) == edl


def test_a_strip_of_an_older_analysis_holds_where_it_lies():
    """Built with one pose, nudged; the lamp is now known to have moved at 50: the strip lies over both poses."""
    edl = small_edl()
    state = nudge(built(edl), "cam3", 0, offset_x=6.0)
    poses = tuple(attrs.evolve(edl.poses[0], range=r) for r in (R(0, 50), R(50, 300)))
    new = read_edl(attrs.evolve(edl, poses=poses), state)
    assert [(c.range, c.matrix[0][2]) for c in new.corrections] == [(R(0, 50), 6.0), (R(50, 300), 6.0)]


def test_a_strip_that_reaches_a_little_into_a_pose_says_nothing_about_it():
    """Built with the pose's end at 120, which a new analysis puts at 75: the strip lies over a fifth of the next."""
    edl = two_poses()
    state = nudge(built(edl), "cam3", 0, offset_x=6.0)
    poses = (attrs.evolve(edl.poses[0], range=R(0, 75)), attrs.evolve(edl.poses[1], range=R(75, 190)))
    poses = (*poses, attrs.evolve(edl.poses[1], range=R(190, 300)))
    new = read_edl(attrs.evolve(edl, poses=poses), state)
    assert [(c.camera, c.range) for c in new.corrections] == [("cam3", R(0, 75))]


def test_of_a_correction_that_is_replaced_no_rest_stays_that_holds_nowhere():
    shift = ((1.0, 0.0, 5.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    edl = two_poses(corrections=(Correction(R(100, 300), "cam2", shift),))  # all of the second pose, a bit of the first
    [correction] = moved(edl, 2).corrections
    assert (correction.range, correction.matrix[0][2]) == (R(120, 300), pytest.approx(7.0))


# --------------------------------------------------------------------------------------------------- properties

SCALES, ANGLES, SHIFTS = st.floats(0.3, 3), st.floats(-3.1, 3.1), st.floats(-300, 300)
transforms = st.builds(Transform, SHIFTS, SHIFTS, SCALES, ANGLES, st.none() | SCALES)


def as_blender_keeps(transform: Transform) -> Transform:
    """Rounded to float32, every number of it."""
    x, y, scale, angle, scale_y = struct.unpack(
        "5f", struct.pack("5f", *[*attrs.astuple(transform)[:4], transform.height_scale])
    )
    return Transform(x, y, scale, angle, None if scale == scale_y else scale_y)


def found(edl: Edl) -> SequencerState:
    """As read from Blender after building."""
    state = built(edl)
    cameras = tuple(
        attrs.evolve(c, transform=as_blender_keeps(c.transform)) if c.transform is not None else c
        for c in state.cameras
    )
    return attrs.evolve(state, cameras=cameras)


@st.composite
def placed_edls(draw) -> Edl:
    """Three cameras of any size, seen from anywhere, perhaps weak, two poses."""

    def seen() -> tuple:
        turn = draw(SCALES) * cmath.exp(1j * draw(ANGLES))
        bend = st.floats(-3e-4, 3e-4)
        return (
            (turn.real, -turn.imag, draw(SHIFTS)),
            (turn.imag, turn.real, draw(SHIFTS)),
            (draw(bend), draw(bend), 1.0),
        )

    sizes = st.tuples(st.integers(64, 2000), st.integers(64, 1200))
    cameras = tuple(Camera(n, (Media(f"{n}.mp4", 300),), draw(sizes), small_edl().rate) for n in CAMERAS)
    weak = draw(st.booleans())
    poses = tuple(
        Pose(
            piece,
            {"cam1": IDENTITY, "cam2": seen()} | ({} if weak else {"cam3": seen()}),
            weak=(Weak("cam3", "nothing to match"),) if weak else (),
        )
        for piece in (R(0, 140), R(140, 300))
    )
    edl = small_edl(cameras=cameras, poses=poses, size=draw(sizes))
    return loads(dumps(edl))  # rounded to the document's digits, as every EDL that a timeline is built from


@settings(max_examples=150, deadline=None)
@given(placed_edls())
def test_what_blender_rounds_is_no_nudge(edl: Edl):
    assert dumps(read_edl(edl, found(edl))) == dumps(edl)


@settings(max_examples=150, deadline=None)
@given(placed_edls(), st.sampled_from(CAMERAS), st.sampled_from((0, 140)), transforms)
def test_a_nudge_comes_back_as_it_was_set(edl: Edl, camera: str, start: int, to: Transform):
    """Strips -> EDL -> text -> EDL -> strips: the strip stands where it was put, all others where they stood."""
    state = nudge(found(edl), camera, start, **attrs.asdict(as_blender_keeps(to)))
    new = loads(dumps(read_edl(edl, state)))
    assert new.overrides == edl.overrides
    assert {(c.camera, c.range.start) for c in new.corrections} <= {(camera, start)}
    for strip, wanted in zip(built(new).cameras, state.cameras, strict=True):
        size = edl.camera(strip.camera).size
        assert strip.transform is not None
        assert wanted.transform is not None
        corners = np.array([[x, y, 1] for x in (0, size[0] - 1) for y in (0, size[1] - 1)]).T
        here = np.array(matrix_of(strip.transform, size, edl.size)) @ corners
        there = np.array(matrix_of(wanted.transform, size, edl.size)) @ corners
        assert np.abs(here - there).max() < 0.05 + 1e-3, (strip, wanted)
    assert read_edl(new, found(new)) == new  # and reading again decides nothing new
    # the exact picture moves by the same map as the preview did, wherever it lies
    pose = new.poses[0 if start == 0 else 1]
    before, after = placement_matrix(edl, pose, camera), placement_matrix(new, pose, camera)
    if before is not None and new.corrections:
        assert after is not None
        step = np.array(after) @ np.linalg.inv(before)
        size = edl.camera(camera).size
        old = next(s.transform for s in built(edl).cameras if (s.camera, s.start) == (camera, start))
        preview = np.array(matrix_of(to, size, edl.size)) @ np.linalg.inv(matrix_of(old, size, edl.size))
        np.testing.assert_allclose(step / step[2, 2], preview, rtol=1e-4, atol=2e-2)


@given(transforms, st.tuples(st.integers(2, 4000), st.integers(2, 4000)))
def test_a_transform_and_its_matrix_are_one(transform: Transform, size: tuple[int, int]):
    back = transform_of(matrix_of(transform, size, (1920, 1080)), size, (1920, 1080))
    assert back is not None
    assert (back.offset_x, back.offset_y) == pytest.approx((transform.offset_x, transform.offset_y), abs=1e-6)
    assert (back.scale, back.height_scale) == pytest.approx((transform.scale, transform.height_scale), rel=1e-5)
    assert cmath.exp(1j * back.rotation) == pytest.approx(cmath.exp(1j * transform.rotation), abs=1e-5)


def test_what_no_strip_can_show_has_no_transform():
    sheared = ((1.0, 0.2, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    mirrored = ((-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    for matrix in (TURNED, sheared, mirrored):
        assert transform_of(matrix, (320, 180), (320, 180)) is None
