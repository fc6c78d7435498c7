"""What mcsl made of a recording and people keep beside it never becomes a camera of it."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from coded_video import write_coded
from notes import Notes

from mcsl_core.outputs.claim import claim
from mcsl_core.outputs.manifest import Manifest
from mcsl_core.recording.cameras import open_cameras

CHUNK = "0000000-0000089-464c51efcbd5f2f2a2dd.mp4"


@pytest.fixture
def recording(tmp_path):
    """Two cameras, with what mcsl conformed and delivered beside them."""
    folder = tmp_path / "recording"
    folder.mkdir()
    film = write_coded(tmp_path / "film.mp4", range(5)).read_bytes()
    for name in ("cam1.mp4", "cam2.mp4"):
        (folder / name).write_bytes(film)
    for name in ("edl.conformed", "elsewhere"):
        (folder / name).mkdir()
        (folder / name / CHUNK).write_bytes(film)
        Manifest.inside(folder / name).record(folder / name / CHUNK)
    for name in ("delivered.mp4", "review.mov"):
        claim(folder / name, manifest=Manifest.beside(folder / "edl.json")).write(film)
    return folder


def cameras(*recording: Path, base: Path | None = None) -> tuple[list[str], str]:
    progress = Notes()
    found = open_cameras(recording, base or recording[0], progress)
    return [camera.name for camera in found], "\n".join(progress.notes)


def test_what_mcsl_made_is_left_out_and_told(recording):
    names, told = cameras(recording)
    assert names == ["cam1", "cam2"]
    assert "delivered.mp4, edl.conformed/, elsewhere/, review.mov" in told


def test_in_a_copy_of_the_folder_as_well(recording, tmp_path):
    copy = tmp_path / "copy"
    shutil.copytree(recording, copy, copy_function=shutil.copyfile)  # other times
    assert cameras(copy)[0] == ["cam1", "cam2"]


def test_by_the_list_beside_an_edl_elsewhere(recording, tmp_path):
    edl = tmp_path / "project" / "edl.json"
    edl.parent.mkdir()
    claim(recording / "third.mp4", manifest=Manifest.beside(edl)).write((recording / "cam1.mp4").read_bytes())
    assert cameras(recording)[0] == ["cam1", "cam2", "third"]  # nothing there says whose it is
    assert cameras(recording, base=edl.parent)[0] == ["cam1", "cam2"]


def test_a_file_that_is_named_is_a_camera(recording):
    names, told = cameras(recording / "cam1.mp4", recording / "delivered.mp4", base=recording)
    assert names == ["cam1", "delivered"]
    assert "left out" not in told


def test_another_film_under_the_same_name_is_a_camera(recording):
    with (recording / "delivered.mp4").open("ab") as file:
        file.write(b"\0\0\0\x08free")
    assert cameras(recording)[0] == ["cam1", "cam2", "delivered"]


def test_what_mcsl_simulated_is_a_recording(recording):
    Manifest.inside(recording).record(recording / "cam1.mp4", recording / "cam2.mp4")
    assert cameras(recording)[0] == ["cam1", "cam2"]


@pytest.mark.parametrize(
    "text",
    [
        "",
        "no JSON",
        "[]",
        *(json.dumps({"schema": "mcsl.outputs/1", "files": {"cam2.mp4": known}}) for known in (3, [[{}]])),
    ],
)
def test_lists_of_others_say_nothing(recording, text):
    (recording / "edl.outputs.json").write_text(text)
    (recording / "elsewhere" / "mcsl-outputs.json").write_text(text)
    assert cameras(recording)[0] == ["cam1", "cam2", "delivered", "review", "elsewhere"]
