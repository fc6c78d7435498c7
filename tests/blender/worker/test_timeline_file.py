"""A timeline's file is an editor's work: built anew over it only where nobody has worked in it, or by force."""

import av
import pytest
from blender_recording import in_blender
from click.testing import CliRunner
from notes import Notes

from mcsl_core.blender.render import render
from mcsl_core.blender.timeline import build_timeline
from mcsl_core.cli.main import cli
from mcsl_core.errors import InputError, UsageError


def test_an_edited_timeline_is_replaced_by_force_alone_and_kept(built, blender):
    edl = built.parent / "edl.json"
    build_timeline(edl, built, blender=blender)  # nobody has worked in it
    in_blender(blender, built, "scene.timeline_markers.new('mine', frame=3)")
    edited = built.read_bytes()
    with pytest.raises(InputError, match="is there already, and not as mcsl wrote it"):
        build_timeline(edl, built, blender=blender)
    assert built.read_bytes() == edited
    build_timeline(edl, built, blender=blender, force=True)
    kept = [path.read_bytes() for path in built.parent.glob("edit.blend?")]  # one is the editor's Blender's own
    assert edited in kept
    build_timeline(edl, built, blender=blender)
    assert len(list(built.parent.glob("edit.blend?"))) == len(kept)


def test_one_without_sound_stays_without(project, blender):
    """Whatever brings it up to date: here a render, which conforms the sound of every other timeline."""
    edl, blend, out = project / "edl.json", project / "edit.blend", project / "out.mp4"
    arguments = ["timeline", str(edl), "-o", str(blend), "--audio", "none", "--blender", blender.command[0]]
    done = CliRunner().invoke(cli, arguments)
    assert done.exit_code == 0, done.output
    look = "out = [[s.name for s in strips if s.type == 'SOUND'], scene.render.ffmpeg.audio_codec]"
    assert in_blender(blender, blend, look, save=False) == [[], "AAC"], "music that is laid later is heard"
    progress = Notes()
    for _ in range(2):
        render(blend, out, preset="review", blender=blender, progress=progress)
        with av.open(str(out)) as container:
            assert [stream.type for stream in container.streams] == ["video"]
    assert list(project.glob("edl.conformed/sound-*.wav")), "the render had some to lay"
    assert not [note for note in progress.notes if "sound" in note], "it was asked for"
    assert in_blender(blender, blend, look, save=False)[0] == []
    build_timeline(edl, project / "with.blend", blender=blender)
    assert in_blender(blender, project / "with.blend", look, save=False)[0]


def test_another_cameras_sound_is_refused_before_any_work(project, blender):
    arguments = ["timeline", str(project / "edl.json"), "-o", str(project / "edit.blend"), "--audio", "cam2"]
    assert CliRunner().invoke(cli, arguments).exit_code == 2
    with pytest.raises(UsageError, match="a timeline has the sound that its EDL names or none, not that of 'cam2'"):
        build_timeline(project / "edl.json", project / "edit.blend", blender=blender, audio="cam2")
    assert not (project / "edit.blend").exists()
