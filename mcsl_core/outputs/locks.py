"""Who may write now: locks between processes, beside what they guard.

The system lets go of a lock when its process ends, however that ends; what lies there afterwards is an empty promise
that the next one takes over.
"""

from __future__ import annotations

import contextlib
import errno
import logging
import os
from collections.abc import Callable, Iterator
from hashlib import sha256
from pathlib import Path

import filelock

from mcsl_core.errors import BusyError, McslError, writing

PATIENCE_S = 30.0  # for a change to a document, which takes a moment
_LONGEST = 200  # bytes of a name: with what stands round it, it stays below the 255 that file systems take
_CANNOT_LOCK = {errno.ENOLCK, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL}
_log = logging.getLogger(__name__)


def lock_file(path: Path, what: str = "") -> Path:
    """The hidden file that stands for the right to write ``path``: one name, whatever way leads there."""
    real = Path(os.path.realpath(path))
    name, kind = real.name, f".{what}" if what else ""
    if len(os.fsencode(name)) > _LONGEST:
        name = sha256(os.fsencode(name)).hexdigest()[:20]
    return real.with_name(f".{name}{kind}.lock")


@contextlib.contextmanager
def changing(path: Path, patience_s: float = PATIENCE_S) -> Iterator[None]:
    """Held while a document is read, changed and written, so that no change of another process is lost between.

    Raises
    ------
    McslError
        Where another process holds it for longer than any change takes.
    """
    with _held(path, "", patience_s) as holder:
        if holder is not None:
            raise McslError(
                f"another mcsl{holder} is writing it", where=str(path), remedy="Wait for it to end, then try again"
            )
        yield


@contextlib.contextmanager
def alone(path: Path, what: str) -> Iterator[None]:
    """Held for the whole of a long work of which one at a time makes sense; another is refused at once.

    Raises
    ------
    BusyError
        Where another process is at it; it says which.
    """
    with _held(path, what, 0) as holder:
        if holder is not None:
            raise BusyError(
                f"another mcsl{holder} is at work on it ({what})",
                where=str(path),
                remedy="Wait for it to end, or choose another name",
            )
        yield


@contextlib.contextmanager
def in_turn(path: Path, what: str, wait: Callable[[str], None]) -> Iterator[None]:
    """Held by one process after another.

    wait: called with who is before us, several times a second; it may raise to give up.
    """
    while True:
        with _held(path, what, 0.2) as holder:
            if holder is None:
                yield
                return
        wait(f"another mcsl{holder}")


@contextlib.contextmanager
def _held(path: Path, what: str, patience_s: float) -> Iterator[str | None]:
    """Gives None where the lock is held, and else who holds it, as words that may be empty."""
    file = lock_file(path, what)
    lock = filelock.FileLock(file, timeout=patience_s)
    try:
        lock.acquire()
    except filelock.Timeout:
        yield _holder(file)
        return
    except OSError as error:
        if error.errno in _CANNOT_LOCK:
            _log.warning("%s: files cannot be locked there; do not start a second mcsl on it", file.parent)
            yield None
            return
        with writing(path):
            raise
    try:
        if os.name != "nt":  # there nobody could read it while it is locked
            with contextlib.suppress(OSError):
                file.write_text(str(os.getpid()))
        yield None
    finally:
        if os.name != "nt":  # while it is held: who waits for it sees that it is gone, and makes another
            with contextlib.suppress(OSError):
                file.unlink()
        lock.release()


def _holder(file: Path) -> str:
    try:
        return f" (process {int(file.read_text())})"
    except (OSError, ValueError):
        return ""
