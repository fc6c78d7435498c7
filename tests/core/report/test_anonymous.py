"""A report for people who may not know whose operation it was: no planted name comes out, and nothing else is lost."""

from __future__ import annotations

import base64
import getpass
import re
import socket
import subprocess
import sys
from pathlib import Path

import attrs
import pytest
from hypothesis import given, settings
from strategies import edls

import mcsl_core as mcsl
from mcsl_core.edl import Edl, MadeBy, Override, Weak, load, save
from mcsl_core.progress import Silent
from mcsl_core.report.anonymous import fileless, nameless, untold
from mcsl_core.report.page import Lacking, page
from mcsl_core.simulation import Scenario, simulate
from mcsl_core.timing import FrameRange

MARK = "Kasparov"


@pytest.fixture(scope="module")
def edl_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording whose folder, files, cameras, remarks and reasons all name the patient and the day."""
    folder = tmp_path_factory.mktemp("anonymous") / f"{MARK} 2026-11-25"
    simulate(Scenario(seed=5, duration_s=4, movements=0, size=(320, 180), cameras=3), folder, Silent())
    for index in (1, 2, 3):
        (folder / f"cam{index}.mp4").rename(folder / f"{MARK}_{index}.mp4")
    path = folder / f"{MARK}.json"
    edl = mcsl.analyse(folder, path).edl
    assert MARK in edl.cameras[0].name
    second = edl.cameras[1].name
    others = (weak for weak in edl.poses[0].weak if weak.camera != second)
    pose = attrs.evolve(edl.poses[0], weak=(Weak(second, f"too few matches with {edl.reference}"), *others))
    made_by = MadeBy("1.0", {"note": MARK}, {"occlusion": f"net {MARK}-net 1.0"})
    overrides = (Override(FrameRange(10, 20), camera=edl.cameras[2].name, note=f"name of {MARK} spoken"),)
    save(attrs.evolve(edl, poses=(pose, *edl.poses[1:]), overrides=overrides, made_by=made_by), path)
    return path


def report(edl_path: Path, out: Path, *options: str) -> str:
    command = [sys.executable, "-m", "mcsl_core.cli", "report", str(edl_path), "-o", str(out), *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return out.read_text("utf-8")


def test_no_name_comes_out(edl_path: Path, tmp_path: Path) -> None:
    named, told = report(edl_path, tmp_path / "a.html"), report(edl_path, tmp_path / "b.html", "--anonymous")
    assert MARK in named
    words = re.sub("base64,[A-Za-z0-9+/=]+", "", told)
    machine = [word for word in (str(Path.home()), socket.gethostname(), getpass.getuser()) if len(word) > 4]
    for word in (MARK, "2026", "/tmp", ".mp4", ".json", edl_path.parent.name, *machine):
        assert word not in words, word
    for name in ("cam A", "cam B", "cam C", "cam B is weak: too few matches with cam A"):
        assert name in told
    pictures = [base64.b64decode(data) for data in re.findall(r"base64,([A-Za-z0-9+/=]+)", told)]
    assert len(pictures) == named.count("base64,") > 0
    assert all(MARK.encode() not in data and b"Exif" not in data for data in pictures)
    assert len(told) > 0.9 * len(named)


def test_pictures_can_be_left_out(edl_path: Path, tmp_path: Path) -> None:
    text = report(edl_path, tmp_path / "a.html", "--anonymous", "--no-pictures")
    assert "base64," not in text
    assert "The pictures were left out." in text


def test_what_is_missing_is_told_without_its_name(edl_path: Path, tmp_path: Path) -> None:
    edl = load(edl_path)
    (tmp_path / MARK).mkdir()
    save(edl, tmp_path / MARK / f"{MARK}.json")  # neither media nor scores lie there
    text = report(tmp_path / MARK / f"{MARK}.json", tmp_path / "a.html", "--anonymous")
    assert MARK not in text
    assert "The pictures cannot be shown." in text
    assert "What each camera sees over time is not known." in text
    assert untold("") == ""


@settings(max_examples=40)
@given(edls())
def test_any_edl(edl: Edl) -> None:
    """A camera's name of one letter or of markup is found in any page: so only names that cannot stand there count."""
    cameras = {camera.name: f"{MARK}{index}" for index, camera in enumerate(edl.cameras)}
    made, _ = nameless(edl, None)
    assert [camera.name for camera in made.cameras] == [f"cam {chr(ord('A') + i)}" for i in range(len(cameras))]
    assert made.frames == edl.frames
    assert [shot.range for shot in made.shots] == [shot.range for shot in edl.shots]
    text = page(fileless(made), "recording", None, [None] * len(edl.poses), None, Lacking())
    for camera in edl.cameras:
        for media in camera.media:
            assert len(media.path) < 12 or media.path not in text
