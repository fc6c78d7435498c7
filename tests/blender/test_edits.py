"""What an editor does in the sequencer comes back as exactly those overrides, and nothing else changes."""

from __future__ import annotations

import attrs
import pytest
from conftest import FRAMES, R, in_blender

from mcsl_core import edl as edls
from mcsl_core.decisions import carry_over
from mcsl_core.edl import Override, Shot
from mcsl_core.errors import InputError
from mcsl_core.timeline import build, pull

KEPT = Override(R(45, 50), camera="cam1", note="kept")


def after(built, blender, code):
    in_blender(blender, built, code)
    old = edls.load(built.parent / "edl.json")
    new = pull(built, blender=blender)
    assert attrs.evolve(new, overrides=old.overrides) == old  # nothing but the overrides
    assert edls.load(built.parent / "edl.json") == new
    return new.overrides


def test_nothing_edited_nothing_written(built, blender):
    path = built.parent / "edl.json"
    before, time = path.read_bytes(), path.stat().st_mtime_ns
    assert pull(built, blender=blender).overrides == (KEPT,)
    assert path.read_bytes() == before
    assert path.stat().st_mtime_ns == time


def test_changed_source_and_its_undoing(built, blender):
    assert after(built, blender, "at(5, 20).multicam_source = 3") == (KEPT, Override(R(20, 40), camera="cam3"))
    assert after(built, blender, "at(5, 20).multicam_source = 2") == (KEPT,)


def test_an_override_set_back_to_the_automatic_choice_goes(built, blender):
    assert after(built, blender, "at(5, 45).multicam_source = 3") == ()


def test_split_and_switch(built, blender):
    code = """
        right = at(5, 0).split(frame=12 + 1, split_method="SOFT")
        right.multicam_source = 2
        out = [right["mcsl_id"], at(5, 0)["mcsl_id"]]
    """
    assert after(built, blender, code) == (KEPT, Override(R(12, 20), camera="cam2"))


def test_blenders_own_multicam_split(built, blender):
    code = """
        strip = at(5, 20)
        scene.sequence_editor.active_strip = strip
        scene.frame_set(30 + 1)
        for s in strips: s.select = s == strip
        bpy.ops.sequencer.split_multicam(camera=4)
    """
    assert after(built, blender, code) == (KEPT, Override(R(30, 40), camera="cam1"))


def test_moved_cut(built, blender):
    assert after(built, blender, "cut(at(5, 0), 0, 15); cut(at(5, 20), 15, 40)") == (
        KEPT,
        Override(R(15, 20), camera="cam2"),
    )


def test_a_handle_over_a_neighbour_sends_it_to_another_channel(built, blender):
    code = """
        first, second = at(5, 0), at(5, 20)
        cut(first, 0, 26)
        out = [first.channel, second.channel]
    """
    overrides = after(built, blender, code)
    # whichever of the two Blender pushed up is on top and wins where they overlap
    assert overrides in ((KEPT,), (KEPT, Override(R(20, 26), camera="cam1")))


def test_added_deleted_and_muted(built, blender):
    code = """
        new = dict(length=8) if bpy.app.version >= (5, 0) else dict(frame_end=2 + 8 + 1)
        extra = strips.new_effect(name="mine", type="MULTICAM", channel=9, frame_start=2 + 1, **new)
        extra.multicam_source = 3
        at(5, 45).mute = True
        at(5, 20).multicam_source = 4
        strips.remove(at(5, 20))
    """
    assert after(built, blender, code) == (Override(R(2, 10), camera="cam3"),)


def test_look_switches_of_a_strip(built, blender):
    code = 'at(5, 20)["mcsl_centering"] = False; at(5, 20)["mcsl_fill"] = True'
    assert after(built, blender, code) == (KEPT, Override(R(20, 40), centering=False))
    assert after(built, blender, 'at(5, 20)["mcsl_centering"] = True') == (KEPT,)


def test_a_renamed_scene_is_found(built, blender):
    assert after(built, blender, 'scene.name = "Finale"; at(5, 0).multicam_source = 2') == (
        KEPT,
        Override(R(0, 20), camera="cam2"),
    )


def test_a_source_without_camera_is_refused_and_nothing_written(built, blender):
    in_blender(blender, built, "at(5, 20).multicam_source = 12")
    before = (built.parent / "edl.json").read_bytes()
    with pytest.raises(InputError, match=r"strip 'shot 2', programme frame 20 .*channel 12, which holds no camera"):
        pull(built, blender=blender)
    assert (built.parent / "edl.json").read_bytes() == before


def test_a_multicam_strip_in_a_meta_strip_is_refused(built, blender):
    code = """
        meta = strips.new_meta(name="group", channel=10, frame_start=1)
        at(5, 20).move_to_meta(meta)
    """
    in_blender(blender, built, code)
    with pytest.raises(InputError, match="inside a meta strip"):
        pull(built, blender=blender)


def test_analysing_again_keeps_the_decisions_and_an_old_timeline_adds_no_others(built, blender):
    in_blender(blender, built, "at(5, 20).multicam_source = 3")
    path = built.parent / "edl.json"
    old = pull(built, blender=blender)
    again = attrs.evolve(old, shots=(Shot(R(0, 33), "cam2"), Shot(R(33, FRAMES), "cam1")), overrides=())
    edls.save(carry_over(old, again), path)
    assert pull(built, blender=blender).overrides == old.overrides
    build(path, built, blender=blender)
    assert pull(built, blender=blender).overrides == old.overrides
