"""Files beside the recording: what is missing, no file, a playlist, or from elsewhere is told."""

from __future__ import annotations

import os

import pytest

from blender_addon.core.outside import remark_on


def test_a_file_of_the_project_is_no_news(tmp_path):
    (tmp_path / "title.png").write_bytes(b"png")
    assert remark_on("strip 'a'", str(tmp_path / "title.png"), [tmp_path]) == ""


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("http://127.0.0.1/film.mp4", "is no file"),
        ("concat:a.ts|b.ts", "is no file"),
        ("", "is no file"),
        ("HOME/none.mp4", "is missing"),
        ("HOME/..", "is no file"),
        ("HOME/fifo", "is no file"),
        ("HOME/list.mp4", "is a list of files"),
        ("HOME/link.mp4", "from outside this project"),
    ],
)
def test_others_are_told(tmp_path, path, said):
    home = tmp_path / "home"
    home.mkdir()
    os.mkfifo(home / "fifo")
    (home / "list.mp4").write_text("ffconcat version 1.0\nfile x.mp4\n")
    (tmp_path / "away.mp4").write_bytes(b"\0" * 16)
    (home / "link.mp4").symlink_to(tmp_path / "away.mp4")
    told = remark_on("strip 'a'", path.replace("HOME", str(home)), [home])
    assert told.startswith("strip 'a' shows")
    assert said in told
