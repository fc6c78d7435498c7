"""One call of the command line: how its progress is shown, and how its result is told.

Standard output is for results, and with ``--progress json`` for one message a line: programs read it.
"""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from rich.console import Console

from mcsl_core.errors import UsageError
from mcsl_core.progress import JsonLines, Progress

from .language import is_japanese, told

MODES = ("auto", "bar", "lines", "json", "none")


def file_size(path: Path) -> str:
    """How large a file is, for a person."""
    size = path.stat().st_size
    return f"{size / 1e6:.1f} MB" if size >= 1e5 else f"{size / 1e3:.1f} kB"


class _ToldLines(JsonLines):
    """JSON lines whose sentences are in the user's language; that of a stage stands beside its name."""

    def send(self, message: Mapping[str, Any]) -> None:
        if is_japanese() and "stage" in message:
            message = {**message, "shown": told(message["stage"])}
        super().send(message)

    def note(self, text: str) -> None:
        super().note(told(text))


class Session:
    """What every command shares: how progress is shown, and how the result is told.

    Parameters
    ----------
    progress : {"auto", "bar", "lines", "json", "none"}
        ``auto``: a bar at a terminal, else one line a stage.
    debug : bool
        Whether errors show their traceback.

    Raises
    ------
    UsageError
        Where there is no such way to show progress.
    """

    def __init__(self, progress: str = "auto", debug: bool = False) -> None:
        if progress not in MODES:
            raise UsageError(f"{progress!r} is no way to show progress", remedy=f"Take one of {', '.join(MODES)}")
        self.debug = debug
        # Paths and names hold brackets and colons: nothing that is printed is markup.
        self.out = Console(highlight=False, soft_wrap=True, markup=False, emoji=False)
        self.err = Console(stderr=True, highlight=False, markup=False, emoji=False)
        terminal = "bar" if sys.stderr.isatty() else "lines"
        self.mode = terminal if progress == "auto" else progress
        self.json = _ToldLines(sys.stdout) if self.mode == "json" else None

    @contextlib.contextmanager
    def progress(self) -> Iterator[Progress]:
        """The progress of one piece of long work; what is printed meanwhile goes to standard error."""
        from mcsl_core.progress import Silent

        from .console import Bars, Lines

        with contextlib.redirect_stdout(sys.stderr):
            if self.json:
                yield self.json
            elif self.mode == "bar":
                with Bars(self.err) as bars:
                    yield bars
            elif self.mode == "lines":
                yield Lines(lambda line: print(line, file=sys.stderr, flush=True))
            else:
                yield Silent()

    def result(self, values: Mapping[str, Any], text: str) -> None:
        """The end of a success: ``values`` for programs, ``text`` for people."""
        if self.json:
            self.json.result(values)
        else:
            self.out.print(told(text))
