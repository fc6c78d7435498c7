"""Standard input, output and error, in whatever state a shell, a service or a full disk hands them over.

Standard output is for results alone: plugins and the libraries under them print as they like, from C too, so what
anybody else prints goes to standard error. Where standard error cannot be written to, the work goes on untold.
"""

from __future__ import annotations

import contextlib
import io
import os
import sys
from typing import Any


def open_closed() -> None:
    """Gives standard input, output and error that were closed to the null device.

    Else the next files that are opened, a user's video, take their descriptors, and whoever prints, writes into them.
    """
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass
    os.close(descriptor)
    sys.stdin = sys.stdin or os.fdopen(0, closefd=False)
    sys.stdout = sys.stdout or os.fdopen(1, "w", closefd=False)
    sys.stderr = sys.stderr or os.fdopen(2, "w", closefd=False)


class _Told(io.FileIO):
    """Standard error: where nobody can be told any more (its terminal closed, its disk full), the work goes on."""

    def write(self, data: Any) -> int:
        try:
            return super().write(data)
        except OSError:
            return len(data)


def own_output() -> None:
    """Puts `sys.stdout` on a descriptor of its own, so that who writes to descriptor 1 itself writes to standard error.

    Not at a terminal, where nobody parses; and for good, because C's buffers are written out after everything else.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a name of a file that is no text is no reason to fail
    with contextlib.suppress(AttributeError, OSError, ValueError):  # none, closed, or no file
        raw = getattr(sys.stderr.buffer, "raw", sys.stderr.buffer)  # itself, where Python runs unbuffered
        # A Windows console is written to by a kind of its own that knows UTF-8; a plain file in its place garbles it.
        if sys.stderr.fileno() == 2 and type(raw) is io.FileIO:
            told = io.BufferedWriter(_Told(2, "w", closefd=False))
            sys.stderr = io.TextIOWrapper(told, sys.stderr.encoding, sys.stderr.errors, line_buffering=True)
    given = sys.stdout
    try:
        if given.isatty() or given.fileno() != 1:
            return
    except (AttributeError, OSError, ValueError):  # none, closed, or no file
        return
    given.flush()
    sys.stdout = os.fdopen(os.dup(1), "w", encoding=given.encoding, errors=given.errors)
    os.dup2(2, 1)


def give_up() -> None:
    """Has Python not try again, at the end of the process, what could not be written."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
