"""Where the program `mcsl` begins: it can be stopped before it imports anything."""

from __future__ import annotations

from . import stopping


def main() -> int:
    """The command line of this process; its exit code."""
    stopping.install()
    from .main import main as run

    return run()
