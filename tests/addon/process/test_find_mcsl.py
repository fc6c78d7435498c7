"""Which mcsl is run, and what is said where there is none."""

from __future__ import annotations

import os
import shutil
import stat
import sys
from pathlib import Path

import pytest

from blender_addon.process import find_mcsl as finding
from mcsl_core import __version__
from mcsl_core.errors import InputError

pytestmark = pytest.mark.skipif(os.name == "nt", reason="the programs here are shell scripts")


def program(path: Path, text: str = "#!/bin/sh\nexit 0\n") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return path


def test_the_order(tmp_path):
    home, path = tmp_path / "home", tmp_path / "on-path"
    usual = program(home / ".local" / "bin" / "mcsl")
    environ = {"PATH": str(path)}
    assert finding.find("", environ, home).path == usual
    on_path = program(path / "mcsl")
    assert finding.find("", environ, home).path == on_path
    named = program(tmp_path / "named")
    assert finding.find("", {**environ, "MCSL": str(named)}, home) == finding.Found(named, "MCSL")
    assert finding.find(str(usual), {**environ, "MCSL": str(named)}, home).path == usual


@pytest.mark.parametrize(
    "place",
    [
        ".local/bin/mcsl",
        ".local/share/pipx/venvs/mcsl/bin/mcsl",
        ".local/pipx/venvs/mcsl/bin/mcsl",
        ".local/share/uv/tools/mcsl/bin/mcsl",
        "Library/Python/3.12/bin/mcsl",
    ],
)
def test_the_usual_places(tmp_path, place):
    found = program(tmp_path / place)
    assert finding.find("", {"PATH": ""}, tmp_path).path == found


def test_a_virtual_environment_that_is_switched_on(tmp_path):
    found = program(tmp_path / "venv" / "bin" / "mcsl")
    assert finding.find("", {"PATH": "", "VIRTUAL_ENV": str(tmp_path / "venv")}, tmp_path).path == found


def test_none_names_the_one_command_that_installs_it(tmp_path, monkeypatch):
    monkeypatch.setattr(finding, "usual_places", lambda environ, home: [tmp_path])
    with pytest.raises(InputError) as caught:
        finding.find("", {"PATH": ""}, tmp_path)
    assert finding.INSTALL in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_what_is_named_and_not_there_is_no_reason_to_take_another(tmp_path):
    program(tmp_path / ".local" / "bin" / "mcsl")
    for preferred, environ in (("/no/such/mcsl", {}), ("", {"MCSL": "/no/such/mcsl"})):
        with pytest.raises(InputError, match="is not a program"):
            finding.find(preferred, {"PATH": "", **environ}, tmp_path)


def test_its_version_is_asked():
    real = shutil.which("mcsl", path=str(Path(sys.executable).parent))
    assert real
    assert finding.version_of(Path(real)) == __version__


@pytest.mark.parametrize("text", ["#!/bin/sh\necho hello\n", "#!/bin/sh\nexit 3\n", "not a program at all"])
def test_what_is_no_mcsl_is_refused(tmp_path, text):
    with pytest.raises(InputError) as caught:
        finding.version_of(program(tmp_path / "mcsl", text))
    assert "mcsl" in str(caught.value)
