"""Encoders that make threads the most urgent of the machine, and how they are made ordinary again."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

_THREADS = Path("/proc/self/task")


@contextlib.contextmanager
def scheduled_as_before() -> Iterator[None]:
    """Whatever an encoder does to this thread's scheduling within is undone, to the threads that it started as well.

    Notes
    -----
    Where root opens SVT-AV1 (4.1, and versions before), it puts the calling thread and its own under SCHED_FIFO at
    priority 99. The machine's other work then stands still, and so does every other thread of two processes that were
    started by it: seen for ten minutes on two cores. Linux alone; elsewhere nothing is done.
    """
    if sys.platform != "linux" or not _THREADS.exists():
        yield
        return
    policy, parameters = os.sched_getscheduler(0), os.sched_getparam(0)
    there = set(os.listdir(_THREADS))
    try:
        yield
    finally:
        for thread in (threading.get_native_id(), *map(int, set(os.listdir(_THREADS)) - there)):
            with contextlib.suppress(OSError):  # it has ended
                if os.sched_getscheduler(thread) != policy:
                    os.sched_setscheduler(thread, policy, parameters)
