"""Processes that this one has started and that must not outlive it, and work that is done in one."""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import traceback
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

from .errors import McslError

T = TypeVar("T")

_running: set[subprocess.Popen[Any]] = set()
_BEAT_S = 0.1
_SERVE = "from mcsl_core.children import serve; serve()"


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


def in_child(work: Callable[[Callable[[int], None]], T], told: Callable[[int], None]) -> T:
    """What ``work`` returns, done in a Python of its own, which waits for no other thread's lock.

    Parameters
    ----------
    work
        What can be pickled; given a function that it calls with a count of what is done.
    told
        Called with the latest count ten times a second, changed or not. Where it raises, the child is ended.

    Returns
    -------
    Any
        The same as ``work(told)`` here.

    Raises
    ------
    McslError
        As ``work`` raised it; or where the child ended without an answer.
    RuntimeError
        Whatever else ``work`` raised, as text.

    Notes
    -----
    The child ends with this process, however that ends: it waits for the end of its standard input.
    """
    # -P: nothing from the folder that the person happens to stand in.
    command = [sys.executable, "-P", "-c", _SERVE]
    paths = os.pathsep.join(os.path.abspath(folder) for folder in sys.path)
    with tempfile.TemporaryFile() as words:
        child = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=words,
            env=os.environ | {"PYTHONPATH": paths},
            start_new_session=True,  # Ctrl-C is ours to hear
        )
        try:
            with ended_afterwards(child):
                return _asked(child, work, told)
        except (EOFError, OSError, pickle.UnpicklingError) as error:
            words.seek(0)
            last = words.read().decode(errors="replace").strip().splitlines()[-8:]
            raise McslError(
                "\n".join([f"a process of this work ended with code {child.returncode} and no answer", *last]),
                remedy="Run again with fewer things open",
            ) from error
        finally:
            for stream in (child.stdin, child.stdout):
                with contextlib.suppress(OSError):  # what it did not take any more
                    stream.close()  # type: ignore[union-attr]


def _asked(child: subprocess.Popen[bytes], work: Any, told: Callable[[int], None]) -> Any:
    assert child.stdin is not None
    assert child.stdout is not None
    pickle.dump(work, child.stdin, pickle.HIGHEST_PROTOCOL)
    child.stdin.flush()
    while True:
        kind, value = pickle.load(child.stdout)
        if kind == "done":
            told(value)
        elif kind == "raised":
            raise value
        else:
            return value


class _Answering:
    """The child's side: messages to the parent on what was its standard output."""

    def __init__(self) -> None:
        self._out = os.fdopen(os.dup(1), "wb")
        os.dup2(2, 1)  # what a library prints does not come between them
        self._done = 0
        self._ended = threading.Event()
        self._beating = threading.Thread(target=self._beat, daemon=True)
        self._beating.start()

    def count(self, done: int) -> None:
        self._done = done

    def answer(self, kind: str, value: Any) -> None:
        self._ended.set()
        self._beating.join()
        self._send("done", self._done)
        self._send(kind, value)

    def _beat(self) -> None:
        while not self._ended.wait(_BEAT_S):
            self._send("done", self._done)

    def _send(self, kind: str, value: Any) -> None:
        try:
            pickle.dump((kind, value), self._out, pickle.HIGHEST_PROTOCOL)
            self._out.flush()
        except OSError:  # nobody listens any more
            os._exit(1)


def serve() -> None:
    """Does the work that the parent hands over on standard input."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # where it has no session of its own
    parent = _Answering()
    try:
        work = pickle.load(sys.stdin.buffer)
        threading.Thread(target=_end_with_parent, daemon=True).start()
        parent.answer("returned", work(parent.count))
    except McslError as error:
        parent.answer("raised", error)
    except Exception as error:
        parent.answer("raised", RuntimeError("".join(traceback.format_exception(error))))


def _end_with_parent() -> None:
    os.read(sys.stdin.fileno(), 1)  # not of the buffer, whose lock the interpreter's end would wait for
    os._exit(1)
