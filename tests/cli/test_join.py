"""`mcsl join`, as a farm's last job calls it: whole films alone."""

from __future__ import annotations

from pathlib import Path

import pytest
from archive_desk import mcsl
from builders import small_edl
from coded_video import write_coded

from mcsl_core import edl as edls


@pytest.fixture
def pieces(tmp_path: Path) -> Path:
    folder = tmp_path / "pieces"
    folder.mkdir()
    write_coded(folder / "0000001-0000010.mp4", range(10))
    write_coded(folder / "0000011-0000018.mp4", range(10, 18))
    return folder


def test_pieces_become_one_film(pieces: Path, tmp_path: Path) -> None:
    done = mcsl("--progress", "json", "join", pieces, "-o", tmp_path / "film.mp4")
    assert done.returncode == 0, done.stderr
    assert '"frames": 18' in done.stdout


def test_a_piece_that_is_shorter_than_its_name_says_is_refused(pieces: Path, tmp_path: Path) -> None:
    (pieces / "0000011-0000018.mp4").rename(pieces / "0000011-0000020.mp4")
    done = mcsl("join", pieces, "-o", tmp_path / "film.mp4")
    assert done.returncode == 3
    assert "0000011-0000020.mp4: holds 8 pictures where its name says 10" in " ".join(done.stderr.split())
    assert not (tmp_path / "film.mp4").exists()


def test_a_programme_of_which_the_end_is_missing_is_refused(pieces: Path, tmp_path: Path) -> None:
    edl = small_edl()
    assert edl.frames > 18
    edls.save(edl, tmp_path / "edl.json")
    done = mcsl("join", pieces, "-o", tmp_path / "film.mp4")
    assert done.returncode == 3
    assert f"holds frames up to 18, the programme has {edl.frames}" in " ".join(done.stderr.split())


@pytest.mark.parametrize("name", ["film.avi", "film"])
def test_what_no_film_can_be_called_is_refused(pieces: Path, tmp_path: Path, name: str) -> None:
    done = mcsl("join", pieces, "-o", tmp_path / name)
    assert done.returncode == 2
    assert "cannot write a" in done.stderr
