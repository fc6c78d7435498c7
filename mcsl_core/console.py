"""Progress for a person at a terminal: stages, a bar, the rate and the time left; one line a stage elsewhere."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from attrs import define, field
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    ProgressColumn,
    SpinnerColumn,
    Task,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.progress import Progress as RichProgress
from rich.text import Text

from .progress import CancelToken


class _RateColumn(ProgressColumn):
    """Units a second, as the rate of the whole stage."""

    def render(self, task: Task) -> Text:
        speed = task.finished_speed or task.speed
        unit = task.fields.get("unit") or "steps"
        return Text(f"{speed:.1f} {unit}/s" if speed else "", style="progress.data.speed")


@define
class Bars:
    """A bar per stage on ``console`` (standard error), live on a terminal; notes stand above the bars."""

    console: Console
    token: CancelToken = field(factory=CancelToken)
    _rich: RichProgress | None = None
    _task: TaskID | None = None

    def __enter__(self) -> Bars:
        self._rich = RichProgress(
            SpinnerColumn(finished_text="[green]✓[/]"),
            TextColumn("{task.description}"),
            BarColumn(bar_width=24),
            MofNCompleteColumn(),
            _RateColumn(),
            TimeElapsedColumn(),
            TimeRemainingColumn(compact=True),
            console=self.console,
        )
        self._rich.start()
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        assert self._rich is not None
        if kind is None:
            self._finish()
        self._rich.stop()

    def _finish(self) -> None:
        if self._rich is not None and self._task is not None:
            task = next(t for t in self._rich.tasks if t.id == self._task)
            done = (task.completed if task.total is None else task.total) or 1  # an empty stage is a finished one
            self._rich.update(self._task, completed=done, total=done)

    def stage(self, name: str, total: int | None = None, unit: str = "") -> None:
        self.token.check()
        assert self._rich is not None
        self._finish()
        self._task = self._rich.add_task(name, total=total, unit=unit)

    def advance(self, done: int) -> None:
        self.token.check()
        if self._rich is not None and self._task is not None:
            self._rich.update(self._task, completed=done)

    def note(self, text: str) -> None:
        self.token.check()
        self.console.print(f"[yellow]note[/] {text}", highlight=False)


@define
class Lines:
    """One line when a stage begins, one for a note: for log files and pipes."""

    write: Callable[[str], Any]
    token: CancelToken = field(factory=CancelToken)
    _began: float = field(factory=time.monotonic)

    def stage(self, name: str, total: int | None = None, unit: str = "") -> None:
        self.token.check()
        size = f" ({total} {unit})" if total else ""
        self.write(f"{time.monotonic() - self._began:7.1f} s  {name}{size}")

    def advance(self, done: int) -> None:
        self.token.check()

    def note(self, text: str) -> None:
        self.token.check()
        self.write(f"{time.monotonic() - self._began:7.1f} s  note: {text}")
