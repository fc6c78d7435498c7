# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading the editor's decisions back: by example, and against an oracle that goes frame by frame."""

from __future__ import annotations

import attrs
import pytest
from builders import CAMERAS, small_edl, state_of
from hypothesis import given, settings
from hypothesis import strategies as st

from blender_addon.core.read_overrides import FoundStrip, SequencerState, read_overrides
from blender_addon.core.strip_plan import make_plan
from mcsl_core.edl import Edl, Look, Override, Shot, dumps
from mcsl_core.edl.resolve import resolve
from mcsl_core.errors import InputError
from mcsl_core.timing import FrameRange

R = FrameRange
CHANNEL = {"cam2": 2, "cam3": 3, "cam1": 4}  # the reference camera last
TOP = 5


def built(edl: Edl) -> SequencerState:
    return state_of(make_plan(edl))


def edit(state: SequencerState, index: int, **fields) -> SequencerState:
    strips = list(state.strips)
    strips[index] = attrs.evolve(strips[index], **fields)
    return attrs.evolve(state, strips=tuple(strips))


def added(state: SequencerState, *strips: FoundStrip) -> SequencerState:
    return attrs.evolve(state, strips=(*state.strips, *strips))


def test_changed_source_becomes_an_override():
    edl = small_edl()
    state = edit(built(edl), 1, source=CHANNEL["cam3"])
    assert read_overrides(edl, state) == (Override(R(100, 200), camera="cam3"),)


def test_split_and_switch_becomes_an_override():
    edl = small_edl()
    state = edit(built(edl), 1, stop=150)
    state = added(state, FoundStrip("shot-0000100", TOP, 150, 200, CHANNEL["cam1"]))  # a split copies the id
    assert read_overrides(edl, state) == (Override(R(150, 200), camera="cam1"),)


def test_moved_cut_becomes_an_override():
    edl = small_edl()
    state = edit(edit(built(edl), 0, stop=90), 1, start=90)
    assert read_overrides(edl, state) == (Override(R(90, 100), camera="cam2"),)


def test_a_stretch_across_automatic_cuts_is_one_override():
    edl = small_edl()
    state = added(built(edl), FoundStrip("mine", TOP + 1, 50, 250, CHANNEL["cam1"]))
    assert read_overrides(edl, state) == (Override(R(100, 250), camera="cam1"),)


def test_topmost_strip_wins_and_muted_ones_do_not_count():
    edl = small_edl()
    state = added(
        built(edl),
        FoundStrip("pushed", TOP + 1, 100, 160, CHANNEL["cam3"]),
        FoundStrip("off", TOP + 3, 0, 300, CHANNEL["cam2"], muted=True),
        FoundStrip("higher", TOP + 2, 140, 180, CHANNEL["cam1"]),
    )
    assert read_overrides(edl, state) == (
        Override(R(100, 140), camera="cam3"),
        Override(R(140, 180), camera="cam1"),
    )


def test_deleted_strip_is_no_decision():
    edl = small_edl(overrides=(Override(R(120, 150), camera="cam3", note="look here"),))
    state = built(edl)
    kept = tuple(s for s in state.strips if s.start != 120)
    assert read_overrides(edl, attrs.evolve(state, strips=kept)) == ()


def test_undone_override_disappears_and_its_other_fields_stay():
    edl = small_edl(overrides=(Override(R(120, 150), camera="cam3", centering=False, note="n"),))
    state = built(edl)
    index = next(i for i, s in enumerate(state.strips) if s.start == 120)
    state = edit(state, index, source=CHANNEL["cam2"])
    assert read_overrides(edl, state) == (Override(R(120, 150), centering=False, note="n"),)


def test_override_equal_to_the_automatic_choice_survives():
    edl = small_edl(overrides=(Override(R(120, 150), camera="cam2", note="pinned"),))
    state = edit(built(edl), -1, source=CHANNEL["cam1"])
    assert read_overrides(edl, state) == (edl.overrides[0], Override(R(200, 300), camera="cam1"))


def test_an_override_grows_and_shrinks_with_its_cuts():
    edl = small_edl(overrides=(Override(R(120, 150), camera="cam3", note="n"),))
    state = built(edl)
    at = next(i for i, s in enumerate(state.strips) if s.start == 120)
    moved = edit(edit(edit(state, at - 1, stop=110), at, start=110, stop=140), at + 1, start=140)
    assert read_overrides(edl, moved) == (Override(R(110, 140), camera="cam3", note="n"),)


def bridged(*overrides: Override) -> tuple[Override, ...]:
    """The overrides after the editor showed cam3 from 120 to 130 as well."""
    edl = small_edl(overrides=overrides)
    return read_overrides(edl, added(built(edl), FoundStrip("mine", TOP + 1, 120, 130, CHANNEL["cam3"])))


def test_two_overrides_become_one_where_the_editor_closes_the_stretch_between():
    before, after = Override(R(100, 120), camera="cam3"), Override(R(130, 150), camera="cam3")
    assert bridged(before, after) == (Override(R(100, 150), camera="cam3"),)
    noted = attrs.evolve(after, note="n")  # but no remark is lost
    assert bridged(before, noted) == (Override(R(100, 130), camera="cam3"), noted)
    other = Override(R(140, 160), camera="cam1")  # nor may a place in the list that decides
    assert bridged(before, other, after) == (Override(R(100, 130), camera="cam3"), other, after)


def test_an_override_that_hides_another_may_go_and_the_hidden_one_does_not_come_up():
    edl = small_edl(overrides=(Override(R(100, 200), camera="cam3"), Override(R(150, 200), camera="cam1")))
    state = built(edl)
    at = next(i for i, s in enumerate(state.strips) if s.start == 150)
    assert read_overrides(edl, edit(state, at, source=CHANNEL["cam2"])) == (Override(R(100, 150), camera="cam3"),)


def test_look_switches():
    edl = small_edl()
    state = edit(built(edl), 1, centering=False, fill=False)
    assert read_overrides(edl, state) == (Override(R(100, 200), centering=False, fill=False),)
    edl = attrs.evolve(edl, overrides=(Override(R(100, 200), centering=False, fill=False, note="n"),))
    state = edit(built(edl), 1, centering=True)  # back to what the whole programme has
    assert read_overrides(edl, state) == (Override(R(100, 200), fill=False, note="n"),)
    edl = small_edl(look=Look(centering=False))
    assert read_overrides(edl, edit(built(edl), 1, centering=True)) == (Override(R(100, 200), centering=True),)


def test_camera_and_look_of_one_stretch_are_one_override():
    edl = small_edl()
    state = edit(built(edl), 1, source=CHANNEL["cam3"], fill=False)
    assert read_overrides(edl, state) == (Override(R(100, 200), camera="cam3", fill=False),)


def test_a_channel_without_camera_is_named_with_strip_and_frame():
    edl = small_edl()
    with pytest.raises(InputError, match=r"strip 'shot-0000100', programme frame 100 .*channel 9.*no camera"):
        read_overrides(edl, edit(built(edl), 1, source=9))
    hidden = added(built(edl), FoundStrip("above", TOP + 1, 100, 200, CHANNEL["cam2"]))
    assert read_overrides(edl, edit(hidden, 1, source=9)) == ()  # what nobody sees does not matter


def test_cameras_gathered_in_one_channel_are_told_apart_by_time():
    edl = small_edl()
    state = built(edl)
    cameras = tuple(
        attrs.evolve(c, channel=2, start=0 if c.camera == "cam2" else 150, stop=150 if c.camera == "cam2" else 300)
        for c in state.cameras
        if c.camera != "cam1"
    )
    state = attrs.evolve(state, cameras=cameras, strips=(FoundStrip("all", TOP, 0, 300, 2),))
    assert read_overrides(edl, state) == (
        Override(R(0, 100), camera="cam2"),
        Override(R(150, 200), camera="cam3"),
    )


def test_an_older_timeline_does_not_undo_a_newer_analysis():
    old = small_edl()
    state = edit(built(old), 0, source=CHANNEL["cam2"])
    new = attrs.evolve(old, shots=(Shot(R(0, 300), "cam3"),))
    assert read_overrides(new, state) == (Override(R(0, 100), camera="cam2"),)


def test_a_timeline_of_another_length_is_refused():
    with pytest.raises(InputError, match="built for 300 frames, the EDL has 270"):
        read_overrides(small_edl(270), built(small_edl(300)))


# --------------------------------------------------------------------------------------------------- properties

FRAMES = 40


@st.composite
def stretches(draw) -> FrameRange:
    start = draw(st.integers(0, FRAMES - 1))
    return R(start, draw(st.integers(start + 1, FRAMES)))


@st.composite
def edls(draw) -> Edl:
    cuts = sorted(draw(st.sets(st.integers(1, FRAMES - 1), max_size=4)))
    shots = tuple(
        Shot(R(a, b), draw(st.sampled_from(CAMERAS))) for a, b in zip([0, *cuts], [*cuts, FRAMES], strict=True)
    )
    switch = st.none() | st.booleans()
    overrides = draw(
        st.lists(
            st.builds(
                Override,
                stretches(),
                st.none() | st.sampled_from(CAMERAS),
                switch,
                switch,
                switch,
                st.none() | st.just((5.0, -2.0)),
                st.sampled_from(("", "n")),
            ),
            max_size=4,
        )
    )
    return small_edl(FRAMES, shots=shots, overrides=tuple(overrides), look=Look(centering=draw(st.booleans())))


@st.composite
def edits(draw, edl: Edl) -> SequencerState:
    """Splits, other sources, shifted handles, muted and deleted and added strips, switches."""
    strips = list(built(edl).strips)
    for _ in range(draw(st.integers(0, 5))):
        kind = draw(st.sampled_from(("split", "source", "handle", "mute", "delete", "add", "look", "push")))
        if kind == "add" or not strips:
            piece, channel = draw(stretches()), draw(st.integers(TOP, TOP + 4))
            strips.append(
                FoundStrip("added", channel, piece.start, piece.stop, draw(st.sampled_from([*CHANNEL.values()])))
            )
            continue
        index = draw(st.integers(0, len(strips) - 1))
        strip = strips[index]
        match kind:
            case "split" if strip.stop - strip.start > 1:
                at = draw(st.integers(strip.start + 1, strip.stop - 1))
                strips[index] = attrs.evolve(strip, stop=at)
                strips.append(attrs.evolve(strip, start=at))
            case "source":
                strips[index] = attrs.evolve(strip, source=draw(st.sampled_from([*CHANNEL.values()])))
            case "handle":
                strips[index] = attrs.evolve(strip, stop=draw(st.integers(strip.start + 1, FRAMES + 5)))
            case "mute":
                strips[index] = attrs.evolve(strip, muted=True)
            case "delete":
                del strips[index]
            case "push":
                strips[index] = attrs.evolve(strip, channel=draw(st.integers(TOP, TOP + 4)))
            case "look":
                switch = st.none() | st.booleans()
                strips[index] = attrs.evolve(strip, centering=draw(switch), fill=draw(switch))
    return attrs.evolve(built(edl), strips=tuple(strips))


def seen(state: SequencerState, frame: int) -> FoundStrip | None:
    """The topmost strip at a frame; of two in one channel the later in the list (Blender allows no such thing)."""
    found = None
    for strip in state.strips:
        covers = strip.start <= frame < strip.stop and not strip.muted
        if covers and (found is None or strip.channel >= found.channel):
            found = strip
    return found


def decisions(edl: Edl) -> list:
    return [decision for piece, decision in resolve(edl) for _ in piece]


@settings(max_examples=120, deadline=None)
@given(edls())
def test_nothing_edited_gives_the_same_bytes(edl: Edl):
    assert dumps(attrs.evolve(edl, overrides=read_overrides(edl, built(edl)))) == dumps(edl)


@settings(max_examples=250, deadline=None)
@given(st.data())
def test_edits_come_back_exactly(data):
    edl = data.draw(edls())
    state = data.draw(edits(edl))
    new = attrs.evolve(edl, overrides=read_overrides(edl, state))
    before, after, automatic = decisions(edl), decisions(new), decisions(attrs.evolve(edl, overrides=()))
    camera = {channel: name for name, channel in CHANNEL.items()}
    for frame in range(FRAMES):
        strip = seen(state, frame)
        wanted = automatic[frame].camera if strip is None else camera[strip.source]
        assert after[frame].camera == wanted, frame
        for name in ("centering", "fill"):
            shown = None if strip is None else getattr(strip, name)
            assert getattr(after[frame], name) == (getattr(before[frame], name) if shown is None else shown)
        assert (after[frame].colour, after[frame].offset) == (before[frame].colour, before[frame].offset)
    same = [s for s in range(FRAMES) if seen(state, s) is not None and after[s] == before[s]]
    for override in edl.overrides:  # what the timeline still shows stays as it was
        if all(frame in same for frame in override.range):
            assert any(
                o.range.start <= override.range.start
                and o.range.stop >= override.range.stop
                and attrs.evolve(o, range=override.range) == override
                for o in new.overrides
            )
    again = attrs.evolve(state, strips=state.strips)
    assert read_overrides(new, again) == new.overrides  # reading twice decides nothing new


@settings(max_examples=120, deadline=None)
@given(st.data())
def test_without_older_overrides_they_are_the_maximal_stretches(data):
    edl = attrs.evolve(data.draw(edls()), overrides=())
    state = data.draw(edits(edl))
    state = attrs.evolve(state, strips=tuple(attrs.evolve(s, centering=None, fill=None) for s in state.strips))
    camera = {channel: name for name, channel in CHANNEL.items()}
    expected: list[Override] = []
    for frame, automatic in enumerate(decisions(edl)):
        strip = seen(state, frame)
        if strip is None or camera[strip.source] == automatic.camera:
            continue
        name = camera[strip.source]
        if expected and expected[-1].range.stop == frame and expected[-1].camera == name:
            expected[-1] = attrs.evolve(expected[-1], range=R(expected[-1].range.start, frame + 1))
        else:
            expected.append(Override(R(frame, frame + 1), camera=name))
    assert read_overrides(edl, state) == tuple(expected)
