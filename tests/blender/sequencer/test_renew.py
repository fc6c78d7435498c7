"""What an editor did to our strips lives on when the timeline is brought up to date."""

from __future__ import annotations

import attrs
import pytest
from blender_recording import FRAMES, R, an_edl, in_blender, write_camera
from notes import Notes

from mcsl_core import edl as edls
from mcsl_core.blender.child import run_task
from mcsl_core.blender.messages import ConformedPiece, RefreshRequest
from mcsl_core.blender.timeline import pull_overrides
from mcsl_core.edl import IDENTITY


def refreshed(built, blender, pieces=(), edl=None):
    """The timeline brought up to date with conformed pieces [(start, stop, name)]; what was told."""
    path, heard = built.parent / "edl.json", Notes()
    if edl is not None:
        edls.save(edl, path)
    found = []
    for start, stop, name in pieces:
        file = built.parent / f"{start:07d}-{stop:07d}-{name}.mp4"
        if not file.exists():
            write_camera(file, "cam3", stop - start, first=start, sound=False)
        found.append(ConformedPiece(R(start, stop), file))
    run_task(blender, RefreshRequest(edl=path, blend=built, conformed=tuple(found), sound=None), heard)
    return heard.notes


def listed(built, blender, role):
    code = f"""
        out = [[*span(s), s.channel, s.mute, s.name, getattr(s, "filepath", "")[-9:], len(s.modifiers),
                round(s.blend_alpha, 3), s.color_tag]
               for s in sorted(strips, key=lambda s: (span(s), s.channel)) if s.get("mcsl") == "{role}"]
    """
    return in_blender(blender, built, code, save=False)


@pytest.mark.both_blenders
def test_a_conformed_strip_muted_or_graded_by_hand(built, blender):
    refreshed(built, blender, [(0, 30, "aa"), (30, FRAMES, "aa")])
    code = """
        at(7, 0).mute = True
        scene.sequence_editor.channels[7].lock = False  # as a person does to cut there
        part = at(7, 30).split(frame=41, split_method="SOFT")
        part.modifiers.new("grade", "BRIGHT_CONTRAST").bright = 20
        part.blend_alpha = 0.5
        part.color_tag = "COLOR_05"
        part.keyframe_insert("blend_alpha", frame=45)
    """
    in_blender(blender, built, code)
    for name in ("bb", "cc"):
        assert refreshed(built, blender, [(0, 50, name), (50, FRAMES, name)]) == []
        first, second, third, fourth = listed(built, blender, "conformed")
        assert first == [0, 30, 7, True, "conformed", f"50-{name}.mp4", 0, 1, "NONE"]
        assert second[:4] == [30, 40, 7, False]
        assert (third[:4], third[5:]) == ([40, 50, 7, False], [f"50-{name}.mp4", 1, 0.5, "COLOR_05"])
        assert (fourth[:4], fourth[5:]) == ([50, FRAMES, 7, False], [f"60-{name}.mp4", 1, 0.5, "COLOR_05"])
    code = "out = [[s.frame_start, s.frame_duration] for s in sorted(strips, key=span) if s.get('mcsl') == 'conformed']"
    assert in_blender(blender, built, code, save=False) == [[1, 50], [1, 50], [1, 50], [51, 10]]


@pytest.mark.both_blenders
def test_what_awaits_its_pictures_is_hidden_and_comes_back(built, blender):
    refreshed(built, blender, [(0, FRAMES, "aa")])
    in_blender(blender, built, 'at(7, 0).modifiers.new("grade", "BRIGHT_CONTRAST")')
    refreshed(built, blender, [(0, 30, "bb")])
    assert [s[:4] + s[6:7] for s in listed(built, blender, "conformed")] == [
        [0, 30, 7, False, 1],
        [30, FRAMES, 7, True, 1],
    ]
    pull_overrides(built, blender=blender)
    assert [s[3] for s in listed(built, blender, "conformed")] == [False, True]
    refreshed(built, blender, [(0, FRAMES, "cc")])
    assert [s[3] for s in listed(built, blender, "conformed")] == [False, False]


def test_the_programme_and_centering_keep_grades_names_and_colours(built, blender):
    code = """
        at(5, 20).modifiers.new("grade", "BRIGHT_CONTRAST")
        at(5, 20).blend_alpha = 0.75
        at(5, 0).name = "incision"
        at(5, 50).color_tag = "COLOR_04"
        at(6, 0).modifiers.new("warmth", "WHITE_BALANCE")
        right = at(5, 20).split(frame=31, split_method="SOFT")
        right.multicam_source = 3
    """
    in_blender(blender, built, code)
    edl = pull_overrides(built, blender=blender)
    refreshed(built, blender)
    found = listed(built, blender, "programme")
    assert [s[:2] + s[6:] for s in found] == [
        [0, 20, 0, 1, "COLOR_05"],  # a camera's
        [20, 30, 1, 0.75, "COLOR_04"],
        [30, 40, 1, 0.75, "COLOR_03"],
        [40, 45, 0, 1, "COLOR_06"],
        [45, 50, 0, 1, "COLOR_03"],
        [50, FRAMES, 0, 1, "COLOR_04"],
    ]
    assert found[0][4] == "incision"
    assert [s[:2] + s[6:7] for s in listed(built, blender, "centering")] == [[0, FRAMES, 1]]
    code = "out = [[span(s)[0], s.multicam_source, s['mcsl_id']] for s in sorted(strips, key=span) if s.type == 'MULTICAM']"  # noqa: E501
    assert in_blender(blender, built, code, save=False)[1:3] == [[20, 2, "shot-0000020"], [30, 3, "shot-0000030"]]
    assert pull_overrides(built, blender=blender) == edl


def test_an_editors_effect_over_our_strips_stays(built, blender):
    code = """
        a, b = at(5, 0), at(5, 20)
        b.channel = 20
        cut(a, 0, 24)
        new = dict(length=4) if bpy.app.version >= (5, 0) else dict(frame_end=25)
        names = ("input1", "input2") if bpy.app.version >= (5, 0) else ("seq1", "seq2")
        try:
            strips.new_effect(name="mine", type="CROSS", channel=21, frame_start=21, input1=a, input2=b, **new)
        except TypeError:
            strips.new_effect(name="mine", type="CROSS", channel=21, frame_start=21, seq1=a, seq2=b, **new)
    """
    in_blender(blender, built, code)
    pull_overrides(built, blender=blender)
    refreshed(built, blender)
    code = "s = strips.get('mine'); out = s and [s.type, s.input_1.name, s.input_2.name, *span(s)]"
    found = in_blender(blender, built, code, save=False)
    assert found is not None
    assert found[0] == "CROSS"
    assert found[3:] == [20, 24]


def test_camera_strips_keep_what_was_done_when_cameras_come(built, blender):
    code = """
        at(2, 40).modifiers.new("grade", "BRIGHT_CONTRAST")
        at(2, 40).name = "the good one"
        at(3, 0).mute = True
        scene.sequence_editor.channels[7].mute = True
        scene.sequence_editor.channels[9].mute = True
        strips.new_effect(name="title", type="TEXT", channel=9, frame_start=1,
                          **(dict(length=9) if bpy.app.version >= (5, 0) else dict(frame_end=10)))
    """
    in_blender(blender, built, code)
    old = edls.load(built.parent / "edl.json")
    refreshed(built, blender, [(0, FRAMES, "aa")])
    in_blender(blender, built, 'at(7, 0).modifiers.new("grade", "BRIGHT_CONTRAST"); at(5, 20).blend_alpha = 0.5')
    more = tuple(attrs.evolve(old.cameras[1], name=name) for name in ("cam6", "cam7", "cam8"))
    names = [camera.name for camera in (*old.cameras, *more)]
    poses = tuple(attrs.evolve(p, homographies=dict.fromkeys(names, IDENTITY)) for p in old.poses)
    poses = (attrs.evolve(poses[0], range=R(0, 45)), attrs.evolve(poses[1], range=R(45, FRAMES)))
    notes = refreshed(
        built, blender, [(0, FRAMES, "bb")], attrs.evolve(old, cameras=(*old.cameras, *more), poses=poses)
    )
    assert any("camera strips were made anew" in note for note in notes)
    cameras = listed(built, blender, "camera")
    graded = [s for s in cameras if s[6]]
    assert [s[:3] for s in graded] == [[30, 45, 2], [45, FRAMES, 2]]
    assert graded[0][4] == "the good one"
    assert [s[:3] for s in cameras if s[3]] == [[0, 30, 3]]
    by_channel = {}
    for s in cameras:
        by_channel.setdefault(s[2], []).append(s[:2])
    assert by_channel[2] == [[3, 30], [30, 45], [45, FRAMES]]
    assert by_channel[3] == [[0, 30], [30, 45], [45, FRAMES]]
    assert sorted(by_channel) == [2, 3, 4, 5, 6, 7]
    assert [s[:3] + s[6:8] for s in listed(built, blender, "conformed")] == [[0, FRAMES, 10, 1, 1]]
    assert [s[2] for s in listed(built, blender, "programme") if s[7] == 0.5] == [8]
    code = "c = scene.sequence_editor.channels; out = [strips['title'].channel, [n for n in range(1, 40) if c[n].mute]]"
    title, muted = in_blender(blender, built, code, save=False)
    assert title in muted
    assert muted == [10, title]


def test_an_untouched_timeline_is_built_as_new(built, blender):
    code = "out = sorted([s.channel, *span(s), s.type, s.name, s.blend_type, s.mute] for s in strips)"
    before = in_blender(blender, built, code, save=False)
    assert refreshed(built, blender) == []
    assert in_blender(blender, built, code, save=False) == before
    assert an_edl() == edls.load(built.parent / "edl.json")
