"""What can go wrong, told in one sentence each: what happened, where, and what to do next."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

_NO_ROOM = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}


class Fault(ValueError):
    """A value that breaks a rule of the object it was meant for; nothing was made.

    at: the path below that object, such as ``.shots[2].camera``, so that a document can say where the value stands.
    """

    def __init__(self, what: str, at: str = "") -> None:
        self.what, self.at = what, at
        super().__init__(what, at)

    def __str__(self) -> str:
        return f"{self.at.removeprefix('.')}: {self.what}" if self.at else self.what


class McslError(Exception):
    """A failure that a person can act on.

    what: what happened. where: the file, camera, frame or document path it happened at. remedy: what to
    do next. ``exit_code`` is what the command line ends with.
    """

    exit_code = 4

    def __init__(self, what: str, *, where: str = "", remedy: str = "") -> None:
        self.what, self.where, self.remedy = what, where, remedy
        super().__init__(what, where, remedy)

    def __str__(self) -> str:
        text = f"{self.where}: {self.what}" if self.where else self.what
        return f"{text}. {self.remedy}" if self.remedy else text

    def __reduce__(self) -> tuple[Any, ...]:
        # BaseException's own way calls cls(*args), which fails here and would hang a process pool that hands it back.
        return _remake, (type(self), self.what, self.where, self.remedy)


def _remake(kind: type[McslError], what: str, where: str, remedy: str) -> McslError:
    error = kind.__new__(kind)
    McslError.__init__(error, what, where=where, remedy=remedy)
    return error


class UsageError(McslError):
    """The call itself is wrong: an unknown name, options that contradict each other."""

    exit_code = 2


class InputError(McslError):
    """A file or document handed in is refused."""

    exit_code = 3


class BusyError(InputError):
    """Another process is at work on it: the same call will do later."""

    exit_code = 4


class DocumentError(InputError):
    """A JSON document (EDL, preset, truth) is malformed; ``where`` holds the path to the wrong value."""


class MediaError(InputError):
    """A media file cannot be opened, decoded, or ends before it should."""


class PluginError(McslError):
    """A plugin raised or returned something it may not; the message names it with package and version."""

    exit_code = 4


class BlenderError(McslError):
    """Blender is missing, cannot start, or its script failed."""

    exit_code = 4


class Cancelled(McslError):
    """Somebody asked to stop. Nothing half-written is left behind."""

    exit_code = 130

    def __init__(self, *, carries_on: bool = False) -> None:
        super().__init__(
            "stopped",
            remedy="The same command carries on where it stopped" if carries_on else "Nothing half-written is left",
        )


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Has a full disk, or a folder that nobody may write to, told as an error about ``path`` with what to do."""
    try:
        yield
    except OSError as error:
        what = f"cannot be written ({error.strerror or error})"
        if error.errno in _NO_ROOM:
            raise McslError(what, where=str(path), remedy="Make room, or choose another place") from error
        raise InputError(what, where=str(path), remedy="Choose a place you may write to") from error
