"""Conform and render with decoding hardware asked for: the same media, and a word where the processor decodes."""

import json

import pytest
from click.testing import CliRunner
from two_cameras import EXPECTED, make, shown

from mcsl_core import edl as edls
from mcsl_core.cli.main import cli
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.edl.edits import rebased
from mcsl_core.errors import UsageError


def run(*arguments):
    done = CliRunner().invoke(cli, ["--progress", "json", *map(str, arguments)], standalone_mode=False)
    if done.exception is not None:
        raise done.exception
    return [json.loads(line) for line in done.stdout.splitlines()]


def test_the_same_chunks_and_pictures_whatever_decodes(sources, tmp_path):
    edl = tmp_path / "edl.json"
    edls.save(rebased(make(), sources, tmp_path), edl)
    plain = run("conform", edl, "-o", tmp_path / "plain", "--allow-outside")
    asked = run("conform", edl, "-o", tmp_path / "asked", "--hwaccel", "auto")
    names = [{path.name: path.read_bytes() for path in (tmp_path / n).glob("*.mp4")} for n in ("plain", "asked")]
    assert names[0].keys() == names[1].keys()
    assert names[0] == names[1]
    assert not any("hardware" in str(line) for line in plain)
    assert len(asked) >= len(plain)
    run("render", edl, "-o", tmp_path / "out.mp4", "--engine", "direct", "--hwaccel", "cuda")
    assert shown(tmp_path / "out.mp4") == EXPECTED


def test_hardware_of_no_such_name_is_refused(sources):
    with pytest.raises(UsageError, match="no decoding hardware called 'magic'"):
        ProgrammeSource(make(), sources, hwaccel="magic")
