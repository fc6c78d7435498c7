"""What an editor does in the sequencer comes back as exactly those overrides, and nothing else changes."""

from __future__ import annotations

import attrs
import pytest
from blender_recording import FRAMES, R, in_blender
from notes import Notes

from mcsl_core import edl as edls
from mcsl_core.blender.child import run_task
from mcsl_core.blender.messages import RefreshRequest
from mcsl_core.blender.timeline import build_timeline, pull_overrides
from mcsl_core.edl import IDENTITY, Override, Shot
from mcsl_core.edl.edits import carry_over
from mcsl_core.errors import InputError

KEPT = Override(R(45, 50), camera="cam1", note="kept")


def after(built, blender, code):
    in_blender(blender, built, code)
    old = edls.load(built.parent / "edl.json")
    new = pull_overrides(built, blender=blender)
    assert attrs.evolve(new, overrides=old.overrides) == old  # nothing but the overrides
    assert edls.load(built.parent / "edl.json") == new
    return new.overrides


def test_nothing_edited_nothing_written(built, blender):
    path = built.parent / "edl.json"
    before, time = path.read_bytes(), path.stat().st_mtime_ns
    assert pull_overrides(built, blender=blender).overrides == (KEPT,)
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
    with pytest.raises(InputError, match=r"strip '2: cam2 \[2\]', programme frame 20 .*channel 12, which holds no"):
        pull_overrides(built, blender=blender)
    assert (built.parent / "edl.json").read_bytes() == before


def test_a_multicam_strip_in_a_meta_strip_is_refused(built, blender):
    code = """
        meta = strips.new_meta(name="group", channel=10, frame_start=1)
        at(5, 20).move_to_meta(meta)
    """
    in_blender(blender, built, code)
    with pytest.raises(InputError, match="inside a meta strip"):
        pull_overrides(built, blender=blender)


def test_analysing_again_keeps_the_decisions_and_an_old_timeline_adds_no_others(built_here, blender):
    in_blender(blender, built_here, "at(5, 20).multicam_source = 3")
    path = built_here.parent / "edl.json"
    old = pull_overrides(built_here, blender=blender)
    again = attrs.evolve(old, shots=(Shot(R(0, 33), "cam2"), Shot(R(33, FRAMES), "cam1")), overrides=())
    edls.save(carry_over(old, again), path)
    assert pull_overrides(built_here, blender=blender).overrides == old.overrides
    build_timeline(path, built_here, blender=blender, force=True)
    assert pull_overrides(built_here, blender=blender).overrides == old.overrides


def test_overlapping_strips_the_topmost_decides_where_it_lies(built, blender):
    code = """
        def multicam(channel, start, stop, source, mute=False):
            new = dict(length=stop - start) if bpy.app.version >= (5, 0) else dict(frame_end=stop + 1)
            strip = strips.new_effect(name="mine", type="MULTICAM", channel=channel, frame_start=start + 1, **new)
            strip.multicam_source, strip.mute = source, mute
        multicam(9, 10, 30, 3)
        multicam(10, 15, 25, 2)
        multicam(11, 0, 60, 3, mute=True)
    """
    assert after(built, blender, code) == (
        KEPT,
        Override(R(10, 15), camera="cam3"),
        Override(R(15, 20), camera="cam2"),
        Override(R(25, 30), camera="cam3"),
    )


SIXTH = """
        movie = strips.new_movie(name="extra", filepath=bpy.path.abspath("//cam3.mp4"), channel=9, frame_start=1)
        new = dict(length=8) if bpy.app.version >= (5, 0) else dict(frame_end=10 + 8 + 1)
        shot = strips.new_effect(name="mine", type="MULTICAM", channel=10, frame_start=10 + 1, **new)
        shot.multicam_source = 9
"""


def test_a_camera_the_editor_added_is_no_camera_of_the_edl(built, blender):
    in_blender(blender, built, SIXTH)
    before = (built.parent / "edl.json").read_bytes()
    with pytest.raises(InputError, match=r"'mine', programme frame 10 .*channel 9, which holds no camera.*\(2, 3, 4\)"):
        pull_overrides(built, blender=blender)
    assert (built.parent / "edl.json").read_bytes() == before
    in_blender(blender, built, 'strips["mine"].mute = True')  # the film itself, over everything, is the editor's own
    assert pull_overrides(built, blender=blender).overrides == (KEPT,)


def test_a_camera_that_came_into_the_edl_gets_a_channel_and_every_shot_its_camera(built, blender):
    """The reference camera is the last, so its channel moves up, and Programme, Centering and the editor's own."""
    in_blender(
        blender,
        built,
        """
        at(5, 20).multicam_source = 3
        at(3, 40).transform.offset_x = 5.0
        strips.new_effect(name="title", type="TEXT", channel=7, frame_start=1,
                          **(dict(length=9) if bpy.app.version >= (5, 0) else dict(frame_end=10)))
        """,
    )
    old = pull_overrides(built, blender=blender)
    path = built.parent / "edl.json"
    new = attrs.evolve(
        old,
        cameras=(*old.cameras, attrs.evolve(old.cameras[1], name="cam6")),
        poses=tuple(attrs.evolve(p, homographies={**p.homographies, "cam6": IDENTITY}) for p in old.poses),
    )
    edls.save(new, path)
    request = RefreshRequest(edl=path, blend=built, conformed=(), sound=None)
    heard = Notes()
    run_task(blender, request, heard)
    assert any("camera strips were made anew" in note for note in heard.notes)
    code = """
        cameras = sorted({(s.channel, s["mcsl_camera"]) for s in strips if s.get("mcsl_camera")})
        shown = sorted([span(s)[0], s.multicam_source, s.channel] for s in strips if s.type == "MULTICAM")
        out = [cameras, shown, strips["title"].channel, at(3, 40).transform.offset_x]
    """
    cameras, shown, title, offset = in_blender(blender, built, code, save=False)
    assert cameras == [[2, "cam2"], [3, "cam3"], [4, "cam6"], [5, "cam1"]]
    assert shown == [[0, 5, 6], [20, 3, 6], [40, 3, 6], [45, 5, 6], [50, 3, 6]]
    assert title == 9
    assert offset == pytest.approx(5)
    before = path.read_bytes()
    pull_overrides(built, blender=blender)
    assert path.read_bytes() == before


def test_an_unchanged_edl_leaves_the_camera_strips_as_they_are(built, blender):
    in_blender(blender, built, 'at(3, 40).name = "mine"; at(3, 0).transform.offset_x = 5.0')
    path = built.parent / "edl.json"
    pull_overrides(built, blender=blender)
    request = RefreshRequest(edl=path, blend=built, conformed=(), sound=None)
    heard = Notes()
    run_task(blender, request, heard)
    assert heard.notes == []
    code = "out = [at(3, 40).name, at(3, 0).transform.offset_x]"
    assert in_blender(blender, built, code, save=False) == ["mine", 5]


def test_a_centre_by_hand_is_keyed_and_moved_keys_are_told_of(built, blender):
    assert after(built, blender, 'at(5, 20)["mcsl_offset"] = [12.0, -8.0]') == (
        KEPT,
        Override(R(20, 40), offset=(12.0, -8.0)),
    )
    build_timeline(built.parent / "edl.json", built, blender=blender, force=True)
    code = """
        strip = next(s for s in strips if s.type == "ADJUSTMENT")
        out = []
        for frame in (0, 19, 20, 39, 40):
            scene.frame_set(frame + 1)
            out.append([strip.transform.offset_x, strip.transform.offset_y])
    """
    assert in_blender(blender, built, code, save=False) == [[0, 0], [0, 0], [12, 8], [12, 8], [0, 0]]
    heard = Notes()
    pull_overrides(built, blender=blender, progress=heard)
    assert heard.notes == []
    move_a_key = """
        curve = next(iter(scene.animation_data.action.layers[0].strips[0].channelbags[0].fcurves))
        curve.keyframe_points[1].co[1] += 3
    """
    in_blender(blender, built, move_a_key)
    heard = Notes()
    assert pull_overrides(built, blender=blender, progress=heard).overrides[-1] == Override(
        R(20, 40), offset=(12.0, -8.0)
    )
    assert [note for note in heard.notes if "Centering strip or its keys were changed by hand" in note]
    assert after(built, blender, 'at(5, 20)["mcsl_offset"] = "automatic"') == (KEPT,)
    in_blender(blender, built, 'at(5, 20)["mcsl_offset"] = [1.0]')
    with pytest.raises(InputError, match=r"strip '2: cam2 \[2\]', frame 21: has mcsl_offset .*two numbers \[dx, dy\]"):
        pull_overrides(built, blender=blender)
