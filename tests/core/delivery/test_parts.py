"""A programme conformed in parts by real processes that know nothing of each other."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from two_cameras import EXPECTED, make, shown

from mcsl_core import edl as document
from mcsl_core.delivery.conform import conform
from mcsl_core.delivery.parts import Part
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.errors import UsageError

# `mcsl conform` with chunks of a second. After HIDDEN_S a chunk is seen by others: so long may a client of NFS remember
# that a name was not there (acdirmax, 60 s by default).
CHILD = """
import os, sys, time
from mcsl_core.delivery import chunk_keys
chunk_keys.CHUNK_S = 1
hidden_s, seen = float(sys.argv.pop(1)), os.stat
def stat(path, *args, **how):
    found = seen(path, *args, **how)
    if str(path).endswith(".mp4") and "conformed" in str(path) and time.time() - found.st_mtime < hidden_s:
        raise FileNotFoundError(2, "not seen yet", str(path))
    return found
os.stat = stat
from mcsl_core.cli.main import main
sys.exit(main())
"""


def start(folder: Path, *words: str, hidden_s: float = 0) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", CHILD, str(hidden_s), "--progress", "json", "conform", "edl.json", *words]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def ended(*children: subprocess.Popen[str]) -> list[int]:
    """How many chunks each has made."""
    told = [child.communicate(timeout=300)[0] for child in children]
    assert [child.returncode for child in children] == [0] * len(children), told
    return [int(text.rpartition('"made": ')[2].partition(",")[0]) for text in told]


def contents(folder: Path) -> dict[str, str]:
    files = [path for path in folder.iterdir() if path.suffix in (".mp4", ".wav") and not path.name.startswith(".")]
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


@pytest.fixture
def desk(sources: Path) -> Path:
    """The folder of the sources with the EDL in it, and nothing conformed."""
    document.save(make(), sources / "edl.json")
    return sources


@pytest.fixture
def undisturbed(sources: Path, tmp_path: Path) -> dict[str, str]:
    done = conform(ProgrammeSource(make(), sources), tmp_path / "whole")
    assert [n for chunk in done.chunks for n in shown(done.path(chunk))] == EXPECTED
    return contents(tmp_path / "whole")


@given(count=st.integers(0, 400), of=st.integers(1, 40))
def test_parts_are_the_whole_in_order_and_of_one_length(count: int, of: int) -> None:
    taken = [Part(number, of).taken(range(count)) for number in range(1, of + 1)]
    assert [item for part in taken for item in part] == list(range(count))
    assert max(map(len, taken)) - min(map(len, taken)) <= 1


@pytest.mark.parametrize("text", ["0/3", "4/3", "1", "1/0", "-1/3", "a/b", "1/3/4", "٣/٤"])
def test_what_is_no_part_is_a_wrong_call(text: str) -> None:
    with pytest.raises(UsageError, match="part"):
        Part.read(text)


def test_a_part_does_not_prune(sources: Path, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="does not know what others need"):
        conform(ProgrammeSource(make(), sources), tmp_path, prune=True, part=Part(1, 2))


def test_a_part_makes_its_stretch_alone_and_the_first_the_sound(sources: Path, tmp_path: Path) -> None:
    second = conform(ProgrammeSource(make(), sources), tmp_path, part=Part(2, 2))
    assert [n for chunk in second.chunks for n in shown(second.path(chunk))] == EXPECTED[60:]
    assert second.audio is None
    assert not list(tmp_path.glob("*.wav"))
    first = conform(ProgrammeSource(make(), sources), tmp_path, part=Part(1, 2))
    assert [n for chunk in first.chunks for n in shown(first.path(chunk))] == EXPECTED[:60]
    assert first.audio is not None
    assert conform(ProgrammeSource(make(), sources), tmp_path).made == 0


def test_jobs_on_one_folder_make_the_whole(desk: Path, tmp_path: Path, undisturbed: dict[str, str]) -> None:
    out = tmp_path / "conformed"
    parts = ("1/3", "2/3", "3/3", "1/2")  # the last is on the same chunks as the first two
    made = ended(*(start(desk, "-o", str(out), "--part", part) for part in parts))
    assert sum(made) >= 5
    assert contents(out) == undisturbed
    assert ended(start(desk, "-o", str(out))) == [0]
    assert contents(out) == undisturbed


def test_jobs_that_do_not_see_each_others_files_waste_time_and_harm_nothing(
    desk: Path, tmp_path: Path, undisturbed: dict[str, str]
) -> None:
    out = tmp_path / "conformed"
    assert ended(start(desk, "-o", str(out), "--part", "1/1")) == [5]
    late = start(desk, "-o", str(out), "--part", "1/2", hidden_s=1e6)
    others = start(desk, "-o", str(out), "--part", "1/1", hidden_s=1e6)
    while late.poll() is None or others.poll() is None:  # who reads meanwhile finds whole files alone
        assert contents(out) == undisturbed
    assert ended(late, others) == [2, 5]
    assert contents(out) == undisturbed
    assert not list(out.glob(".*"))
