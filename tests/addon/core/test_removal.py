# SPDX-License-Identifier: GPL-3.0-or-later
"""Marks over what is removed, read frame by frame against what the EDL had when they were laid."""

from __future__ import annotations

import attrs
import pytest
from blender_recording import FRAMES, R, an_edl
from hypothesis import given
from hypothesis import strategies as st

from blender_addon.core.removal import FoundRemoval, chosen, from_text, take_removal, to_text
from mcsl_core.errors import InputError
from mcsl_core.timing import ranges_of

SOME = st.sets(st.integers(0, FRAMES - 1), max_size=FRAMES - 1)


@given(SOME, SOME, SOME)
def test_each_frame_is_as_whoever_changed_it_last_says(has, upon, marked):
    edl = an_edl(removed=tuple(ranges_of(has)))
    found = FoundRemoval(tuple(ranges_of(marked)), tuple(ranges_of(upon)))
    wanted = {n for n in range(FRAMES) if (n in marked if (n in marked) != (n in upon) else n in has)}
    if len(wanted) == FRAMES:
        with pytest.raises(InputError, match="nothing is left"):
            take_removal(edl, found)
    else:
        assert take_removal(edl, found) == tuple(ranges_of(wanted))


@given(SOME)
def test_marks_as_they_were_laid_say_just_what_the_edl_says(has):
    edl = an_edl(removed=tuple(ranges_of(has)))
    assert take_removal(edl, FoundRemoval(edl.removed, edl.removed)) == edl.removed


@pytest.mark.parametrize(
    ("frame", "preview", "selected", "meant"),
    [
        (25, (10, 12), [(40, 45)], (R(10, 12),)),  # the preview range goes first
        (25, (-5, 3), [], (R(0, 3),)),
        (25, (FRAMES, FRAMES + 9), [], ()),
        (25, None, [(40, 45), (45, FRAMES + 9), (-9, 0)], (R(40, FRAMES),)),
        (25, None, [], (R(20, 40),)),  # the shot at the playhead
        (46, None, [], (R(45, 50),)),  # which is an override's
        (FRAMES, None, [], ()),
    ],
)
def test_what_is_meant_is_the_preview_range_the_selected_shots_or_the_one_at_the_playhead(
    frame, preview, selected, meant
):
    assert chosen(an_edl(), frame, preview, selected) == meant


def test_a_mark_may_reach_outside_the_programme():
    assert take_removal(an_edl(), FoundRemoval((R(50, FRAMES + 20),))) == (R(50, FRAMES),)
    assert take_removal(an_edl(), FoundRemoval((R(FRAMES, FRAMES + 20),))) == ()


def test_what_another_removed_since_an_older_timeline_was_built_stays_removed():
    assert take_removal(attrs.evolve(an_edl(), removed=(R(3, 9),)), FoundRemoval()) == (R(3, 9),)


@given(SOME)
def test_the_scenes_text_gives_the_ranges_back(has):
    pieces = tuple(ranges_of(has))
    assert from_text(to_text(pieces)) == pieces
