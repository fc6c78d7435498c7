"""Hidden files and folders that work is written into before it has its name, and the end of those of killed runs.

Their names hold the machine and the process that made them, so that a later run can tell what nobody works at any more
from what another run is writing just now. A run that has no time to end in order deletes its own itself.
"""

from __future__ import annotations

import contextlib
import os
import re
import secrets
import shutil
import socket
import tempfile
import time
from collections.abc import Iterator
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import BinaryIO, cast

_FILE = re.compile(r"\.mcsl-([0-9a-f]{6})-(\d+)-[0-9a-f]{8}\.tmp(?:\.\w+@?)?")  # "@": Blender's, until all is written
_FOLDER = re.compile(r"mcsl-[a-z]+-([0-9a-f]{6})-(\d+)-\w+")
_FORMER = re.compile(r"\.mcsl-[0-9a-f]{16}\.tmp|blender-env\.part-\w{8}")  # of versions before the owner's name
_STALE_S = 24 * 3600  # of what another machine made: nothing writes for a day without a byte arriving
_own: set[Path] = set()  # every name that this process has given out


@cache
def _machine() -> str:
    """Six digits for this machine; containers of one name that do not see each other's processes are not the same."""
    try:
        room = os.readlink("/proc/self/ns/pid")
    except OSError:
        room = ""
    return sha256(f"{socket.gethostname()} {room}".encode()).hexdigest()[:6]


def temporary_beside(path: Path, suffix: str = "") -> Path:
    """A hidden name of its own in the folder of ``path``, however long that one's name is; nothing is made.

    suffix: for programs that choose a format by it, such as ``.blend``.
    """
    name = path.with_name(f".mcsl-{_machine()}-{os.getpid()}-{secrets.token_hex(4)}.tmp{suffix}")
    _own.add(name.absolute())
    return name


@contextlib.contextmanager
def temporary_folder(kind: str) -> Iterator[Path]:
    """A private folder (0700) for temporary files, gone afterwards; those of killed runs go when it is made."""
    root = Path(tempfile.gettempdir())
    for path in _matching(root, "mcsl-*"):
        match = _FOLDER.fullmatch(path.name)
        if match and _is_mine(path) and _is_abandoned(path, *match.groups()):
            shutil.rmtree(path, ignore_errors=True)
    prefix = f"mcsl-{kind}-{_machine()}-{os.getpid()}-"
    with tempfile.TemporaryDirectory(prefix=prefix, ignore_cleanup_errors=True) as name:
        _own.add(Path(name))
        yield Path(name)


def open_private(path: Path, mode: str, buffering: int = -1) -> BinaryIO:
    """Opens a new file for its owner's eyes alone (0600); FileExistsError where there is one."""
    return cast(BinaryIO, open(path, mode, buffering, opener=lambda name, flags: os.open(name, flags, 0o600)))


def private_folder(folder: Path) -> None:
    """Makes a folder for its owner's eyes alone where it is not there; one that is stays as it is."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    folder.mkdir(mode=0o700, exist_ok=True)


def sweep(folder: Path) -> None:
    """Deletes what killed runs left half-written in ``folder``; what another run is writing stays."""
    for path in [*_matching(folder, ".mcsl-*"), *_matching(folder, "blender-env.part-*")]:
        if match := _FILE.fullmatch(path.name):
            gone = _is_abandoned(path, *match.groups())
        else:
            gone = _FORMER.fullmatch(path.name) is not None and _is_old(path)
        if gone:
            _delete(path)


def remove_own() -> None:
    """Deletes what this process has half-written, other threads' too: for who ends at once."""
    for path in tuple(_own):
        _delete(path)
        _delete(path.with_name(f"{path.name}@"))


def _delete(path: Path) -> None:
    with contextlib.suppress(OSError):
        shutil.rmtree(path, ignore_errors=True) if path.is_dir() else path.unlink()


def _matching(folder: Path, pattern: str) -> list[Path]:
    try:
        return list(folder.glob(pattern))
    except OSError:
        return []


def _is_mine(path: Path) -> bool:
    try:
        return not hasattr(os, "getuid") or path.lstat().st_uid == os.getuid()
    except OSError:
        return False


def _is_abandoned(path: Path, machine: str, process: str) -> bool:
    if machine != _machine() or os.name == "nt":  # there a question about a process may end it
        return _is_old(path)
    return not _is_alive(int(process))


def _is_old(path: Path) -> bool:
    try:
        return time.time() - path.lstat().st_mtime > _STALE_S
    except OSError:
        return False


def _is_alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:  # another person's
        return True
    return True
