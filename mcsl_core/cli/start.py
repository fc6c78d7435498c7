"""Where the program `mcsl` begins: it can be stopped before it imports anything."""

from __future__ import annotations

from . import stopping, streams


def main() -> int:
    """The command line of this process; its exit code."""
    streams.open_closed()
    stopping.install()
    from .main import main as run

    return run()
