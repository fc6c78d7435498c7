# SPDX-License-Identifier: GPL-3.0-or-later
"""Long work as a child process: `mcsl --progress json ...` is started, read from and stopped. No bpy.

A job is pumped from a timer: nothing here waits. The child writes into files of a folder of its own, so that no pipe
fills up and nothing is lost when it dies. Stopping asks it first (it then leaves nothing half-written) and kills it
and all it started after a grace.
"""

from __future__ import annotations

import os
import signal
import subprocess
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import attrs
from attrs import field, frozen

from mcsl_core.blender.messages import Done, Failed, Failure, Message, MessageFile, Note, Result, Stage, Step
from mcsl_core.errors import Cancelled, DocumentError, McslError

from .find_mcsl import child_environment

GRACE_S = 15.0  # a chunk that is being encoded is dropped within a second; closing files on a slow disc takes longer
STOPPED = "stopped"
PACE_S = 2.0  # a pace is known after so long

Outcome = Literal["running", "done", "stopped", "failed"]


@frozen
class Status:
    """Where a job stands.

    Attributes
    ----------
    stage, done, total, unit
        Its current stage: so many units of ``total`` are done; None when that is not known.
    step, steps
        The step of the work that the stage belongs to, counted from 1, and how many there are; 0 when not known.
    notes
        What a person should know, in the order told.
    outcome
        ``running`` until the process is gone.
    message
        One line for a person, once it has ended badly.
    result
        What the command made.
    """

    stage: str = ""
    done: int = 0
    total: int | None = None
    unit: str = ""
    step: int = 0
    steps: int = 0
    notes: tuple[str, ...] = ()
    outcome: Outcome = "running"
    message: str = ""
    result: Mapping[str, Any] = field(factory=dict)

    @property
    def fraction(self) -> float:
        """Of the current stage, 0 to 1; 0 when its length is unknown."""
        return min(1.0, self.done / self.total) if self.total else 0.0


class Job:
    """One child process, from its start to its end."""

    def __init__(self, command: Sequence[str], *, cwd: Path | None = None, language: str = "") -> None:
        """Starts the job.

        Parameters
        ----------
        command
            The program and its arguments.
        cwd
            The folder to start it in.
        language
            In which it tells notes and errors, such as ja_JP; empty: as the environment says.

        Raises
        ------
        McslError
            It cannot be started.
        """
        self.status = Status()
        self._folder = tempfile.TemporaryDirectory(prefix="mcsl-job-", ignore_cleanup_errors=True)
        base = Path(self._folder.name)
        self._out, self._err = base / "out", base / "err"
        self._messages = MessageFile(self._out)
        self._text = ""
        self._ending: Outcome | None = None  # known before the process is gone
        self._step: Step | None = None  # told before its first stage, and shown with it
        self._began: tuple[float, int] | None = None  # when the stage was first heard of, and what was done by then
        self._asked: float | None = None  # when it was asked to stop
        group: dict[str, Any] = {"start_new_session": True}
        if os.name == "nt":
            group = {"creationflags": subprocess.CREATE_NO_WINDOW}  # pyright: ignore[reportAttributeAccessIssue]
        try:
            with open(self._out, "wb") as out, open(self._err, "wb") as err:
                self._child = subprocess.Popen(
                    list(command),
                    stdin=subprocess.DEVNULL,
                    stdout=out,
                    stderr=err,
                    cwd=cwd,
                    env=child_environment(language=language),
                    **group,
                )
        except OSError as error:
            self._folder.cleanup()
            raise McslError(f"cannot be started ({error.strerror or error})", where=str(command[0])) from error

    @property
    def running(self) -> bool:
        return self.status.outcome == "running"

    @property
    def stopping(self) -> bool:
        """Asked to stop, and not gone yet."""
        return self.running and self._asked is not None

    def pump(self) -> Status:
        """Reads what came since the last time; returns where the job stands now. Never waits."""
        if not self.running:
            return self.status
        code = self._child.poll()  # asked before reading: what it wrote last is then there
        try:
            for message in self._messages.read(ended=code is not None):
                self._take(message)
        except DocumentError as error:
            self._take(Failed(Failure(error.what, error.where, error.remedy, error.exit_code)))
            self.cancel()
        if code is not None:
            self._end(code)
        elif self._asked is not None and time.monotonic() - self._asked > GRACE_S:
            self.kill()
        return self.status

    def left_s(self) -> float | None:
        """How long the current stage still takes at its pace until now; None while that cannot be told."""
        status = self.status
        if self._began is None or not status.total or not self.running:
            return None
        began, done_then = self._began
        took, made = time.monotonic() - began, status.done - done_then
        return took / made * (status.total - status.done) if made > 0 and took >= PACE_S else None

    def output(self) -> str:
        """All that it wrote to standard output, once it has ended."""
        return self._text

    def cancel(self) -> None:
        """Asks it to stop; `pump` goes on until it is gone."""
        if self.running and self._asked is None:
            self._asked = time.monotonic()
            self._child.terminate()  # mcsl takes SIGTERM as Ctrl-C

    def kill(self) -> None:
        """Ends it and all it started, now."""
        self._asked = self._asked or time.monotonic()
        if self._child.poll() is None:
            if os.name == "nt":
                self._child.kill()
            else:
                os.killpg(self._child.pid, signal.SIGKILL)

    # ------------------------------------------------------------------------------------------------- messages

    def _take(self, message: Message) -> None:
        status = self.status
        match message:
            case Step():
                self._step = message
            case Stage(stage, total, unit, shown):
                stage, unit = (shown, "") if shown else (stage, unit)
                status = attrs.evolve(status, stage=stage, total=total, unit=unit, done=0)
                self.status = attrs.evolve(status, step=self._step.step, steps=self._step.of) if self._step else status
                self._began = None
            case Done(done):
                self.status = attrs.evolve(status, done=done)
                self._began = self._began or (time.monotonic(), done)
            case Note(note):
                self.status = attrs.evolve(status, notes=(*status.notes, note))
            case Result(result):
                self.status = attrs.evolve(status, result=result)
            case Failed(error) if self._ending is None:  # the first says why; asked to stop, it says that it stopped
                told = McslError(error.what, where=error.where, remedy=error.remedy)
                stopped = error.exit_code == Cancelled.exit_code
                # The outcome stays "running" until the process is gone; it is known already, though.
                self._ending = "stopped" if stopped else "failed"
                self.status = attrs.evolve(status, message=STOPPED if stopped else _sentence(told))

    def _end(self, code: int) -> None:
        self._text = self._out.read_text("utf-8", "replace")
        said = self._err.read_text("utf-8", "replace").strip().splitlines()
        self._folder.cleanup()
        status = self.status
        if self._ending is not None:
            outcome, message = self._ending, status.message
        elif code == 0:
            outcome, message = "done", ""
        elif self._asked is not None:
            outcome, message = "stopped", STOPPED
        else:
            outcome, message = "failed", _unexplained(code, said)
        self.status = attrs.evolve(status, outcome=outcome, message=message)


def _unexplained(code: int, said: Sequence[str]) -> str:
    """The line for a child that ended badly and did not say why."""
    if code < 0:
        name = next((s.name for s in signal.Signals if s == -code), f"signal {-code}")
        return f"mcsl was ended from outside ({name}). Start it again: it carries on where it stopped"
    last = said[-1].strip() if said else f"it ended with code {code} and said nothing"
    return one_line(f"mcsl failed: {last}")


def _sentence(error: McslError) -> str:
    """The line for an error, in whatever language it is told."""
    said = str(McslError(error.what, where=error.where))
    if said[-1:] < "\u3000" or not error.remedy:
        return one_line(str(error))
    return one_line(f"{said}。{error.remedy}")  # Japanese ends a sentence so


def one_line(text: str) -> str:
    """``text`` for a status bar."""
    return " ".join(text.split())
