"""A progress that keeps what a person is told."""

from __future__ import annotations

from mcsl_core.progress import Silent


class Notes(Silent):
    """notes: what was told, in order. stages: what was begun."""

    def __init__(self) -> None:
        super().__init__()
        self.notes: list[str] = []
        self.stages: list[str] = []

    def stage(self, name: str, total: int | None = None, unit: str = "") -> None:
        self.stages.append(name)

    def note(self, text: str) -> None:
        self.notes.append(text)
