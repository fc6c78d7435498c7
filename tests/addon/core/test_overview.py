"""Overrides seen from afar."""

from __future__ import annotations

from builders import R
from hypothesis import given
from hypothesis import strategies as st

from blender_addon.core.overview import LEAST_PX, marks


@given(
    starts=st.lists(st.integers(0, 10_000), unique=True, max_size=30).map(sorted),
    scale=st.floats(0.001, 5),
    left=st.floats(-5_000, 100),
)
def test_every_override_in_the_window_is_under_a_mark_that_can_be_seen(starts, scale, left):
    pieces = [R(start, start + 1) for start in starts]
    found = marks(pieces, left, scale, 1200)
    assert all(end - begin > LEAST_PX - 1e-6 for begin, end in found)
    assert all(a[1] < b[0] for a, b in zip(found, found[1:], strict=False))
    for piece in pieces:
        middle = left + (piece.start + 0.5) * scale
        if 0 <= middle <= 1200:
            assert any(begin <= middle <= end for begin, end in found)
    assert marks(pieces, 1300, scale, 1200) == []
