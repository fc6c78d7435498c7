"""A progress that keeps what a person is told."""

from __future__ import annotations

from mcsl_core.progress import Silent


class Notes(Silent):
    """notes: what was told, in order."""

    def __init__(self) -> None:
        super().__init__()
        self.notes: list[str] = []

    def note(self, text: str) -> None:
        self.notes.append(text)
