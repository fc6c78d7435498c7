"""Files of arrays as disks and other people leave them: refused by name, never unpacked beyond what was said."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from mcsl_core.analysis.measurements import Measurements, load_measurements
from mcsl_core.arrays import read_arrays
from mcsl_core.errors import DocumentError, InputError
from mcsl_core.occlusion.score_table import ScoreTable

TABLE = ScoreTable(np.arange(4), ("a", "b"), np.full((4, 2), 0.5), np.ones((4, 2), bool))


def saved(path: Path, **other: object) -> Path:
    Measurements(TABLE).save(path)
    with np.load(path) as stored:
        arrays = dict(stored)
    np.savez_compressed(path, **{**arrays, **other})  # pyright: ignore[reportArgumentType]
    return path


def packed(path: Path, name: str, content: bytes) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as out:
        out.writestr(name, content)
    return path


def header(shape: str, kind: str = "<f8") -> bytes:
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".encode()
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text


DAMAGED = {
    "cut short": lambda p: p.write_bytes(saved(p).read_bytes()[:-40]),
    "a byte changed": lambda p: p.write_bytes(saved(p).read_bytes()[:90] + b"\xff\xff" + p.read_bytes()[92:]),
    "no zip": lambda p: p.write_bytes(b"no zip"),
    "empty": lambda p: p.write_bytes(b""),
    "a zip of something else": lambda p: packed(p, "letter.txt", b"Dear"),
    "a zip bomb": lambda p: packed(p, "frames.npy", header("(300000000,)", "|i1") + bytes(300_000_000)),
    "a shape beyond the file": lambda p: packed(p, "frames.npy", header("(1000000000000,)") + bytes(80)),
    "a negative shape": lambda p: packed(p, "frames.npy", header("(-8,)") + bytes(80)),
    "a pickle": lambda p: saved(p, frames=np.array([{}, {}], object)),
    "other shapes": lambda p: saved(p, visible=np.zeros((4, 3))),
    "no names": lambda p: saved(p, cameras=np.array("a")),
    "frames in two axes": lambda p: saved(p, frames=np.zeros((4, 2), int)),
    "frames that are no numbers": lambda p: saved(p, frames=np.array(list("abcd"))),
    "shares beyond one": lambda p: saved(p, visible=np.full((4, 2), 9.0)),
    "complex shares": lambda p: saved(p, visible=np.array(["x"] * 8).reshape(4, 2)),
    "no label": lambda p: saved(p, movement_label=np.zeros(0)),
}


@pytest.mark.parametrize("name", DAMAGED)
def test_damaged_scores_are_refused_by_name(tmp_path: Path, name: str) -> None:
    path = tmp_path / "edl.scores.npz"
    DAMAGED[name](path)
    with pytest.raises(DocumentError, match="is not a table of scores") as refused:
        load_measurements(path)
    assert refused.value.where == str(path)
    assert "mcsl analyse" in refused.value.remedy


def test_what_was_saved_is_read(tmp_path: Path) -> None:
    assert load_measurements(saved(tmp_path / "s.npz")).scores.cameras == ("a", "b")


def test_a_missing_file_and_a_folder_are_told(tmp_path: Path) -> None:
    for path, told in ((tmp_path / "none", "does not exist"), (tmp_path, "is a folder, not a table")):
        with pytest.raises(InputError, match=told):
            read_arrays(path, wanted="a table", remedy="")


def test_nothing_is_unpacked_beyond_the_bound(tmp_path: Path) -> None:
    stream = io.BytesIO()
    np.savez(stream, a=np.zeros(1000))
    (tmp_path / "a.npz").write_bytes(stream.getvalue())
    with pytest.raises(DocumentError, match="0 MB unpacked, at most 0 MB are read"):
        read_arrays(tmp_path / "a.npz", wanted="a table", remedy="", most=1000)
