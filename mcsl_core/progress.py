"""Progress of long work, for people and for programs, and the token by which it is stopped.

A stage has a name, a total in some unit (or None when unknown) and an absolute count of what is done.
Work whose steps are known beforehand tells, before a stage, which of them it belongs to (`Steps`).
As JSON lines: {"step": ..., "of": ...}, {"stage": ..., "total": ..., "unit": ...}, {"done": ...}, {"note": ...},
{"result": {...}}, {"error": {...}}.
"""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Mapping, Sequence
from typing import IO, Any, Protocol, runtime_checkable

from attrs import define, field

from mcsl_core.errors import Cancelled


def counted(count: int, plural: str) -> str:
    """``"1 shot"``, ``"2 shots"``: a number with its noun, whose singular lacks the last letter."""
    return f"{count} {plural[:-1] if count == 1 and plural.endswith('s') else plural}"


class Progress(Protocol):
    """Where stages report to. Every method may raise `Cancelled`: the work must then leave nothing half-written."""

    def stage(self, name: str, total: int | None = None, unit: str = "") -> None:
        """A new stage begins; the one before has ended."""
        ...

    def advance(self, done: int) -> None:
        """``done`` units of the current stage (an absolute count) are finished."""
        ...

    def note(self, text: str) -> None:
        """Something a person should know: a weak camera, a gap, a decision."""
        ...


@runtime_checkable
class CountsSteps(Protocol):
    """A `Progress` may have this as well."""

    def step(self, number: int, of: int) -> None:
        """The stages that follow belong to step ``number``, counted from 1, ``of`` so many."""
        ...


class Steps:
    """The steps of a piece of work, in order: each is told when it begins, the first at once. Some may be left out.

    Parameters
    ----------
    progress
        Told where it `CountsSteps`.
    names
        All that the work may need. A step has a stage, several, or none where its result is there already.
    """

    def __init__(self, progress: Progress, names: Sequence[str]) -> None:
        self._progress, self._names, self._at = progress, tuple(names), 0
        self.begin(names[0])

    def begin(self, name: str) -> None:
        """The stages that follow belong to the step ``name``."""
        number = self._names.index(name) + 1  # a step that is not listed is a mistake: ValueError
        if number != self._at and isinstance(self._progress, CountsSteps):
            self._progress.step(number, len(self._names))
        self._at = number


@define
class CancelToken:
    """Set from another thread or a signal handler; read by the work at every report of progress."""

    _event: threading.Event = field(factory=threading.Event)

    def cancel(self) -> None:
        self._event.set()

    def check(self) -> None:
        """Raises `Cancelled` once `cancel` was called."""
        if self._event.is_set():
            raise Cancelled


@define
class Silent:
    """Reports nothing; still stops when asked to."""

    token: CancelToken = field(factory=CancelToken)

    def stage(self, name: str, total: int | None = None, unit: str = "") -> None:
        self.token.check()

    def advance(self, done: int) -> None:
        self.token.check()

    def note(self, text: str) -> None:
        self.token.check()


@define
class HeldNotes:
    """Keeps what is told of work that may not count; `tell` hands it on."""

    progress: Progress
    notes: list[str] = field(factory=list)

    def stage(self, name: str, total: int | None = None, unit: str = "") -> None:
        self.progress.stage(name, total, unit)

    def advance(self, done: int) -> None:
        self.progress.advance(done)

    def note(self, text: str) -> None:
        self.notes.append(text)

    def tell(self) -> None:
        """Tells what was kept, in order."""
        for text in self.notes:
            self.progress.note(text)


@define
class JsonLines:
    """One JSON object a line, flushed at once; at most ``per_second`` counts a second, the last of a stage always."""

    stream: IO[str]
    token: CancelToken = field(factory=CancelToken)
    per_second: float = 10.0
    _total: int | None = None
    _last: float = 0.0

    def send(self, message: Mapping[str, Any]) -> None:
        self.stream.write(json.dumps(message) + "\n")  # pure ASCII: passes any pipe, whatever its encoding
        self.stream.flush()

    def step(self, number: int, of: int) -> None:
        self.token.check()
        self.send({"step": number, "of": of})

    def stage(self, name: str, total: int | None = None, unit: str = "") -> None:
        self.token.check()
        self._total, self._last = total, 0.0
        self.send({"stage": name, "total": total, "unit": unit})

    def advance(self, done: int) -> None:
        self.token.check()
        now = time.monotonic()
        if done == self._total or now - self._last >= 1 / self.per_second:
            self._last = now
            self.send({"done": done})

    def note(self, text: str) -> None:
        self.token.check()
        self.send({"note": text})

    def result(self, values: Mapping[str, Any]) -> None:
        """What the command made, as the last message of a success."""
        self.send({"result": dict(values)})

    def error(self, what: str, where: str = "", remedy: str = "", exit_code: int = 4) -> None:
        """Why the command ended, as the last message of a failure."""
        self.send({"error": {"what": what, "where": where, "remedy": remedy, "exit_code": exit_code}})
