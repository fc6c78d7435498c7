"""Removing and bringing back, against sets of frames."""

import pytest
from builders import R, small
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import edls, ranges

from mcsl_core.edl import dumps, from_json, loads, to_json
from mcsl_core.edl.edits import carry_over, merged
from mcsl_core.edl.removal import bring_back, delivered, delivered_frames, remove
from mcsl_core.errors import DocumentError, Fault


def frames_of(pieces):
    return {frame for piece in pieces for frame in piece}


@given(edls(), st.data())
def test_removing_and_bringing_back_are_those_of_sets(edl, data):
    piece = data.draw(ranges(edl.frames))
    was = frames_of(edl.removed)
    assert frames_of(delivered(edl, piece)) == set(piece) - was
    back = bring_back(edl, piece)
    assert frames_of(back.removed) == was - set(piece)
    assert bring_back(edl).removed == ()
    if was | set(piece) == set(range(edl.frames)):
        with pytest.raises(Fault, match="nothing would be delivered"):
            remove(edl, piece)
        return
    made = remove(edl, piece)
    assert frames_of(made.removed) == was | set(piece)
    assert all(a.stop < b.start for a, b in zip(made.removed, made.removed[1:], strict=False))


@given(edls())
def test_delivered_frames_are_those_that_are_left(edl):
    left = [n for n in range(edl.frames) if n not in frames_of(edl.removed)]
    assert delivered_frames(edl) == len(left)


def test_analysis_keeps_it_and_refuses_what_it_cannot_keep():
    old = small(removed=(R(50, 80),), audio_from="cam2")
    assert carry_over(old, small()).removed == old.removed
    assert carry_over(old, small()).audio_from == "cam2"
    with pytest.raises(DocumentError, match=r"removed\[0\] ends at frame 80"):
        carry_over(old, small(frames=60))


@pytest.mark.parametrize(
    ("removed", "fault"),
    [([[0, 5], [4, 9]], r"removed\[1\].*begins before"), ([[0, 9999999]], r"removed\[0\].*ends after")],
)
def test_a_wrong_one_is_refused_at_its_path(removed, fault):
    with pytest.raises(DocumentError, match=fault):
        from_json({**to_json(small()), "removed": removed})


def test_what_two_removed_is_a_conflict_and_what_one_did_is_kept():
    base = small()
    assert merged(base, remove(base, R(3, 9)), base).removed == (R(3, 9),)
    assert merged(base, base, remove(base, R(3, 9))).removed == (R(3, 9),)


@given(edls())
def test_it_is_written_and_read(edl):
    assume(edl.removed)
    assert loads(dumps(edl)).removed == edl.removed
