"""Closed, full and broken standard streams, as services, scripts and closed terminals leave them: real processes."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from builders import small_edl

from mcsl_core import edl as edls

pytestmark = pytest.mark.skipif(os.name == "nt", reason="a shell's redirections")
CLOSED = ["<&-", ">&-", "2>&-", ">&- 2>&-", "<&- >&- 2>&-"]
needs_full = pytest.mark.skipif(not Path("/dev/full").exists(), reason="the system has no /dev/full")


def mcsl(tmp_path: Path, arguments: str, redirection: str) -> tuple[int, str, str]:
    """The exit code, and what came to standard output and error where they were left."""
    command = f'"{sys.executable}" -m mcsl_core.cli {arguments} {redirection}'
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        ["bash", "-c", command], capture_output=True, text=True, cwd=tmp_path, env=environment, timeout=60, check=False
    )
    return done.returncode, done.stdout, done.stderr


@pytest.fixture
def edl(tmp_path: Path) -> Path:
    path = tmp_path / "edl.json"
    edls.save(small_edl(300), path)
    return path


@pytest.mark.parametrize("redirection", CLOSED)
@pytest.mark.parametrize("mode", ["", "--progress json "])
def test_closed_streams_change_nothing_but_what_is_told(tmp_path: Path, edl: Path, redirection: str, mode: str) -> None:
    code, out, err = mcsl(tmp_path, f"{mode}look edl.json --no-fill", redirection)
    assert (code, err) == (0, "")
    assert not edls.load(edl).look.fill
    assert bool(out) == (" >&-" not in f" {redirection}")
    assert mcsl(tmp_path, f"{mode}look nothing.json", redirection)[0] == 3


def test_what_is_opened_next_does_not_stand_where_others_print(tmp_path: Path) -> None:
    """Without, the file had descriptor 2, and what C's libraries print went into it."""
    code = (
        "from mcsl_core.cli.streams import open_closed; open_closed(); import os; "
        "file = open('film.mp4', 'wb', 0); os.write(2, b'a warning'); os.write(1, b'another')"
    )
    command = f'"{sys.executable}" -c "{code}" <&- >&- 2>&-'
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    assert subprocess.run(["bash", "-c", command], cwd=tmp_path, env=environment, check=False).returncode == 0
    assert (tmp_path / "film.mp4").read_bytes() == b""


@needs_full
@pytest.mark.parametrize("mode", ["", "--progress json "])
def test_a_result_that_cannot_be_written_is_told_in_one_line(tmp_path: Path, edl: Path, mode: str) -> None:
    code, _, err = mcsl(tmp_path, f"{mode}look edl.json", ">/dev/full")
    assert code == 4
    assert err.startswith("mcsl: mcsl look: No space left on device. Make room")
    assert err.count("\n") == 1


@needs_full
@pytest.mark.parametrize("arguments", ["look edl.json", "--progress json look edl.json", "plugins --json"])
@pytest.mark.parametrize("redirection", ["2>/dev/full", "2> >(true)"])
def test_work_goes_on_where_nobody_can_be_told(tmp_path: Path, edl: Path, arguments: str, redirection: str) -> None:
    """Its terminal was closed, its log is on a full disk: hours of work ended by that."""
    code, out, _ = mcsl(tmp_path, arguments, redirection)
    assert code == 0
    assert out
    assert mcsl(tmp_path, "--progress lines evaluate nothing.json", redirection)[0] == 3


def test_who_reads_no_further_ends_it_quietly(tmp_path: Path, edl: Path) -> None:
    assert mcsl(tmp_path, "look edl.json", "| true")[2] == ""


CONSOLE = """
import io, sys
from mcsl_core.cli.streams import own_output

class Console(io.RawIOBase):  # as Windows has one, which takes UTF-8 for text
    def fileno(self): return 2
    def writable(self): return True
    def isatty(self): return True
    def write(self, data): print(ascii(bytes(data).decode()), file=sys.__stderr__); return len(data)

if sys.argv[1] == "console":
    sys.stderr = io.TextIOWrapper(io.BufferedWriter(Console()), "utf-8", line_buffering=True)
before = sys.stderr
own_output()
print(sys.stderr is before, flush=True, file=sys.stderr)
print("größer", file=sys.stderr)
own_output()
"""


@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize("kind", ["console", "file"])
def test_a_console_that_is_no_file_stays_what_one_writes_to(tmp_path: Path, kind: str, unbuffered: str) -> None:
    script = tmp_path / "script.py"
    script.write_text(CONSOLE, encoding="utf-8")
    python = {"PYTHONPATH": os.pathsep.join(sys.path), "PYTHONIOENCODING": "utf-8", "PYTHONUNBUFFERED": unbuffered}
    command = [sys.executable, str(script), kind]
    done = subprocess.run(
        command, capture_output=True, encoding="utf-8", env=os.environ | python, timeout=60, check=True
    )
    told = {"console": "'True\\n'\n'gr\\xf6\\xdfer\\n'\n", "file": "False\ngrößer\n"}
    assert done.stderr == told[kind]
