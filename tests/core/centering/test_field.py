"""Centering keys: the bound on acceleration and what must not move."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcsl_core.centering.field import FieldCenterer, field_middle
from mcsl_core.centering.protocol import FieldPosition
from mcsl_core.edl.resolve import ACCELERATION, offset_at
from mcsl_core.timing import FrameRange

SIZE = (960, 540)


@st.composite
def programmes(draw):
    """Field positions that tile a programme, a picture's size and a rate."""
    size = draw(st.sampled_from([(320, 180), (960, 540), (1920, 1080), (3840, 2160)]))
    lengths = draw(st.lists(st.integers(1, 2000), min_size=1, max_size=8))
    starts = np.cumsum([0, *lengths]).tolist()
    middle = st.one_of(st.none(), st.tuples(st.floats(-100, size[0] + 100), st.floats(-100, size[1] + 100)))
    positions = [FieldPosition(FrameRange(a, b), draw(middle)) for a, b in zip(starts, starts[1:], strict=False)]
    return positions, size, draw(st.sampled_from([8.0, 25.0, 29.97, 60.0]))


def path_of(keys, frames):
    at, dx, dy = zip(*keys, strict=True) if keys else ((0,), (0,), (0,))
    path = np.stack([np.interp(range(frames), at, d) for d in (dx, dy)], axis=1)
    for frame in (0, frames // 2, frames - 1):
        assert offset_at(tuple(keys), frame) == pytest.approx(tuple(path[frame]))
    return path


@given(programmes())
def test_the_picture_never_jerks(programme):
    positions, size, rate = programme
    keys = FieldCenterer().centre(positions, size=size, rate=rate)
    frames = positions[-1].range.stop
    assert all(0 <= frame < frames for frame, _, _ in keys)
    assert all(a[0] < b[0] for a, b in zip(keys, keys[1:], strict=False))
    path = path_of(keys, frames)
    changes = np.abs(np.diff(path, n=2, axis=0))
    assert changes.max(initial=0) <= ACCELERATION * size[0] + 1e-6
    assert np.abs(path).max(initial=0) <= 0.25 * max(size)
    assert len(keys) <= 9 * len(positions)


@given(programmes())
def test_what_lies_near_the_middle_stays_and_nothing_is_shifted_more_than_it_must(programme):
    positions, size, rate = programme
    centerer = FieldCenterer()
    near = [p for p in positions if p.middle and _away(p.middle, size) <= centerer.near]
    if len(near) == sum(p.middle is not None for p in positions):
        assert all((dx, dy) == (0, 0) for _, dx, dy in centerer.centre(positions, size=size, rate=rate))
    if len(positions) == 1 and positions[0].middle:
        ((_, dx, dy),) = centerer.centre(positions, size=size, rate=rate)
        for extent, at, shift in zip(size, positions[0].middle, (dx, dy), strict=True):
            away = (extent - 1) / 2 - at
            left = abs(away - shift)
            assert abs(shift) <= abs(away)
            # By even whole pixels: up to two short of the least that brings it near.
            near = min(abs(away), centerer.near * extent) - 1e-6 <= left <= centerer.near * extent + 2
            assert near or abs(shift) > centerer.most * extent - 2


def _away(middle, size):
    return max(abs((extent - 1) / 2 - at) / extent for extent, at in zip(size, middle, strict=True))


def test_each_pose_is_centred_and_the_glide_lies_about_the_boundary():
    positions = [
        FieldPosition(FrameRange(0, 1000), (380.0, 270.0)),
        FieldPosition(FrameRange(1000, 2000), (700.0, 330.0)),
    ]
    keys = FieldCenterer().centre(positions, size=SIZE, rate=25.0)
    path = path_of(keys, 2000)
    assert path[0] == pytest.approx((99.5 - 48, 0.0), abs=2)
    assert path[-1] == pytest.approx((-220.5 + 48, -60.5 + 27), abs=2)
    glides = np.flatnonzero(np.abs(np.diff(path, axis=0)).max(axis=1) > 0)
    assert glides[0] + glides[-1] == pytest.approx(2000, abs=4)
    assert 50 < len(glides) < 400


def test_a_range_too_short_to_glide_to_keeps_its_neighbours_offset():
    positions = [
        FieldPosition(FrameRange(0, 1000), (380.0, 270.0)),
        FieldPosition(FrameRange(1000, 1020), (800.0, 270.0)),
        FieldPosition(FrameRange(1020, 2000), (380.0, 270.0)),
    ]
    assert len(FieldCenterer().centre(positions, size=SIZE, rate=25.0)) == 1


def test_the_middle_does_not_follow_a_hand_over_part_of_the_field():
    mask = np.zeros((54, 96), bool)
    mask[20:40, 30:70] = True
    whole = field_middle(mask, np.diag([10.0, 10, 1]))
    mask[20:40, 60:70] = False  # a quarter of it hidden, at one side: the middle moves by an eighth at most
    hidden = field_middle(mask, np.diag([10.0, 10, 1]))
    assert whole == pytest.approx((495, 295))
    assert abs(hidden[0] - whole[0]) <= 400 / 8
    assert field_middle(np.zeros((4, 4), bool), np.eye(3)) is None
