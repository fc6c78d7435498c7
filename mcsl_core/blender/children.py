"""Processes that this one has started and that must not outlive it."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
from collections.abc import Iterator
from typing import Any

_running: set[subprocess.Popen[Any]] = set()


@contextlib.contextmanager
def ended_afterwards(child: subprocess.Popen[Any]) -> Iterator[None]:
    """Within it ``child`` runs; afterwards it and whatever it started are gone."""
    _running.add(child)
    try:
        yield
    finally:
        _end(child)
        child.wait()
        _running.discard(child)


def end_all() -> None:
    """Ends every child that still runs, for who has no time for the orderly way."""
    for child in list(_running):
        with contextlib.suppress(OSError):
            _end(child)


def _end(child: subprocess.Popen[Any]) -> None:
    if child.poll() is not None:
        return
    if os.name != "nt" and os.getpgid(child.pid) == child.pid:  # it was given a session of its own
        os.killpg(child.pid, signal.SIGKILL)
    else:
        child.kill()
