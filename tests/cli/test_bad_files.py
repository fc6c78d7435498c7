"""Every command and every file that it takes, handed whatever else may lie there: told in one line, no traceback."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from builders import small_edl

from mcsl_core import edl as edls
from mcsl_core.cli.main import cli, main


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
DONE = {("look", "edl", "media gone"), ("report", "edl", "media gone")}  # they need no media
CASES = [
    (name, param.name)
    for name, command in walked(cli)
    for param in command.params
    if is_path(param) and (name, param.name) not in {("demo", "folder"), ("simulate", "out"), ("plugin new", "out")}
]
SUFFIX = {"preset": ".json", "blend": ".blend", "manual": ".csv", "gaze": ".csv", "study": ".csv"}


def arguments(name: str, bad: str, path: Path, folder: Path) -> list[str]:
    """The command with ``path`` for its parameter ``bad`` and files that are right, or at least there, for others."""
    command = dict(walked(cli))[name]
    good = folder / "good.json"
    edls.save(small_edl(), good)
    said = name.split()
    for param in command.params:
        needed = param.required or param.name in (bad, "edl")
        if bad == "study" and param.name == "edl":
            continue
        if not needed:
            continue
        value = path if param.name == bad else folder / "new.mp4" if param.name == "out" else good
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


@pytest.mark.parametrize(("name", "param"), CASES, ids=lambda value: str(value))
def test_a_name_that_no_file_can_have_is_a_wrong_call(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, param: str
) -> None:
    code = main(arguments(name, param, tmp_path / ("x" * 300 + SUFFIX.get(param, ".json")), tmp_path))
    said = capsys.readouterr().err
    assert code in (2, 3, 4)
    assert "internal error" not in said
