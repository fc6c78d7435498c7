"""A file's content key: it changes when any byte of the file does, and is worked out once for each state of a file.

The whole file is read, which for the hours of an operation takes minutes, so the key is remembered for the user: by the
file's path, size, inode and times. A repaired copy of equal size, even under the old date, is another inode or has
another time of change. Keys of versions before were those of three blocks alone; documents that hold such a key are
compared in that way, so that nothing is called changed, or conformed again, for the sake of the key's form.
"""

from __future__ import annotations

import hashlib
import os
import re
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import platformdirs

from mcsl_core.documents import write_atomic
from mcsl_core.errors import InputError, McslError

_FORM = "blake2b:"
_FORMER = re.compile(r"[0-9a-f]{32}")
FORMER = "0" * 32  # as ``like``: the key as versions before had it
_READ = 8 << 20
_FORMER_BLOCK = 1 << 20
_SETTLED_S = 3.0  # file times are as coarse as 2 s: a file that changed just now may change again under the same
_FORGOTTEN_S = 365 * 86400


def fingerprint(path: str | Path, *, like: str = "", told: Callable[[int], None] | None = None) -> str:
    """The content key of a file.

    Parameters
    ----------
    path
        Any file.
    like
        A key of the same file made earlier: where it is of a former kind, so is the answer, and both can be compared.
    told
        Called with the number of bytes that have been read, again and again; what it raises ends the work.

    Raises
    ------
    InputError
        Where it cannot be read.

    Notes
    -----
    BLAKE2b of all bytes, at some 0.9 GB/s: below what disks deliver. A file in the state it was in when it was last
    asked for is not read again.
    """
    path = Path(path)
    try:
        return _of_three_blocks(path) if _FORMER.fullmatch(like) else _remembered(path, told or (lambda _: None))
    except OSError as error:
        raise InputError(
            f"cannot be read ({error.strerror})", where=str(path), remedy="Check the path and its permissions"
        ) from error


def newest_change_s(path: Path) -> float:
    """When the file, its content or its name, last changed, in seconds since 1970."""
    state = path.stat()
    return state.st_mtime if os.name == "nt" else max(state.st_mtime, state.st_ctime)  # there, ctime is its birth


def _remembered(path: Path, told: Callable[[int], None]) -> str:
    state = _state(path)
    note = _folder() / hashlib.sha256(repr((str(path.resolve()), state)).encode("utf-8", "surrogatepass")).hexdigest()
    with suppress(OSError, ValueError):
        known = note.read_text("ascii")
        if re.fullmatch(_FORM + r"[0-9a-f]{40}", known):
            told(state[0])
            return known
    settled = time.time() - (state[1] if os.name == "nt" else state[2]) / 1e9 > _SETTLED_S
    key = _of_all(path, told)
    if settled and _state(path) == state:
        with suppress(OSError, McslError):  # then it is read again the next time
            _remember(note, key)
    return key


def _state(path: Path) -> tuple[int, int, int, int, int]:
    state = path.stat()
    return state.st_size, state.st_mtime_ns, state.st_ctime_ns, state.st_ino, state.st_dev


def _folder() -> Path:
    return Path(platformdirs.user_cache_dir("mcsl")) / "fingerprints"


def _remember(note: Path, key: str) -> None:
    note.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    for old in note.parent.iterdir():
        if time.time() - old.stat().st_mtime > _FORGOTTEN_S:
            old.unlink(missing_ok=True)
    write_atomic(note, key.encode())


def _of_all(path: Path, told: Callable[[int], None]) -> str:
    digest, done = hashlib.blake2b(digest_size=20), 0
    with path.open("rb", buffering=0) as stream:
        while block := stream.read(_READ):
            digest.update(block)
            done += len(block)
            told(done)
    return _FORM + digest.hexdigest()


def _of_three_blocks(path: Path) -> str:
    """The former kind: of the size and the first, middle and last MiB."""
    size = path.stat().st_size
    digest = hashlib.sha256(str(size).encode())
    with path.open("rb") as stream:
        for start in sorted({0, max(0, (size - _FORMER_BLOCK) // 2), max(0, size - _FORMER_BLOCK)}):
            stream.seek(start)
            digest.update(stream.read(_FORMER_BLOCK))
    return digest.hexdigest()[:32]
