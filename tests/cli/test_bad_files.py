"""Every command and every file that it takes, handed whatever else may lie there: told in one line, no traceback."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from builders import small_edl

from mcsl_core import edl as edls
from mcsl_core.cli.main import _told, cli, main


def wrong(path: Path, **changes: object) -> None:
    value = edls.to_json(small_edl())
    path.write_text(json.dumps({**value, **changes}), "utf-8")


KINDS = {
    "missing": lambda p: None,
    "empty": lambda p: p.write_bytes(b""),
    "folder": lambda p: p.mkdir(),
    "pipe": os.mkfifo,
    "link to a pipe": lambda p: (os.mkfifo(p.with_name("pipe")), p.symlink_to(p.with_name("pipe"))),
    "link to itself": lambda p: p.symlink_to(p),
    "binary": lambda p: p.write_bytes(bytes(range(256)) * 8),
    "video": lambda p: p.write_bytes(b"\0\0\0\x20ftypisom" + bytes(2000)),
    "zip": lambda p: p.write_bytes(b"PK\x03\x04" + bytes(200)),
    "blend": lambda p: p.write_bytes(b"BLENDER-v405" + bytes(200)),
    "text": lambda p: p.write_text("Dear colleague,\n\nhere is the recording.\n"),
    "other document": lambda p: p.write_text('{"schema": "mcsl.preset/1", "title": "x"}'),
    "list": lambda p: p.write_text("[[[[]]]]"),
    "truncated": lambda p: p.write_text(json.dumps(edls.to_json(small_edl()))[:-200]),
    "wrong types": lambda p: wrong(p, frames="many", cameras=3),
    "huge numbers": lambda p: wrong(p, frames=10**400),
    "infinite": lambda p: p.write_text('{"schema": "mcsl.edl/1", "rate": 1e999}'),
    "deep": lambda p: p.write_text("[" * 50_000),
    "media gone": lambda p: wrong(p),
    "media null": lambda p: wrong(p, scores="a\0b"),
    "long cell": lambda p: p.write_text("time,x,y\n" + "1" * 140_000),
    "markup": lambda p: p.write_text("[/]"),
}


def walked(group: click.Group, name: str = "") -> Iterator[tuple[str, click.Command]]:
    for key, command in group.commands.items():
        if isinstance(command, click.Group):
            yield from walked(command, f"{name}{key} ")
        else:
            yield name + key, command


def is_path(param: click.Parameter) -> bool:
    return isinstance(param.type, click.Path) or param.name in ("preset", "blender")


OUTPUTS = ("out", "csv_file", "json_file")
DONE = {(name, "edl", "media gone") for name in ("field", "look", "remove", "report")}  # they need no media
CASES = [
    (name, param.name)
    for name, command in walked(cli)
    for param in command.params
    if is_path(param) and (name, param.name) not in {("demo", "folder"), ("simulate", "out"), ("plugin new", "out")}
]
SUFFIX = {"preset": ".json", "document": ".blend", "manual": ".csv", "gaze": ".csv", "study": ".csv"}


def arguments(name: str, bad: str, path: Path, folder: Path) -> list[str]:
    """The command with ``path`` for its parameter ``bad`` and files that are right, or at least there, for others."""
    command = dict(walked(cli))[name]
    good = folder / "good.json"
    edls.save(small_edl(), good)
    said = name.split()
    for param in command.params:
        needed = param.required or param.name in (bad, "edl")
        if param.name == "edl" and (bad == "study" or (name == "pull" and path.suffix == ".blend")):
            continue
        if not needed:
            continue
        others = {"out": folder / "new.mp4", "document": folder / "cut.otio"}
        value = path if param.name == bad else others.get(param.name, good)
        said += [str(value)] if isinstance(param, click.Argument) else [param.opts[-1], str(value)]
    return said


@pytest.mark.skipif(os.name == "nt", reason="pipes and devices are files elsewhere")
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("name", "param"), CASES, ids=lambda value: str(value))
def test_no_command_shows_a_traceback(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, param: str, kind: str
) -> None:
    path = tmp_path / "a [" / f"] [bold] file{SUFFIX.get(param, '.json')}"  # together: [/], which ends a markup
    path.parent.mkdir()
    KINDS[kind](path)
    before = path.read_bytes() if path.is_file() else None
    code = main(arguments(name, param, path, tmp_path))
    said = capsys.readouterr()
    assert "Traceback" not in said.err + said.out
    assert "internal error" not in said.err
    may = (name, param, kind) in DONE or param in OUTPUTS
    assert code in (2, 3, 4) or (may and code == 0), said.out
    if path.is_fifo():
        assert code != 0
    if before is not None and param not in OUTPUTS:
        assert path.read_bytes() == before


@pytest.fixture
def in_japanese(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LANGUAGE", "ja")


@pytest.mark.skipif(os.name == "nt", reason="pipes and devices are files elsewhere")
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("name", "param", "suffix"),
    [
        ("look", "edl", ".json"),
        ("evaluate", "manual", ".csv"),
        ("evaluate", "study", ".csv"),
        ("render", "preset", ".json"),
        ("pull", "document", ".otio"),
        ("pull", "document", ".fcpxml"),
        ("pull", "document", ".edl"),
    ],
)
@pytest.mark.usefixtures("in_japanese")
def test_what_is_wrong_is_told_in_japanese(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, param: str, suffix: str, kind: str
) -> None:
    path = tmp_path / f"file{suffix}"
    KINDS[kind](path)
    if main(arguments(name, param, path, tmp_path)) == 0:
        return
    said = capsys.readouterr().err.replace(str(tmp_path), "")
    assert re.search("[ぁ-ん]", said)
    ours = re.sub(r"（[A-Z]\w+Error: .*?）", "", said)  # what Python says of itself stays
    assert not re.search(r"[A-Za-z]{3,} [a-z]{2,} [a-z]{3,}|(は|が|を|で)(a|an) [a-z]", ours), "an English sentence"


@pytest.mark.skipif(os.name == "nt", reason="pipes and devices are files elsewhere")
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("suffix", [".fcpxml", ".xml", ".otio", ".edl"])
def test_no_document_of_another_editor_shows_a_traceback(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], suffix: str, kind: str
) -> None:
    path = tmp_path / f"cut{suffix}"
    KINDS[kind](path)
    assert main(arguments("pull", "document", path, tmp_path)) == 3
    said = capsys.readouterr().err
    assert "Traceback" not in said
    assert "internal error" not in said
    assert str(path) in said


@pytest.mark.parametrize(("name", "param"), CASES, ids=lambda value: str(value))
def test_a_name_that_no_file_can_have_is_a_wrong_call(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, param: str
) -> None:
    code = main(arguments(name, param, tmp_path / ("x" * 300 + SUFFIX.get(param, ".json")), tmp_path))
    said = capsys.readouterr().err
    assert code in (2, 3, 4)
    assert "internal error" not in said


@pytest.mark.parametrize(
    ("error", "told"),
    [
        (MemoryError(), "mcsl conform: the memory does not suffice. Close other programs, take fewer --jobs"),
        (MemoryError("Unable to allocate 9 GiB"), "the memory does not suffice (Unable to allocate 9 GiB)"),
        (
            RuntimeError("OpenCV: Insufficient memory (Failed to allocate 9 bytes) in function 'OutOfMemoryError'"),
            "suffice",
        ),
        (OSError(28, "No space left on device", "/a/b"), "/a/b: No space left on device. Check the path"),
        (RuntimeError("Symlink loop from '/a/b'"), "/a/b: is a link that leads to itself"),
    ],
)
def test_what_the_machine_lacks_is_told_with_what_to_do(error: Exception, told: str) -> None:
    assert told in str(_told(error, ["--progress", "none", "conform", "edl.json"]))


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (["analyse", "r", "-o", "e.json", "--rate", "fast"], "--rate: expected a rate such as '30000/1001' or '25'"),
        (["analyse", "r", "-o", "e.json", "--rate", "1/999999999"], "--rate: a rate must lie in 0.01 to 1000"),
        (["simulate", "r", "--rate", "fast"], "--rate: expected a rate"),
        (["simulate", "r", "--size", "1000000x1000000"], "size"),
        (["simulate", "r", "--cameras", "100000"], "cameras"),
        (["simulate", "r", "--duration", "1e999"], "duration"),
        (["render", "e.json", "-o", "x.mp4", "--jobs", "0"], "--jobs"),
        (["conform", "e.json", "--jobs", "-1"], "--jobs"),
        (["evaluate", "good.json", "--manual-fit", "similarity"], "--manual-fit says what --manual becomes"),
        (["evaluate", "good.json", "--every", "-1"], "--every"),
        (["evaluate", "good.json", "--size", "1000000000"], "--size"),
    ],
)
def test_a_wrong_option_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], call: list[str], told: str
) -> None:
    monkeypatch.chdir(tmp_path)
    edls.save(small_edl(), "good.json")
    assert main(call) == 2
    assert told in capsys.readouterr().err


def test_a_camera_whose_file_name_is_no_text_comes_into_the_report(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = json.dumps(edls.to_json(small_edl())).replace("cam1", "cam\\udcff")
    (tmp_path / "e.json").write_text(text, "utf-8")
    assert main(["report", str(tmp_path / "e.json"), "-o", str(tmp_path / "r.html")]) == 0, capsys.readouterr().err
    assert "cam\\udcff" in (tmp_path / "r.html").read_text("utf-8")
