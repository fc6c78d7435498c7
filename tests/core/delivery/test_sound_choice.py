"""Whose sound the programme has, or that it has none: conformed, written directly, from the command line."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import av
import pytest
from two_cameras import make

import mcsl_core as mcsl
from mcsl_core import edl as document
from mcsl_core.delivery.conform import conform
from mcsl_core.delivery.direct import write_direct
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.edl import NO_SOUND
from mcsl_core.errors import UsageError


def tracks(path: Path) -> list[str]:
    with av.open(str(path)) as container:
        return [stream.type for stream in container.streams]


def test_no_sound_where_none_is_wanted(sources, tmp_path):
    silent = ProgrammeSource(make(), sources, audio_from=NO_SOUND)
    assert conform(silent, tmp_path / "out").audio is None
    assert not list((tmp_path / "out").glob("*.wav"))
    write_direct(silent, tmp_path / "silent.mp4")
    assert tracks(tmp_path / "silent.mp4") == ["video"]
    write_direct(ProgrammeSource(make(), sources), tmp_path / "heard.mp4")
    assert tracks(tmp_path / "heard.mp4") == ["video", "audio"]


def test_the_sound_of_one_camera_and_of_another_lie_beside_each_other(sources, tmp_path):
    done = conform(ProgrammeSource(make(reference="b"), sources, audio_from="a"), tmp_path)
    assert done.audio is not None
    assert conform(ProgrammeSource(make(reference="b"), sources), tmp_path).audio is None  # b has none
    with pytest.raises(UsageError, match=r"no camera 'c'.*a, b, or none"):
        ProgrammeSource(make(), sources, audio_from="c")


@pytest.mark.parametrize(("audio", "expected"), [("none", ["video"]), ("a", ["video", "audio"]), ("b", ["video"])])
def test_on_the_command_line(sources, tmp_path, audio, expected):
    for name in ("a.mp4", "b.mp4"):
        (tmp_path / name).hardlink_to(sources / name)
    document.save(make(), tmp_path / "edl.json")
    out = tmp_path / "out.mp4"
    command = [sys.executable, "-m", "mcsl_core.cli", "render", tmp_path / "edl.json", "-o", out, "--engine", "direct"]
    done = subprocess.run([*command, "--audio", audio], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert tracks(out) == expected
    assert "Sound" not in done.stderr


def test_from_the_front_door(sources, tmp_path):
    for name in ("a.mp4", "b.mp4"):
        (tmp_path / name).hardlink_to(sources / name)
    document.save(make(), tmp_path / "edl.json")
    programme = mcsl.open(tmp_path / "edl.json")
    assert programme.conform(audio="none").audio is None
    assert programme.conform(audio="a").audio is not None
    assert tracks(programme.render(tmp_path / "out.mp4", engine="direct", audio="none")) == ["video"]
