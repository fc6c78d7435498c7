# SPDX-License-Identifier: GPL-3.0-or-later
"""What a camera's key does at the playhead, and which strips bear an override's colour."""

from __future__ import annotations

import attrs
import pytest
from builders import CAMERAS, small_edl, state_of
from hypothesis import given, settings
from hypothesis import strategies as st

from blender_addon.core.multicam import (
    Switch,
    deciding,
    muted_over,
    overridden,
    replaced,
    shown_cameras,
    switch,
    through_edits,
    with_names,
)
from blender_addon.core.read_overrides import AUTOMATIC, FoundStrip, SequencerState, read_edl
from blender_addon.core.strip_plan import make_plan
from mcsl_core.edl import Edl, Override
from mcsl_core.edl.resolve import resolve
from mcsl_core.errors import InputError
from mcsl_core.timing import FrameRange

R = FrameRange
CHANNEL = {"cam2": 2, "cam3": 3, "cam1": 4}
TOP = 5


def built(edl: Edl) -> SequencerState:
    return state_of(make_plan(edl))


def marked(edl: Edl, state: SequencerState) -> frozenset[str]:
    return overridden(resolve(read_edl(edl, state)), state.strips)


def done(state: SequencerState, change: Switch | None) -> SequencerState:
    """The sequencer after the change, as Blender does it: a split leaves the right part with a name of its own."""
    if change is None:
        return state
    strips = []
    for strip in state.strips:
        if strip.name == change.name and change.split is not None:
            strips.append(attrs.evolve(strip, stop=change.split))
            strip = attrs.evolve(strip, name=f"{strip.name}.{change.split}", start=change.split)
            strips.append(attrs.evolve(strip, source=change.source))
        else:
            strips.append(attrs.evolve(strip, source=change.source) if strip.name == change.name else strip)
    return attrs.evolve(state, strips=tuple(strips))


def test_a_key_cuts_at_the_playhead_and_switches_the_rest_of_the_shot():
    edl = small_edl()
    assert switch(built(edl), 130, "cam3") == Switch("shot-0000100", CHANNEL["cam3"], 130)
    new = read_edl(edl, done(built(edl), switch(built(edl), 130, "cam3")))
    assert new.overrides == (Override(R(130, 200), camera="cam3"),)


def test_on_a_shots_first_frame_nothing_is_cut_and_whole_cuts_nowhere():
    assert switch(built(small_edl()), 100, "cam3") == Switch("shot-0000100", 3, None)
    assert switch(built(small_edl()), 199, "cam3", whole=True) == Switch("shot-0000100", 3, None)


def test_what_is_shown_already_changes_nothing():
    assert switch(built(small_edl()), 130, "cam2") is None


def test_the_topmost_strip_that_is_not_muted_is_the_shot():
    state = built(small_edl())
    above = FoundStrip("mine", TOP + 2, 120, 140, CHANNEL["cam1"])
    muted = FoundStrip("off", TOP + 3, 0, 300, CHANNEL["cam1"], muted=True)
    state = attrs.evolve(state, strips=(*state.strips, above, muted))
    found = [deciding(state.strips, frame) for frame in (119, 120, 139, 140)]
    assert [strip.name for strip in found if strip] == ["shot-0000100", "mine", "mine", "shot-0000100"]
    assert switch(state, 130, "cam3") == Switch("mine", 3, 130)


def test_where_only_muted_strips_lie_no_shot_shows_and_the_topmost_is_named():
    state = built(small_edl())
    strips = [attrs.evolve(s, muted=s.start == 100) for s in state.strips]
    strips.append(FoundStrip("mine", TOP + 2, 120, 140, CHANNEL["cam1"]))
    strips.append(FoundStrip("off", TOP + 3, -10, 110, CHANNEL["cam1"], muted=True))
    assert muted_over(strips, [R(90, 300)]) == (
        (R(100, 110), "off"),
        (R(110, 120), "shot-0000100"),
        (R(140, 200), "shot-0000100"),
    )
    assert muted_over(state.strips, [R(0, 300)]) == ()


def test_without_a_shot_or_a_strip_of_the_camera_it_says_so():
    state = built(small_edl())
    gone = attrs.evolve(state, strips=tuple(s for s in state.strips if s.start != 100))
    with pytest.raises(InputError, match="no shot at the playhead"):
        switch(gone, 130, "cam3")
    with pytest.raises(InputError, match="no shot at the playhead"):
        switch(state, 300, "cam3")
    with pytest.raises(InputError, match="cam6 has no strip in this timeline"):
        switch(state, 130, "cam6")
    low = attrs.evolve(state, strips=(FoundStrip("low", 3, 0, 300, 2),))
    with pytest.raises(InputError, match="cam1 lies on channel 4, above the shot's own 3"):
        switch(low, 130, "cam1")


def test_a_camera_moved_to_another_channel_is_found_there():
    state = built(small_edl())
    parts = [c for c in state.cameras if c.camera == "cam3"]
    others = tuple(c for c in state.cameras if c.camera != "cam3")
    split = (attrs.evolve(parts[0], stop=150), attrs.evolve(parts[0], start=160, channel=1))
    state = attrs.evolve(state, cameras=(*others, *split))
    sources = {frame: change.source for frame in (120, 149, 153, 157, 160) if (change := switch(state, frame, "cam3"))}
    assert sources == {120: 3, 149: 3, 153: 3, 157: 1, 160: 1}  # in its pause the nearer piece


def test_strips_are_told_by_the_camera_they_show():
    state = built(small_edl())
    odd = FoundStrip("odd", TOP + 1, 0, 10, 9)
    state = attrs.evolve(state, strips=(*state.strips, odd))
    assert shown_cameras(state) == {"shot-0000000": "cam1", "shot-0000100": "cam2", "shot-0000200": "cam3"}


def test_the_colour_goes_with_what_pulling_would_write():
    edl = small_edl(overrides=(Override(R(120, 150), camera="cam3"), Override(R(210, 220), fill=False)))
    state = built(edl)
    assert marked(edl, state) == {"shot-0000120", "shot-0000210"}
    back = attrs.evolve(
        state, strips=tuple(attrs.evolve(s, source=2) if s.name == "shot-0000120" else s for s in state.strips)
    )
    assert marked(edl, back) == {"shot-0000210"}
    centred = attrs.evolve(
        state, strips=tuple(attrs.evolve(s, offset=(3.0, -4.0)) if s.start == 0 else s for s in state.strips)
    )
    assert marked(edl, centred) == {"shot-0000000", "shot-0000120", "shot-0000210"}
    odd = attrs.evolve(state, strips=(attrs.evolve(state.strips[0], source=9), *state.strips[1:]))
    with pytest.raises(InputError, match="channel 9, which holds no camera"):
        marked(edl, odd)


def test_a_centre_by_hand_is_an_override_until_it_is_automatic_again():
    edl = small_edl()
    state = built(edl)

    def said(offset) -> SequencerState:
        first, *rest = state.strips
        return attrs.evolve(state, strips=(attrs.evolve(first, offset=offset), *rest))

    by_hand = read_edl(edl, said((12.5, -8.0)))
    assert by_hand.overrides == (Override(R(0, 100), offset=(12.5, -8.0)),)
    keys = make_plan(by_hand).centering
    assert [(k.frame, k.x, k.y, k.hold) for k in keys[:1]] == [(0, 12.5, 8.0, True)]
    assert [(k.frame, k.x, k.y) for k in keys[1:]][:1] == [(100, 0.0, 0.0)]
    assert read_edl(by_hand, said((12.5, -8.0))) == by_hand
    assert read_edl(by_hand, said(None)) == by_hand
    assert read_edl(by_hand, said(AUTOMATIC)) == edl
    assert read_edl(edl, said(AUTOMATIC)) == edl


@settings(max_examples=150, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 299), st.sampled_from(CAMERAS), st.booleans()), max_size=8))
def test_pressing_keys_is_the_same_as_cutting_frame_by_frame(presses):
    edl = small_edl()
    state = built(edl)
    wanted = [decision.camera for piece, decision in resolve(edl) for _ in piece]
    for frame, camera, whole in presses:
        shot = deciding(state.strips, frame)
        assert shot is not None
        state = done(state, switch(state, frame, camera, whole=whole))
        start = shot.start if whole else frame
        wanted[start : shot.stop] = [camera] * (shot.stop - start)
    new = read_edl(edl, state)
    assert [decision.camera for piece, decision in resolve(new) for _ in piece] == wanted
    differs = [a != b for a, b in zip(wanted, (d.camera for p, d in resolve(edl) for _ in p), strict=True)]
    yellow = marked(edl, state)
    for strip in state.strips:
        assert (strip.name in yellow) == any(differs[strip.start : strip.stop])


def strip(name: str, start: int, stop: int, source: int = 3, **said) -> FoundStrip:
    return FoundStrip(name, said.pop("channel", TOP), start, stop, source, **said)


def test_cuts_that_nobody_sees_are_those_between_strips_that_say_the_same():
    strips = [
        strip("c", 20, 30),
        strip("a", 0, 10),
        strip("b", 10, 20),
        strip("other camera", 30, 40, source=4),
        strip("other look", 40, 50, source=4, fill=False),
        strip("same look", 50, 60, source=4, fill=False),
        strip("after a gap", 70, 80, source=4, fill=False),
        strip("above", 80, 90, source=4, fill=False, channel=TOP + 1),
    ]
    assert through_edits(strips) == (("a", "b", "c"), ("other look", "same look"))
    assert through_edits(strips, {"b"}) == (("other look", "same look"),)
    assert through_edits([attrs.evolve(s, muted=True) for s in strips]) == ()


@settings(max_examples=30, deadline=None)
@given(frames=st.lists(st.integers(1, 299), unique=True, max_size=8))
def test_joined_a_timeline_decides_what_it_decided(frames):
    edl = small_edl()
    state = built(edl)
    for frame in frames:
        at = deciding(state.strips, frame)
        assert at is not None
        if at.start < frame:
            state = done(state, Switch(at.name, at.source, frame))
    groups = through_edits(state.strips)
    by_name = {s.name: s for s in state.strips}
    kept = [attrs.evolve(by_name[g[0]], stop=by_name[g[-1]].stop) for g in groups]
    gone = {name for group in groups for name in group}
    joined = attrs.evolve(state, strips=(*(s for s in state.strips if s.name not in gone), *kept))
    assert read_edl(edl, joined) == read_edl(edl, state) == edl
    assert len(joined.strips) == len(edl.shots)


def test_a_cut_in_what_was_read_is_what_is_read_after_it():
    state = built(small_edl())
    was = state.strips[1]
    left, right = attrs.evolve(was, stop=150), attrs.evolve(was, name="right", start=150, source=4)
    after = replaced(state, was, [right, left])
    assert after is not None
    assert [s.start for s in after.strips] == [0, 100, 150, 200]
    assert (after.strips[1], after.strips[2]) == (left, right)
    assert with_names(after, {"right": "new"}).strips[2] == attrs.evolve(right, name="new")
    assert with_names(after, {}) is after
    assert replaced(state, attrs.evolve(was, source=9), [left]) is None  # others have changed it since
    assert replaced(state, attrs.evolve(was, name="gone"), [left]) is None
