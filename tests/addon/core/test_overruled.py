"""Cameras that others chose and an older timeline takes back are told by frame; nothing else is."""

from __future__ import annotations

import attrs
import pytest
from builders import small_edl, state_of

from blender_addon.core.overruled import overruled
from blender_addon.core.read_overrides import read_edl
from blender_addon.core.strip_plan import make_plan
from mcsl_core.edl import Override
from mcsl_core.edl.resolve import resolve
from mcsl_core.timing import FrameRange


def other_camera(edl, frame: int) -> str:
    shown = next(d.camera for s, d in resolve(edl) if frame in s)
    return next(c.name for c in edl.cameras if c.name != shown)


def test_a_camera_chosen_elsewhere_is_told_where_the_timeline_shows_another():
    edl = small_edl()
    camera = other_camera(edl, 10)
    now = attrs.evolve(edl, overrides=(*edl.overrides, Override(FrameRange(10, 14), camera=camera)))
    new = read_edl(now, state_of(make_plan(edl)))
    assert new.overrides == edl.overrides, "the timeline's choice is taken"
    (note,) = overruled(now, new, len(edl.overrides))
    assert note.startswith(f"programme frames 11 to 14: {camera}, decided elsewhere since")


def test_many_are_counted():
    edl = small_edl()
    pieces = [FrameRange(2 * n, 2 * n + 1) for n in range(6)]
    since = tuple(Override(piece, camera=other_camera(edl, piece.start)) for piece in pieces)
    now = attrs.evolve(edl, overrides=(*edl.overrides, *since))
    notes = overruled(now, read_edl(now, state_of(make_plan(edl))), len(edl.overrides))
    assert len(notes) == 4
    assert notes[-1] == "and 3 more stretches that were decided elsewhere"


@pytest.mark.parametrize("known", [None, "three", 1 << 40, -5])
def test_a_timeline_in_line_with_its_edl_and_odd_counts_say_nothing(known):
    edl = small_edl()
    new = read_edl(edl, state_of(make_plan(edl)))
    assert overruled(edl, new, known) == ()


def test_what_the_editor_takes_back_himself_is_not_told():
    """The override was there when the timeline was brought in line; another camera there is his decision."""
    edl = small_edl()
    now = attrs.evolve(edl, overrides=(*edl.overrides, Override(FrameRange(10, 14), camera=other_camera(edl, 10))))
    new = read_edl(now, state_of(make_plan(edl)))
    assert overruled(now, new, len(now.overrides)) == ()
    light = attrs.evolve(edl, overrides=(*edl.overrides, Override(FrameRange(10, 14), fill=False)))
    assert overruled(light, read_edl(light, state_of(make_plan(edl))), len(edl.overrides)) == ()
