"""Work in a process of its own: answers, errors and ends, with real processes throughout."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import child_work
import pytest

from mcsl_core.children import in_child
from mcsl_core.errors import Cancelled, McslError, MediaError


def is_gone(process: int) -> bool:
    for _ in range(200):
        try:
            os.kill(process, 0)
        except ProcessLookupError:
            return True
        if sys.platform == "linux" and " Z " in Path(f"/proc/{process}/stat").read_text():
            return True
        time.sleep(0.05)
    return False


def number_in(note: Path) -> int:
    until = time.monotonic() + 60
    while not note.exists() and time.monotonic() < until:
        time.sleep(0.02)
    return int(note.read_text())


def test_the_answer_and_the_counts_come_from_another_process():
    counts: list[int] = []
    process = in_child(child_work.its_process, counts.append)
    assert process != os.getpid()
    assert counts[-1] == 7
    assert is_gone(process)


def test_what_the_work_refuses_is_refused_here():
    with pytest.raises(MediaError) as caught:
        in_child(child_work.refuses, child_work.ignore)
    assert str(caught.value) == "cam1.mp4: ends early. Copy it again"


def test_another_error_keeps_its_trace():
    with pytest.raises(RuntimeError, match=r"(?s)child_work.py.*ZeroDivisionError: by its own fault"):
        in_child(child_work.fails, child_work.ignore)


def test_a_child_that_dies_is_told_with_its_last_words():
    with pytest.raises(McslError, match=r"(?s)code 9 and no answer.last words"):
        in_child(child_work.dies, child_work.ignore)


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGKILL")
def test_a_child_that_is_killed_is_told():
    with pytest.raises(McslError, match=f"code {-signal.SIGKILL} and no answer"):
        in_child(child_work.is_killed, child_work.ignore)


def test_who_is_told_may_stop_it(tmp_path):
    note, found = tmp_path / "process", []

    def told(done: int) -> None:
        if note.exists():
            found.append(number_in(note))
            raise Cancelled

    with pytest.raises(Cancelled):
        in_child(partial(child_work.sleeps, note), told)
    assert is_gone(found[0])


@pytest.mark.skipif(os.name == "nt", reason="asks for processes by signals")
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_a_child_ends_with_its_parent_however_that_ends(tmp_path, number):
    note = tmp_path / "process"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    code = "import sys, child_work; child_work.sleeps_apart(sys.argv[1])"
    parent = subprocess.Popen([sys.executable, "-c", code, str(note)], env=environment, stderr=subprocess.DEVNULL)
    child = number_in(note)
    parent.send_signal(number)
    parent.wait()
    assert is_gone(child)
