# SPDX-License-Identifier: GPL-3.0-or-later
"""EDL -> strip plan, by example and by property."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import attrs
import pytest
from builders import CAMERAS, small_edl
from hypothesis import given
from hypothesis import strategies as st

from blender_addon.core.similarity import Transform, closest, fitted, invert, project
from blender_addon.core.strip_plan import (
    OffsetKey,
    automatic_from_text,
    automatic_to_text,
    first_frame,
    make_plan,
)
from mcsl_core.blender.messages import ConformedPiece
from mcsl_core.edl import IDENTITY, Camera, Clock, Look, Media, Movement, Override, Pose, Shot, Weak
from mcsl_core.edl.placement import multiply
from mcsl_core.edl.resolve import resolve, shift_at
from mcsl_core.timing import FrameRange, check_tiles

R = FrameRange
RATE = Fraction(30)


def track(edl, camera="cam2"):
    return next(t for t in make_plan(edl).cameras if t.camera == camera)


def with_camera(**fields):
    cameras = tuple(attrs.evolve(c, **fields) if c.name == "cam2" else c for c in small_edl().cameras)
    return small_edl(cameras=cameras)


def test_the_reference_camera_is_nearest_the_programme():
    plan = make_plan(small_edl(reference="cam2"))
    assert [(t.camera, t.channel) for t in plan.cameras] == [("cam1", 2), ("cam3", 3), ("cam2", 4)]
    assert (plan.programme_channel, plan.centering_channel, plan.conformed_channel) == (5, 6, 7)
    assert [s.source for s in plan.programme] == [2, 4, 3]


@pytest.mark.parametrize(
    ("offset_s", "rate", "start"),
    [
        (0.1, RATE, 3),
        (31 / 30, RATE, 31),  # times 30 it is 31.000000000000004 in floats
        (0.101, RATE, 4),
        (-0.1, RATE, -3),
        (100 * 1001 / 30000, Fraction(30000, 1001), 100),
    ],
)
def test_a_clock_offset_moves_a_strip_by_whole_frames(offset_s, rate, start):
    assert first_frame(offset_s, rate) == start


def test_a_late_camera_begins_late_and_an_early_one_is_cut_to_the_programme():
    [file] = track(with_camera(clock=Clock(offset_s=0.5))).files
    assert (file.start, [p.range for p in file.pieces]) == (15, [R(15, 300)])
    [file] = track(with_camera(clock=Clock(offset_s=-0.5))).files
    assert (file.start, [p.range for p in file.pieces]) == (-15, [R(0, 285)])


def test_files_follow_one_another_and_never_overlap():
    media = (Media("a.mp4", 100), Media("b.mp4", 100), Media("c.mp4", 100))
    files = track(with_camera(media=media)).files
    assert [(f.path, f.start) for f in files] == [("a.mp4", 0), ("b.mp4", 100), ("c.mp4", 200)]
    # a clock 1 % fast: the second file begins a frame before the first one's pictures are used up
    files = track(with_camera(media=media, clock=Clock(drift_ppm=10000))).files
    assert [f.start for f in files] == [0, 100, 199]
    assert files[1].pieces[-1].range == R(100, 199)


def test_a_camera_of_another_rate_is_told_of():
    assert make_plan(small_edl()).notes == ()
    [note] = make_plan(with_camera(rate=Fraction(25))).notes
    assert note.startswith("cam2 runs at 25.000 frames/s, the programme at 30.000")


def test_camera_strips_are_split_at_poses_and_leave_gaps_out():
    poses = (Pose(R(0, 120), dict.fromkeys(CAMERAS, IDENTITY)), Pose(R(120, 300), dict.fromkeys(CAMERAS, IDENTITY)))
    edl = attrs.evolve(with_camera(gaps=(R(50, 60), R(110, 130))), poses=poses)
    [file] = track(edl).files
    assert [p.range for p in file.pieces] == [R(0, 50), R(60, 110), R(130, 300)]


def test_markers():
    homographies = dict.fromkeys(CAMERAS, IDENTITY)
    edl = small_edl(
        movements=(Movement(R(100, 140)), Movement(R(150, 180)), Movement(R(280, 300))),
        poses=(Pose(R(0, 160), homographies), Pose(R(160, 300), homographies, perspective=1)),
    )
    assert [(m.frame, m.name) for m in make_plan(edl).markers] == [
        (100, ""),
        (140, "lamp moved"),
        (150, ""),
        (160, ""),
        (180, "perspective 1"),
        (280, "lamp moved"),  # it does not come to rest
    ]
    alone = attrs.evolve(edl, movements=())
    assert [(m.frame, m.name) for m in make_plan(alone).markers] == [(160, "perspective 1")]


def test_centering_keys_are_the_edls_own_where_it_is_always_on():
    edl = small_edl(centering=((0, 1.0, 2.0), (299, 3.0, -4.0)))
    assert make_plan(edl).centering == (OffsetKey(0, 1.0, -2.0), OffsetKey(299, 3.0, 4.0))
    assert make_plan(small_edl()).centering == ()


def test_centering_jumps_where_it_is_switched():
    edl = small_edl(centering=((0, 30.0, 0.0), (150, 30.0, 0.0)), overrides=(Override(R(100, 200), centering=False),))
    keys = make_plan(edl).centering
    assert [(k.frame, k.x, k.hold) for k in keys] == [
        *[(0, 30.0, False), (99, 30.0, True), (100, 0.0, True), (200, 30.0, False), (299, 30.0, True)]
    ]


def test_a_weak_camera_is_shown_whole_and_not_centered():
    homographies = {name: IDENTITY for name in CAMERAS if name != "cam2"}
    edl = small_edl(
        poses=(Pose(R(0, 300), homographies, weak=(Weak("cam2", "no matches"),)),),
        centering=((0, 5.0, 5.0),),
    )
    [file] = track(edl).files
    assert file.pieces[0].transform == Transform(0.0, 0.0, 1.0, 0.0)
    assert [(k.frame, k.x) for k in make_plan(edl).centering] == [
        (0, 5.0),
        (99, 5.0),
        (100, 0.0),
        (200, 5.0),
        (299, 5.0),
    ]


def test_conformed_pieces_and_sound_are_taken_over_in_order():
    pieces = [ConformedPiece(R(150, 300), Path("b.mp4")), ConformedPiece(R(0, 150), Path("a.mp4"))]
    plan = make_plan(small_edl(), pieces, Path("sound.wav"))
    assert [str(p.path) for p in plan.conformed] == ["a.mp4", "b.mp4"]
    assert [(s.path, s.start) for s in plan.sound] == [("sound.wav", 0)]
    assert [(s.path, s.start) for s in make_plan(small_edl()).sound] == [("cam1.mp4", 0)]


@given(st.lists(st.tuples(st.integers(1, 50), st.sampled_from(CAMERAS)), min_size=1, max_size=8), st.data())
def test_programme_strips_are_the_effective_shots(lengths, data):
    at, shots = 0, []
    for length, camera in lengths:
        shots.append(Shot(R(at, at + length), camera))
        at += length
    start = data.draw(st.integers(0, at - 1))
    override = Override(R(start, data.draw(st.integers(start + 1, at))), camera="cam2")
    edl = small_edl(
        at,
        shots=tuple(shots),
        overrides=(override,),
        cameras=tuple(Camera(n, (Media(f"{n}.mp4", at),), (320, 180), RATE) for n in CAMERAS),
    )
    plan = make_plan(edl)
    check_tiles((s.range for s in plan.programme), at, "strips")
    assert [(s.range, s.camera, s.overridden) for s in plan.programme] == [
        (piece, decision.camera, decision.overridden) for piece, decision in resolve(edl)
    ]
    assert len({s.id for s in plan.programme}) == len(plan.programme)
    assert automatic_from_text(automatic_to_text(plan.automatic)) == plan.automatic


# ---------------------------------------------------------------------------------------------------- similarities

NUMBERS = st.floats(-1, 1, allow_nan=False)


@given(NUMBERS, st.floats(0.3, 3), NUMBERS, NUMBERS)
def test_the_closest_similarity_of_a_similarity_is_itself(turn, scale, x, y):
    import cmath

    a = scale * cmath.exp(1j * turn * 3)
    matrix = ((a.real, -a.imag, 100 * x), (a.imag, a.real, 60 * y), (0.0, 0.0, 1.0))
    found = closest(matrix, (320, 180), (320, 180), 160 + 90j)
    back = found.scale * cmath.exp(-1j * found.rotation)  # Blender turns the other way: its y points up
    assert abs(back - a) < 1e-6 * scale
    middle = project(matrix, 159.5 + 89.5j)
    assert middle is not None
    assert abs(complex(found.offset_x, -found.offset_y) - (middle - (159.5 + 89.5j))) < 1e-6 * (1 + abs(middle))


def test_points_behind_the_horizon_do_not_count():
    steep = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.02, 0.0, 1.0))  # most of the programme comes from beyond infinity
    found = closest(steep, (320, 180), (320, 180), 20 + 90j)
    assert found.scale > 0
    assert abs(found.rotation) < 1


def test_a_camera_that_sees_past_the_programme_still_gets_a_transform():
    away = ((1.0, 0.0, 5000.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    assert closest(away, (320, 180), (320, 180), 160 + 90j).offset_x == pytest.approx(5000)


def test_fitting_keeps_the_shape():
    assert fitted((640, 480), (1920, 1080)) == Transform(0.0, 0.0, 2.25, 0.0)


@given(st.lists(NUMBERS, min_size=8, max_size=8))
def test_invert_is_the_inverse(values):
    a, b, c, d, e, f, g, h = values
    matrix = ((2 + a / 2, b / 2, 50 * c), (d / 2, 2 + e / 2, 50 * f), (g / 1000, h / 1000, 1.0))
    product = multiply(matrix, invert(matrix))
    for i in range(3):
        for j in range(3):
            assert product[i][j] == pytest.approx(float(i == j), abs=1e-9)


@given(
    st.lists(
        st.tuples(st.integers(0, 299), st.floats(-40, 40), st.floats(-40, 40)), max_size=4, unique_by=lambda k: k[0]
    ),
    st.integers(0, 250),
    st.integers(2, 150),
    st.booleans(),
    st.booleans(),
)
def test_the_keys_are_the_shift_of_the_exact_pictures_frame_by_frame(keys, start, length, by_hand, automatic):
    """Between the keys as Blender has it: held, or linear; a centre by hand eases in where there is no cut."""
    said = {"offset": (30.0, -12.0)} if by_hand else {"centering": False}
    override = Override(R(start, min(start + length, 300)), **said)
    edl = small_edl(centering=tuple(sorted(keys)), overrides=(override,), look=Look(centering=automatic))
    plan = make_plan(edl).centering
    exact = [shift_at(edl, decision, frame) for piece, decision in resolve(edl) for frame in piece]
    if not plan:
        assert not any(x or y for x, y in exact)
        return
    for frame, (dx, dy) in enumerate(exact):
        after = next((i for i, key in enumerate(plan) if key.frame > frame), len(plan))
        before, key = plan[max(after - 1, 0)], plan[min(after, len(plan) - 1)]
        part = 0 if before.hold or key.frame <= before.frame else (frame - before.frame) / (key.frame - before.frame)
        part = max(part, 0)
        x, y = before.x + part * (key.x - before.x), before.y + part * (key.y - before.y)
        assert (x, y) == pytest.approx((dx, -dy), abs=1e-6), frame
