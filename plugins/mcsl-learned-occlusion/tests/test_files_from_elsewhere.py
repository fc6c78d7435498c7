"""Models and marked frames as other people leave them: refused by name, never unpacked beyond what was said."""

from __future__ import annotations

import json
import tracemalloc
import zipfile
from pathlib import Path

import mcsl_learned_occlusion as plugin
import numpy as np
import pytest
from mcsl_learned_occlusion.features import NAMES
from mcsl_learned_occlusion.labelling import read_marked, save_arrays, save_png
from mcsl_learned_occlusion.model import CLASSES, SCHEMA, Model

from mcsl_core.hooks import InputError, discover

ONES = np.ones(len(NAMES), np.float32)
LAYER = np.ones((len(NAMES), len(CLASSES)), np.float32), np.ones(len(CLASSES), np.float32)


def saved(path: Path, **other: object) -> Path:
    """A right model but for the arrays ``other``."""
    Model(ONES, ONES, (LAYER,), CLASSES, {}).save(path)
    with np.load(path) as stored:
        arrays = dict(stored) | other
    np.savez_compressed(path, **arrays)  # pyright: ignore[reportArgumentType]
    return path


def head(**other: object) -> np.ndarray:
    right = {"schema": SCHEMA, "features": list(NAMES), "classes": list(CLASSES), "about": {}}
    return np.array(json.dumps({**right, **other}))


def packed(path: Path, shape: str, content: bytes, name: str = "mean.npy", *, times: int = 1) -> Path:
    """A file of one array that says it is of ``shape``."""
    text = f"{{'descr': '|i1', 'fortran_order': False, 'shape': {shape}, }}".encode()
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as out, out.open(name, "w") as entry:
        entry.write(b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text)
        for _ in range(times):
            entry.write(content)
    return path


HOSTILE = {
    "a zip bomb": lambda p: packed(p, "(300000000,)", bytes(1_000_000), times=300),
    "a shape beyond the file": lambda p: packed(p, "(1000000000000,)", bytes(80)),
    "a negative shape": lambda p: packed(p, "(-8,)", bytes(80)),
    "a zip of something else": lambda p: packed(p, "(8,)", bytes(8), "letter.txt"),
    "no zip": lambda p: p.write_bytes(b"no zip"),
    "empty": lambda p: p.write_bytes(b""),
    "cut short": lambda p: p.write_bytes(saved(p).read_bytes()[:-40]),
    "a pickle": lambda p: saved(p, mean=np.array([print], object)),
    "a layer without axes": lambda p: saved(p, weight0=np.float32(1)),
    "a layer of three axes": lambda p: saved(p, weight0=np.ones((2, *LAYER[0].shape), np.float32)),
    "a mean without axes": lambda p: saved(p, mean=np.float32(1)),
    "a head of two lines": lambda p: saved(p, head=np.array(["{}", "{}"])),
    "a list for a head": lambda p: saved(p, head=np.array("[]")),
    "classes that are lists": lambda p: saved(p, head=head(classes=[*CLASSES[:2], []])),
    "classes that are numbers": lambda p: saved(p, head=head(classes=[1, 2, 3])),
    "features that are a number": lambda p: saved(p, head=head(features=1)),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_model_from_elsewhere_is_refused_in_one_line(tmp_path: Path, monkeypatch, name: str) -> None:
    path = tmp_path / "model.npz"
    HOSTILE[name](path)
    monkeypatch.setenv(plugin.VARIABLE, str(path))
    detector = discover().choose("occlusion", "learned").implementation
    tracemalloc.start()
    try:
        with pytest.raises(InputError) as caught:
            detector.prepare()
        assert tracemalloc.get_traced_memory()[1] < 20_000_000, "bytes; nothing was unpacked"
    finally:
        tracemalloc.stop()
    assert "\n" not in str(caught.value)
    assert (caught.value.where, caught.value.remedy) == (str(path), "Train it again with `mcsl-label train`")


def test_the_model_that_they_are_made_of_is_taken(tmp_path: Path) -> None:
    assert Model.load(saved(tmp_path / "model.npz", head=head())).classes == CLASSES


CONTEXT = {
    "camera": np.array("a"),
    "moment": np.array("0"),
    "to_cut": np.eye(3),
    "seen.a": np.zeros((8, 8, 3), np.uint8),
    "inside.a": np.ones((8, 8), bool),
    "behind.a": np.zeros((8, 8, 3), np.uint8),
}
SPOILT = {
    "a zip bomb": lambda p: packed(p, "(300000000,)", bytes(1_000_000), times=300),
    "a shape beyond the file": lambda p: packed(p, "(1000000000000,)", bytes(80)),
    "no camera": lambda p: save_arrays(p, {k: v for k, v in CONTEXT.items() if k != "camera"}),
    "another size": lambda p: save_arrays(p, {**CONTEXT, "behind.a": np.zeros((9, 8, 3), np.uint8)}),
    "no colours": lambda p: save_arrays(p, {**CONTEXT, "seen.a": np.zeros((8, 8), np.uint8)}),
    "floats": lambda p: save_arrays(p, {**CONTEXT, "seen.a": np.zeros((8, 8, 3))}),
    "no mask": lambda p: save_arrays(p, {**CONTEXT, "inside.a": np.ones(8, bool)}),
    "a warp of words": lambda p: save_arrays(p, {**CONTEXT, "to_cut": np.array("abc")}),
}


@pytest.mark.parametrize("name", ["", *SPOILT])
def test_what_lies_beside_a_marked_frame_is_refused_in_one_line(tmp_path: Path, name: str) -> None:
    save_png(tmp_path / "1.png", np.zeros((8, 8, 3), np.uint8))
    save_png(tmp_path / "1.mask.png", np.full((8, 8, 3), (0, 255, 0), np.uint8))
    save_arrays(tmp_path / "1.npz", CONTEXT)
    if not name:
        assert [marked.camera for marked in read_marked(tmp_path)] == ["a"]
        return
    SPOILT[name](tmp_path / "1.npz")
    with pytest.raises(InputError) as caught:
        read_marked(tmp_path)
    assert "\n" not in str(caught.value)
    assert caught.value.where == str(tmp_path / "1.npz")
    assert "mcsl-label export" in caught.value.remedy
