"""`mcsl remove`: what it writes into the EDL, what it says, and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from builders import R, small_edl
from click.testing import CliRunner

from mcsl_core import edl as edls
from mcsl_core.cli.main import cli
from mcsl_core.errors import UsageError


@pytest.fixture
def edl(tmp_path: Path) -> Path:
    path = tmp_path / "edl.json"
    edls.save(small_edl(300), path)
    return path


def remove(edl: Path, *arguments: str) -> str:
    done = CliRunner().invoke(cli, ["remove", str(edl), *arguments], standalone_mode=False)
    if done.exception is not None:
        raise done.exception
    return done.output


def test_stretches_are_removed_told_and_brought_back(edl: Path) -> None:
    rate = edls.load(edl).rate
    assert "nothing is removed" in remove(edl)
    remove(edl, "--from", "2", "--to", "4")
    told = remove(edl, "--range", "130:160")
    assert edls.load(edl).removed == (R(round(2 * rate), round(4 * rate)), R(130, 160))
    assert "0:00:02.0 to 0:00:04.0: removed" in told
    before = edl.read_bytes()
    assert remove(edl) == told
    assert edl.read_bytes() == before
    remove(edl, "--bring-back", "--range", "140:300")
    assert edls.load(edl).removed[-1] == R(130, 140)
    assert edls.load(edl).frames == 300
    remove(edl, "--bring-back")
    assert "removed" not in json.loads(edl.read_text("utf-8"))


@pytest.mark.parametrize(
    ("arguments", "fault"),
    [
        (("--range", "0:300"), "nothing would be delivered"),
        (("--range", "0:301"), "not in the programme"),
        (("--range", "0:5", "--from", "3"), "given in frames"),
        (("--from", "soon"), "is no time"),
    ],
)
def test_what_cannot_be_is_refused_and_changes_nothing(edl: Path, arguments: tuple[str, ...], fault: str) -> None:
    before = edl.read_bytes()
    with pytest.raises(UsageError, match=fault):
        remove(edl, *arguments)
    assert edl.read_bytes() == before
