"""What lies in a file's place: told by what it is, without hanging and without reading gigabytes."""

from __future__ import annotations

import os
import socket
from pathlib import Path

import pytest

from mcsl_core import edl as edls
from mcsl_core.documents import read_json
from mcsl_core.errors import McslError
from mcsl_core.input_files import MOST_BYTES, name_fault, read_bytes
from mcsl_core.json_text import DEEPEST, parse_json

FAULTS = Path(__file__).parents[2].parent / "shared" / "data" / "faults"


def pipe(path: Path) -> None:
    os.mkfifo(path)


def large(path: Path) -> None:
    with path.open("wb") as stream:
        stream.truncate(MOST_BYTES + 1)  # a hole: no disk is filled


def listening(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as made:
        made.bind(str(path))


IN_ITS_PLACE = {
    "nothing": (lambda p: None, "does not exist. Check the path"),
    "a folder": (Path.mkdir, "is a folder, not an EDL. Hand in the file that `mcsl analyse` wrote"),
    "a pipe": (pipe, "is a pipe, not an EDL. Save it as a file"),
    "a device": (lambda p: p.symlink_to("/dev/zero"), "is a device, not an EDL"),
    "a socket": (listening, "is a socket, not an EDL"),
    "a link that leads nowhere": (lambda p: p.symlink_to(p.with_name("gone")), "does not exist"),
    "a link to itself": (lambda p: p.symlink_to(p), "cannot be read (Too many levels"),
    "a large file": (large, "is larger than 64 MB: not an EDL"),
    "a video": (lambda p: p.write_bytes(b"\0\0\0\x20ftypisom" + bytes(99)), "is a video, not an EDL. Hand in the file"),
    "a Matroska": (lambda p: p.write_bytes(b"\x1aE\xdf\xa3\x9f" + bytes(99)), "is a video, not an EDL"),
    "a spreadsheet": (lambda p: p.write_bytes(b"PK\x03\x04" + bytes(99)), "is a zip file, such as a spreadsheet"),
    "a .blend": (lambda p: p.write_bytes(b"BLENDER-v405" + bytes(99)), "is a Blender file, not an EDL"),
    "nulls": (lambda p: p.write_bytes(bytes(99)), "is no text, not an EDL"),
    "Latin-1": (lambda p: p.write_bytes(b'{\n"a": "\xe9"}'), "line 2: is not UTF-8 text. Save it as UTF-8"),
    "nothing in it": (lambda p: p.write_bytes(b""), "is not JSON"),
    "half": (lambda p: p.write_bytes(b'{"schema": "mcsl.edl/1", "rat'), "line 1, column 26: is not JSON"),
    "a list": (lambda p: p.write_text("[]"), "an EDL is a JSON object"),
    "another's": (lambda p: p.write_text("{}"), "is missing; expected 'mcsl.edl/2'"),
}


@pytest.mark.skipif(os.name == "nt", reason="pipes and devices are files elsewhere")
@pytest.mark.parametrize("name", IN_ITS_PLACE)
def test_what_lies_in_an_edls_place_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.chdir(tmp_path)  # sockets have short paths
    make, told = IN_ITS_PLACE[name]
    make(Path("edl.json"))
    with pytest.raises(McslError) as refused:
        edls.load("edl.json")
    assert str(refused.value).startswith("edl.json")
    assert told in str(refused.value)


@pytest.mark.parametrize("path", ["a\0b", "x" * 300, "/".join(["x" * 200] * 30), "a/\ud800"])
def test_a_path_that_no_file_can_have_is_told(path: str) -> None:
    assert name_fault(path)
    with pytest.raises(McslError, match=r"cannot be read|no name that a file can have"):
        read_bytes(Path(path))


def test_a_real_recording_is_called_a_video() -> None:
    path = FAULTS / "interlaced" / "cam1.mp4"
    if not path.is_file():
        pytest.skip("the material is not here")
    with pytest.raises(McslError, match="is a video, not an EDL"):
        edls.load(path)


def test_utf_16_with_its_mark_is_read(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_bytes('{"a": "é"}'.encode("utf-16"))
    assert read_json(tmp_path / "a.json") == {"a": "é"}


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[1e999]", "1e999 is too large a number"),
        ("[" + "9" * 5000 + "]", "a number has thousands of digits"),
        ("[NaN]", "NaN is not a number"),
        ("[" * 100_000, "is nested too deeply"),
        ("[" * (DEEPEST + 1) + "]" * (DEEPEST + 1), "is nested too deeply"),
        ('["\\ud800"]', "no Unicode"),
        ('{"a": 1, "a": 2}', "the key 'a' stands twice"),
    ],
)
def test_json_that_could_not_be_worked_with_is_refused(text: str, told: str) -> None:
    with pytest.raises(McslError, match=told):
        parse_json(text, where="a.json")


def test_bytes_of_a_file_name_and_real_pairs_are_text() -> None:
    assert parse_json('["\\udcff", "\\ud83d\\ude00"]', where="") == ["\udcff", "\U0001f600"]
