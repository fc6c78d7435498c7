# SPDX-License-Identifier: GPL-3.0-or-later
"""Marks on the timeline over what is removed: laid from the EDL, the editor's to change, and back in the EDL."""

from __future__ import annotations

import attrs
import pytest
from blender_recording import FRAMES, SWITCH_ON, R, in_blender
from notes import Notes

from mcsl_core import edl as edls
from mcsl_core.blender.child import run_task
from mcsl_core.blender.messages import RefreshRequest
from mcsl_core.blender.timeline import build_timeline, pull_overrides
from mcsl_core.errors import InputError

REMOVED = (R(7, 22), R(50, FRAMES))
MARKS = """
marks = sorted((s for s in strips if s.get("mcsl") == "removed"), key=span)
def spans(): return sorted(span(s) for s in strips if s.get("mcsl") == "removed")
def right(): return marks[0].split(frame=12 + 1, split_method="SOFT")
"""


@pytest.fixture
def marked(built, blender):
    """The timeline of an EDL with two removed stretches."""
    path = built.parent / "edl.json"
    edls.save(attrs.evolve(edls.load(path), removed=REMOVED), path)
    build_timeline(path, built, blender=blender, force=True)
    return built


def removed(blend, blender):
    """What is removed after a pull, of which the EDL has changed nothing else."""
    old = edls.load(blend.parent / "edl.json")
    new = pull_overrides(blend, blender=blender)
    assert attrs.evolve(new, removed=old.removed) == old
    return new.removed


@pytest.mark.both_blenders
def test_untouched_they_give_the_same_edl_to_the_byte(marked, blender):
    path = marked.parent / "edl.json"
    before = path.read_bytes()
    code = MARKS + "out = [spans(), len({s.channel for s in marks}), max(s.channel for s in strips)]"
    spans, channels, top = in_blender(blender, marked, code)
    assert spans == [[7, 22], [50, 60]]
    assert (channels, top) == (1, 8)  # over everything
    assert removed(marked, blender) == REMOVED
    assert path.read_bytes() == before


@pytest.mark.both_blenders
@pytest.mark.parametrize(
    ("code", "expected"),
    [
        ("cut(marks[0], 9, 30)", (R(9, 30), R(50, FRAMES))),
        ("strips.remove(marks[0])", (R(50, FRAMES),)),
        ("marks[1].mute = True", (R(7, 22),)),
        ("right()", REMOVED),
        ("strips.remove(right())", (R(7, 12), REMOVED[1])),
        ("cut(marks[1], 40, 90)", (R(7, 22), R(40, FRAMES))),
    ],
)
def test_what_the_editor_does_to_marks_is_read(marked, blender, code, expected):
    in_blender(blender, marked, MARKS + code)
    assert removed(marked, blender) == expected


def test_a_timeline_without_a_programme_left_is_refused(marked, blender):
    in_blender(blender, marked, MARKS + "cut(marks[0], 0, 50)")
    with pytest.raises(InputError, match="nothing is left to deliver"):
        pull_overrides(marked, blender=blender)


def test_what_another_removes_meanwhile_stays_and_appears(marked, blender):
    """Pulled from a timeline that does not know of it; the next refresh marks it."""
    path = marked.parent / "edl.json"
    edls.save(attrs.evolve(edls.load(path), removed=(R(30, 35), R(50, FRAMES))), path)
    in_blender(blender, marked, MARKS + "cut(marks[0], 2, 22)")
    assert removed(marked, blender) == (R(2, 7), R(30, 35), R(50, FRAMES))
    run_task(blender, RefreshRequest(edl=path, blend=marked, conformed=(), sound=None), Notes())
    assert in_blender(blender, marked, MARKS + "out = spans()") == [[2, 7], [30, 35], [50, 60]]
    assert removed(marked, blender) == (R(2, 7), R(30, 35), R(50, FRAMES))


def test_an_editors_strip_above_keeps_its_place_under_the_marks(built, blender):
    """The EDL's removal comes later than his title."""
    code = """
        end = {"length": 10} if bpy.app.version >= (5, 0, 0) else {"frame_end": 11}
        strips.new_effect(name="title", type="TEXT", channel=8, frame_start=1, **end)
    """
    in_blender(blender, built, code)
    path = built.parent / "edl.json"
    edls.save(attrs.evolve(edls.load(path), removed=REMOVED), path)
    run_task(blender, RefreshRequest(edl=path, blend=built, conformed=(), sound=None), Notes())
    code = MARKS + "out = [[s.channel for s in marks], strips['title'].channel]"
    assert in_blender(blender, built, code) == [[9, 9], 8]


PANEL = (
    SWITCH_ON
    + MARKS.replace("\n", "\n    ")
    + """
    from blender_addon.ui import refresh
    from blender_addon.ui.operators.timeline import pull
    def edl_has(): return [[p.start, p.stop] for p in refresh.decided(scene).removed]
"""
)


def test_what_was_removed_elsewhere_is_marked_at_the_next_look_and_survives_the_panels_pull(built, blender):
    path = built.parent / "edl.json"
    edls.save(attrs.evolve(edls.load(path), removed=REMOVED), path)
    code = """
    refresh.refresh_timeline(scene)
    out = [spans(), [edl_has() for _ in range(2) if pull(scene)]]
    """
    wanted = [[7, 22], [50, FRAMES]]
    assert in_blender(blender, built, PANEL + code) == [wanted, [wanted, wanted]]
    assert edls.load(path).removed == REMOVED


def test_what_was_brought_back_elsewhere_loses_its_mark(marked, blender):
    path = marked.parent / "edl.json"
    edls.save(attrs.evolve(edls.load(path), removed=(R(50, FRAMES),)), path)
    code = "\n    refresh.refresh_timeline(scene)\n    out = [spans(), edl_has()]"
    assert in_blender(blender, marked, PANEL + code) == [[[50, FRAMES]], [[50, FRAMES]]]


def test_a_mark_that_begins_before_the_programme_is_one_all_the_same(marked, blender):
    code = """
    cut(marks[0], -20, 9)
    refresh.refresh_timeline(scene)
    before = edl_has()
    scene.use_preview_range = True
    scene.frame_preview_start, scene.frame_preview_end = 1, 4
    done = bpy.ops.mcsl.bring_back() == {"FINISHED"}
    out = [before, done, edl_has()]
    """
    assert in_blender(blender, marked, PANEL + code) == [[[0, 9], [50, FRAMES]], True, [[4, 9], [50, FRAMES]]]


@pytest.mark.parametrize("channels", [(128,), (6, 128)], ids=["for marks", "for the editor's strips"])
def test_where_channels_do_not_suffice_nothing_is_changed(marked, blender, channels):
    """Marks need a channel above all strips, strips on our channels have to move up with all that lie above them."""
    path = marked.parent / "edl.json"
    code = f"""
    from pathlib import Path
    from blender_addon.core.strip_plan import make_plan
    from blender_addon.sequencer.renew import rebuild_timeline
    from mcsl_core import edl as edls
    from mcsl_core.errors import InputError
    from mcsl_core.timing import FrameRange
    import attrs
    def listing(): return sorted([s.name, s.channel, *span(s), s.mute] for s in strips)
    for channel in {channels}:
        strips.new_effect(name=f"mine {{channel}}", type="COLOR", channel=channel, frame_start=1, **(
            {{"length": 10}} if bpy.app.version >= (5, 0, 0) else {{"frame_end": 11}}))
    edl = edls.load(Path({str(path)!r}))
    more = attrs.evolve(edl, removed=(FrameRange(5, 30), *edl.removed[1:]))
    before, keys, said = listing(), dict(scene), ""
    try: rebuild_timeline(scene, make_plan(more), Path({str(path.parent)!r}))
    except InputError as error: said = str(error)
    out = [said, before == listing(), keys == dict(scene)]
    """
    said, same, properties = in_blender(blender, marked, SWITCH_ON + code, save=False)
    assert "has no channel left above" in said
    assert (same, properties) == (True, True)
