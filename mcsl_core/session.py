"""One call of the command line: how its progress is shown, and how its result is told."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator, Mapping
from typing import Any

from rich.console import Console

from .progress import JsonLines, Progress


class Session:
    """What every command shares: how progress is shown, and how the result is told."""

    def __init__(self, progress: str, debug: bool) -> None:
        self.debug = debug
        self.out = Console(highlight=False, soft_wrap=True)
        self.err = Console(stderr=True, highlight=False)
        terminal = "bar" if sys.stderr.isatty() else "lines"
        self.mode = terminal if progress == "auto" else progress
        self.json = JsonLines(sys.stdout) if self.mode == "json" else None

    @contextlib.contextmanager
    def progress(self) -> Iterator[Progress]:
        """The progress of one piece of long work."""
        from .console import Bars, Lines
        from .progress import Silent

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
            self.out.print(text)
