"""mcsl-label replaces nothing that somebody painted, filmed or wrote."""

from __future__ import annotations

from pathlib import Path

import marking
import pytest
from mcsl_learned_occlusion.cli import main
from mcsl_learned_occlusion.labelling import check_folder, save_png

from mcsl_core.hooks import InputError
from mcsl_core.outputs.manifest import Manifest

SKIN = (150, 170, 215)


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


@pytest.mark.parametrize("out", ["frames/{one}", "frames/../frames/{one}", "notes.txt", "frames", "film.mp4"])
def test_a_model_is_not_written_over_anything_else(tmp_path: Path, out: str, capsys) -> None:
    frames = tmp_path / "frames"
    marking.mark(marking.Operation(1, SKIN), frames, count=2)
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "film.mp4").write_bytes(b"film")
    one = sorted(path.name for path in frames.glob("*.npz"))[0]
    before = contents(tmp_path) | contents(frames)
    assert main(["train", str(frames), "-o", str(tmp_path / out.format(one=one))]) == 3
    assert capsys.readouterr().err.startswith("mcsl-label: ")
    assert contents(tmp_path) | contents(frames) == before


def test_painted_frames_are_not_exported_over(tmp_path: Path) -> None:
    check_folder(tmp_path / "new")
    picture = marking.Operation(1, SKIN).moment()[0][0].picture
    save_png(tmp_path / "0000001_cam1.png", picture)
    with pytest.raises(InputError, match="not as mcsl wrote it"):
        check_folder(tmp_path)
    Manifest.inside(tmp_path).record(tmp_path / "0000001_cam1.png")
    check_folder(tmp_path)
    save_png(tmp_path / "0000001_cam1.mask.png", picture)
    with pytest.raises(InputError, match=r"0000001_cam1.mask.png: is there already"):
        check_folder(tmp_path)
    check_folder(tmp_path, force=True)
    assert main(["export", str(tmp_path / "no.json"), str(tmp_path)]) == 3
