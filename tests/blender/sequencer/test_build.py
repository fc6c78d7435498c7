"""The timeline as Blender has it: channels, strips, settings, paths."""

from __future__ import annotations

import shutil

import attrs
import av
import pytest
from blender_recording import FRAMES, LIGHT, SIZE, R, an_edl, in_blender
from interlaced_video import write_interlaced
from notes import Notes

from mcsl_core import edl as edls
from mcsl_core.blender.child import run_task
from mcsl_core.blender.messages import ConformedPiece, TimelineRequest
from mcsl_core.blender.timeline import build_timeline, pull_overrides
from mcsl_core.delivery.presets import load_preset
from mcsl_core.edl import IDENTITY, Override
from mcsl_core.edl.edits import rebased
from mcsl_core.errors import BlenderError, InputError, UsageError

LISTING = """
    out = {
        "channels": [c.name for c in scene.sequence_editor.channels][1:8],
        "strips": sorted([s.channel, *span(s), s.type, s.blend_type] for s in strips),
        "sources": [[span(s)[0], s.multicam_source, s["mcsl_id"], s["mcsl_automatic"]]
                    for s in sorted(strips, key=lambda s: span(s)) if s.type == "MULTICAM"],
        "markers": sorted([m.frame - 1, m.name] for m in scene.timeline_markers),
        "paths": sorted({s.filepath for s in strips if s.type == "MOVIE"}
                        | {s.sound.filepath for s in strips if s.type == "SOUND"}),
        "scene": [scene["mcsl"], scene["mcsl_edl"], scene.frame_start, scene.frame_end, scene.render.fps,
                  round(scene.render.fps_base, 6), scene.render.resolution_x, scene.render.resolution_y,
                  scene.view_settings.view_transform, scene.sequencer_colorspace_settings.name,
                  scene.render.dither_intensity, scene.render.filepath],
    }
"""


@pytest.mark.both_blenders
def test_channels_and_strips_as_planned(built, blender):
    found = in_blender(blender, built, LISTING, save=False)
    assert found["channels"] == ["Audio", "cam2", "cam3", "cam1", "Programme", "Centering", "Conformed"]
    by_channel = {}
    for channel, start, stop, kind, blend in found["strips"]:
        by_channel.setdefault(channel, []).append((start, stop, kind, blend))
    replaced = ("MOVIE", "REPLACE")
    assert [s[:3] for s in by_channel[1]] == [(0, 40, "SOUND"), (40, FRAMES, "SOUND")]
    assert by_channel[2] == [(3, 30, *replaced), (30, FRAMES, *replaced)]  # late by its clock's offset
    assert by_channel[3] == [(0, 30, *replaced), (30, FRAMES, *replaced)]  # split at the pose
    assert by_channel[4] == [(0, 30, *replaced), (30, 40, *replaced), (40, FRAMES, *replaced)]  # two files
    assert [s[:3] for s in by_channel[5]] == [
        (a, b, "MULTICAM") for a, b in [(0, 20), (20, 40), (40, 45), (45, 50), (50, FRAMES)]
    ]
    assert [s[:3] for s in by_channel[6]] == [(0, FRAMES, "ADJUSTMENT")]
    assert 7 not in by_channel
    assert found["sources"] == [
        [0, 4, "shot-0000000", "cam1"],
        [20, 2, "shot-0000020", "cam2"],
        [40, 3, "shot-0000040", "cam3"],
        [45, 4, "shot-0000045", "cam3"],
        [50, 3, "shot-0000050", "cam3"],
    ]
    assert found["markers"] == [[28, ""], [30, ""], [32, "perspective 1"]]


@pytest.mark.both_blenders
def test_settings_and_relative_paths(built, blender):
    found = in_blender(blender, built, LISTING, save=False)
    assert found["paths"] == ["//cam1_a.mp4", "//cam1_b.mp4", "//cam2.mp4", "//cam3.mp4"]
    assert found["scene"][:4] == ["mcsl.timeline/1", "//edl.json", 1, FRAMES]
    assert found["scene"][4:] == [30, 1.001, 320, 180, "Standard", "sRGB", 0, "//edit.mp4"]


@pytest.mark.both_blenders
def test_centering_is_keyed_and_stops_where_it_is_switched_off(project, blender):
    edl = an_edl(centering=((0, 0.0, 0.0), (10, 10.0, -20.0)), overrides=(Override(R(20, 30), centering=False),))
    edls.save(edl, project / "edl.json")
    build_timeline(project / "edl.json", project / "edit.blend", blender=blender)
    code = """
        strip = next(s for s in strips if s.type == "ADJUSTMENT")
        out = []
        for frame in (0, 5, 10, 19, 20, 29, 30, 59):
            scene.frame_set(frame + 1)
            out.append([frame, strip.transform.offset_x, strip.transform.offset_y])
    """
    found = in_blender(blender, project / "edit.blend", code, save=False)
    assert found == [
        *[[0, 0, 0], [5, 5, 10], [10, 10, 20], [19, 10, 20]],  # y up in Blender
        *[[20, 0, 0], [29, 0, 0], [30, 10, 20], [59, 10, 20]],
    ]


@pytest.mark.both_blenders
def test_a_moved_folder_still_works(built, blender):
    moved = built.parent.with_name("elsewhere")
    shutil.move(built.parent, moved)
    before = (moved / "edl.json").read_bytes()
    code = """
        at(5, 0).multicam_source = 3
        out = [os.path.isfile(bpy.path.abspath(s.filepath)) for s in strips if s.type == "MOVIE"]
    """
    assert all(in_blender(blender, moved / "edit.blend", code))
    assert pull_overrides(moved / "edit.blend", blender=blender).overrides[-1] == Override(R(0, 20), camera="cam3")
    assert (moved / "edl.json").read_bytes() != before


@pytest.mark.both_blenders
def test_a_pull_into_another_folder_keeps_the_media_reachable(built, blender, tmp_path):
    other = tmp_path / "other" / "mine.json"
    pull_overrides(built, other, blender=blender)
    for camera in edls.load(other).cameras:
        for media in camera.media:
            assert (other.parent / media.path).is_file()


def test_media_and_cameras_that_are_missing_are_named(project, blender):
    (project / "cam3.mp4").unlink()
    with pytest.raises(InputError, match=r"cam3\.mp4: is missing"):
        build_timeline(project / "edl.json", project / "edit.blend", blender=blender)
    assert not (project / "edit.blend").exists()
    assert not list(project.glob(".edit*"))


def test_a_playlist_in_a_cameras_place_is_not_opened(project, blender):
    (project / "cam3.mp4").unlink()  # a link to the recording that all tests share
    (project / "cam3.mp4").write_text("ffconcat version 1.0\nfile cam2.mp4\n")
    with pytest.raises(InputError, match=r"cam3\.mp4: is a list of files \(ffconcat\)"):
        build_timeline(project / "edl.json", project / "edit.blend", blender=blender)
    assert not (project / "edit.blend").exists()


def test_blender_too_refuses_what_leads_out_of_the_edls_folder(project, blender, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    edls.save(rebased(edls.load(project / "edl.json"), project, elsewhere), elsewhere / "edl.json")
    request = TimelineRequest(
        blend=elsewhere / "edit.blend",
        edl=elsewhere / "edl.json",
        conformed=(),
        sound=None,
        preset=load_preset("h264"),
        output="a.mp4",
    )
    with pytest.raises(InputError, match="leads out of the EDL's folder"):
        run_task(blender, request)
    with edls.allowed_outside():
        run_task(blender, request)
    edls.load(elsewhere / "edl.json")


def test_what_is_no_timeline_is_refused(project, blender):
    with pytest.raises(UsageError, match=r"ends in \.blend"):
        build_timeline(project / "edl.json", project / "edit.mp4", blender=blender)
    (project / "other.blend").write_bytes(b"no blend at all")
    with pytest.raises(InputError, match="Blender cannot open it"):
        pull_overrides(project / "other.blend", blender=blender)


def test_an_edl_that_went_away_is_named(built, blender):
    (built.parent / "edl.json").rename(built.parent / "moved.json")
    with pytest.raises(InputError, match=r"names the EDL //edl\.json, which is not there"):
        pull_overrides(built, blender=blender)


def test_a_weak_camera_stands_upright_and_whole(project, blender):
    from mcsl_core.edl import Weak

    edl = an_edl()
    poses = [
        attrs.evolve(
            pose,
            homographies={name: IDENTITY for name in LIGHT if name != "cam3"},
            weak=(Weak("cam3", "nothing to match"),),
        )
        for pose in edl.poses
    ]
    edls.save(attrs.evolve(edl, poses=tuple(poses), size=(640, 360)), project / "edl.json")
    build_timeline(project / "edl.json", project / "edit.blend", blender=blender)
    code = "t = at(3, 0).transform; out = [t.scale_x, t.scale_y, t.rotation, t.offset_x, t.offset_y]"
    assert in_blender(blender, project / "edit.blend", code, save=False) == [2, 2, 0, 0, 0]


def test_two_timelines_in_one_file_and_a_newer_schema_are_refused(built, blender):
    in_blender(blender, built, "scene.copy().use_fake_user = True")
    with pytest.raises(InputError, match=r"holds 2 scenes \(.*\) with an mcsl timeline"):
        pull_overrides(built, blender=blender)
    in_blender(
        blender,
        built,
        'bpy.data.scenes.remove(bpy.data.scenes[-1]); bpy.data.scenes[0]["mcsl"] = "mcsl.timeline/9"',
    )
    with pytest.raises(InputError, match=r"schema 'mcsl\.timeline/9', this mcsl reads"):
        pull_overrides(built, blender=blender)


def test_a_conformed_file_of_the_wrong_length_is_refused(project, blender):
    request = TimelineRequest(
        edl=project / "edl.json",
        blend=project / "edit.blend",
        conformed=(ConformedPiece(R(0, 50), project / "cam3.mp4"),),
        sound=None,
        preset=load_preset("h264"),
        output="edit.mp4",
    )
    with pytest.raises(BlenderError, match=r"cam3\.mp4: has 60 frames, 50 belong there"):
        run_task(blender, request)


def test_a_reference_without_sound_makes_a_silent_timeline(project, blender):
    edls.save(attrs.evolve(an_edl(), reference="cam3"), project / "edl.json")
    build_timeline(project / "edl.json", project / "edit.blend", blender=blender)
    code = "out = [[s.name for s in strips if s.type == 'SOUND'], scene.render.ffmpeg.audio_codec]"
    assert in_blender(blender, project / "edit.blend", code, save=False) == [[], "AAC"]


def test_a_mirrored_camera_file_is_told(project, blender):
    camera = project / "cam2.mp4"
    camera.rename(project / "upright.mp4")
    with av.open(str(project / "upright.mp4")) as film, av.open(str(camera), "w") as turned:
        copy = turned.add_stream_from_template(film.streams.video[0])
        copy.set_display_rotation(0, hflip=True)
        for packet in film.demux(video=0):
            if packet.dts is not None:
                packet.stream = copy
                turned.mux(packet)
    progress = Notes()
    build_timeline(project / "edl.json", project / "edit.blend", blender=blender, progress=progress)
    told = [note for note in progress.notes if "mirrored for display" in note]
    assert len(told) == 1
    assert told[0].startswith("cam2: cam2.mp4")


def test_an_interlaced_camera_file_is_told(project, blender):
    (project / "cam2.mp4").unlink()
    write_interlaced(project / "cam2.mp4", FRAMES - 3, size=SIZE)
    progress = Notes()
    build_timeline(project / "edl.json", project / "edit.blend", blender=blender, progress=progress)
    assert [note for note in progress.notes if note.startswith("cam2: cam2.mp4: interlaced")]
