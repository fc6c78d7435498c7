"""Work for a process of its own: `mcsl_core.children.in_child` takes what can be imported there."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from mcsl_core.children import in_child
from mcsl_core.errors import MediaError
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate

Told = Callable[[int], None]


def its_process(told: Told) -> int:
    print("a library's chatter")
    told(7)
    time.sleep(0.35)
    return os.getpid()


def refuses(told: Told) -> None:
    raise MediaError("ends early", where="cam1.mp4", remedy="Copy it again")


def fails(told: Told) -> None:
    raise ZeroDivisionError("by its own fault")


def dies(told: Told) -> None:
    print("last words", file=sys.stderr, flush=True)
    os._exit(9)


def is_killed(told: Told) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def sleeps(note: Path, told: Told) -> None:
    """Writes down its process and does nothing for minutes."""
    part = note.with_suffix(".part")
    part.write_text(str(os.getpid()))
    part.replace(note)
    time.sleep(600)


def films_on_one_core(out: Path, scenario: Scenario, told: Told) -> None:
    os.sched_setaffinity(0, list(os.sched_getaffinity(0))[:1])
    simulate(scenario, out, Silent(), ideal=True)


def ignore(done: int) -> None:
    """Takes a count."""


def sleeps_apart(note: str) -> None:
    """A parent for the tests to kill."""
    in_child(partial(sleeps, Path(note)), ignore)
