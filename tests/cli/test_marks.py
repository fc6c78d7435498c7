"""From marked recordings to what is delivered, by the real command line: none of the marks comes out."""

from __future__ import annotations

import base64
import re
import subprocess
import sys
from pathlib import Path

import pytest
from marked_recording import MADE, PLACES, marked_recording, marks_in
from traces import MARK, traces

from mcsl_core.blender.render import render
from mcsl_core.delivery.presets import load_preset

pytestmark = pytest.mark.slow

PRESETS = ("review", "h264", "h265", "prores", "archive")


def run(*arguments: object) -> str:
    command = [sys.executable, "-m", "mcsl_core.cli", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=500)
    assert done.returncode == 0, done.stderr
    return done.stdout + done.stderr


@pytest.fixture(scope="module")
def edl(tmp_path_factory: pytest.TempPathFactory) -> Path:
    recording = marked_recording(tmp_path_factory.mktemp("marks"))
    path = recording.parent / f"{MARK}.json"
    run("analyse", recording, "-o", path, "--reference", f"{MARK}-1")
    return path


def test_the_marks_are_in_the_inputs(edl):
    """Else nothing is shown by what follows."""
    films = {film.suffix: film for film in (edl.parent / f"{MARK} 2019-02-03").iterdir()}
    assert set(films) == {".mp4", ".mov", ".mkv"}
    for suffix, film in films.items():
        track = ("track", "attached") if suffix == ".mkv" else ("handler",)
        for word in (*PLACES[:1], "comment", "message", "ch", *track):
            assert any(mark.startswith(f"{MARK}-{word}") for mark in marks_in(film)), (film.name, word)


@pytest.mark.parametrize("preset", PRESETS)
def test_no_mark_is_in_a_directly_rendered_film(edl, tmp_path, preset):
    out = tmp_path / f"out.{load_preset(preset).container}"
    render(edl, out, preset=preset, engine="direct")
    assert marks_in(out) == set()
    assert traces(out) == []
    assert MADE[:10].encode() not in out.read_bytes()


@pytest.mark.parametrize("quality", ["draft", "standard", "fine"])
def test_no_mark_is_in_conformed_pictures_and_sound(edl, tmp_path, quality):
    run("conform", edl, "-o", tmp_path, "--quality", quality)
    media = [path for path in tmp_path.iterdir() if path.suffix != ".json"]
    assert {path.suffix for path in media} >= {".wav"}
    assert len(media) >= 2
    for path in media:
        assert MARK not in path.name
        assert marks_in(path) == set()
        assert traces(path) == []
        assert MADE[:10].encode() not in path.read_bytes()


def test_no_mark_is_in_an_anonymous_report(edl, tmp_path):
    out = tmp_path / "out.html"
    run("report", edl, "-o", out, "--anonymous")
    assert marks_in(out) == set()
    for picture in re.findall("base64,([A-Za-z0-9+/=]+)", out.read_text("utf-8")):
        assert MARK.encode() not in base64.b64decode(picture)
    assert MADE[:10] not in out.read_text("utf-8")
