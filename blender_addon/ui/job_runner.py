# SPDX-License-Identifier: GPL-3.0-or-later
"""The one job that runs, as Blender sees it: a timer pumps it, the status bar and the panel show it.

process/job.py does the work and knows no bpy. When a job is done, what follows from it (a timeline to build, pictures
to put in place) may come in steps, so that the window stays alive: a generator, one step a tick.
"""

from __future__ import annotations

import atexit
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import bpy  # pyright: ignore[reportMissingImports]
from attrs import define, field

from mcsl_core.blender.messages import OfferedPlugin, structure
from mcsl_core.documents import parse_json
from mcsl_core.errors import McslError

from ..core.camera_files import plugins_command
from ..process.job import Job, Status
from .translations.lookup import language, told

TICK_S = 0.1
ASKED = "mcsl plugins"
SHOWN_S = 12.0  # how long the last message stays in the status bar

Follow = Callable[[Mapping[str, Any]], Iterator[float] | None]


@define
class Running:
    """A job, what it is called, and what follows when it is done; then the rest of what follows, part by part."""

    title: str
    job: Job
    follow: Follow | None
    rest: Iterator[float] | None = None
    part: float = 0.0


@define
class Desk:
    """What the panel shows beside the scene: it lives as long as Blender runs."""

    running: Running | None = None
    message: str = ""
    about: str = ""  # the title of the job that the message is about
    level: str = "INFO"  # INFO, WARNING or ERROR
    mcsl: str = ""
    offers: dict[str, list[OfferedPlugin]] = field(factory=dict)  # by stage
    asking: Job | None = None


desk = Desk()


def busy() -> bool:
    return desk.running is not None


def start(title: str, command: Sequence[str], follow: Follow | None = None, *, cwd: Path | None = None) -> None:
    """Starts a job; `follow` gets its result. McslError where one runs already or it cannot be started."""
    if desk.running is not None:
        raise McslError(
            told("{title} runs already").format(title=desk.running.title), remedy=told("Wait, or cancel it")
        )
    desk.running = Running(title, Job(command, cwd=cwd, language=language()), follow)
    say("", "INFO", title)
    _tick_soon()


def cancel() -> None:
    """Asks the job to stop; what has followed so far stays."""
    if desk.running is not None:
        desk.running.job.cancel()


def pump() -> bool:
    """One step; whether there is more to do. Called by the timer."""
    run = desk.running
    if run is None:
        return False
    try:
        if run.rest is not None:
            run.part = next(run.rest)
            return True
        status = run.job.pump()
        if status.outcome == "running":
            return True
        if status.outcome != "done":
            _finish(run, status)
            return False
        run.rest = (run.follow(status.result) if run.follow else None) or iter(())
        return True
    except StopIteration:
        _finish(run, run.job.status)
    except McslError as error:
        desk.running = None
        say(f"{run.title}: {error}", "ERROR", run.title)
    except Exception as error:
        desk.running = None
        say(f"{run.title}: {type(error).__name__}: {error}", "ERROR", run.title)
        raise
    return False


def _finish(run: Running, status: Status) -> None:
    desk.running = None
    if status.outcome == "failed":
        say(f"{run.title}: {status.message}", "ERROR", run.title)
    elif status.outcome == "stopped":
        text = told("{title} stopped; started again, it carries on where it was")
        say(text.format(title=run.title), "WARNING", run.title)
    elif not desk.message:
        done = told("{title}: done").format(title=run.title)
        note = status.notes[-1] if status.notes else ""
        say(f"{done}. {note}" if note else done, "INFO", run.title)


# ------------------------------------------------------------------------------------------------------- messages


def say(text: str, level: str, about: str = "") -> None:
    """One line for a person: in the panel, the status bar and, where there is no window, the log."""
    desk.message, desk.level, desk.about = text, level, about
    if text and bpy.app.background:
        print(f"mcsl: {text}", flush=True)
    _status_bar(text or None)
    if bpy.app.timers.is_registered(_clear):
        bpy.app.timers.unregister(_clear)
    if text:
        bpy.app.timers.register(_clear, first_interval=SHOWN_S)
    redraw()


def _clear() -> None:
    if desk.running is None:
        _status_bar(None)


def _status_bar(text: str | None) -> None:
    for window in bpy.context.window_manager.windows if not bpy.app.background else ():
        window.workspace.status_text_set(text)


def describe(run: Running) -> str:
    """The job in a line: the stage it is in, of how many, and how long that still takes; the bar shows what is done."""
    if run.rest is not None:
        return told("putting it into the timeline")
    status = run.job.status
    if run.job.stopping:
        return told("stopping")
    if not status.stage:
        return told("starting")
    text = status.stage
    if status.steps > 1:
        text = told("Stage {number} of {count}: {stage}").format(number=status.step, count=status.steps, stage=text)
    if (left := run.job.left_s()) is None:
        return text
    return told("{stage}, {time} left").format(stage=text, time=f"{round(left) // 60}:{round(left) % 60:02}")


def fraction(run: Running) -> float:
    return run.part if run.rest is not None else run.job.status.fraction


def redraw() -> None:
    """The panels are drawn anew."""
    for window in bpy.context.window_manager.windows if not bpy.app.background else ():
        for area in window.screen.areas:
            if area.type in ("SEQUENCE_EDITOR", "PREFERENCES"):
                area.tag_redraw()


# ------------------------------------------------------------------------------------------------------- plugins


def read_plugins(mcsl: str) -> None:
    """Asks mcsl for its plugins; the answer comes by the timer."""
    if desk.asking is None:
        desk.asking = Job(plugins_command(mcsl))
        _tick_soon()


def pump_plugins() -> bool:
    """Takes the answer when it has come; whether it is still awaited."""
    job = desk.asking
    if job is None:
        return False
    status = job.pump()
    if status.outcome == "running":
        return True
    desk.asking = None
    try:
        if status.outcome != "done":
            raise McslError(status.message)
        rows = structure(parse_json(job.output(), where=ASKED), tuple[OfferedPlugin, ...], where=ASKED)
        desk.offers = {row.stage: [other for other in rows if other.stage == row.stage] for row in rows}
    except McslError as error:
        say(told("the plugins could not be read: {reason}").format(reason=error), "WARNING")
    redraw()
    return False


# -------------------------------------------------------------------------------------------------------- timer


def _tick() -> float | None:
    more = pump()
    asking = pump_plugins()
    if desk.running is not None:
        title, text = desk.running.title, describe(desk.running)
        _status_bar(text if title in text else f"{title} – {text}")
    redraw()
    return TICK_S if more or asking else None


def _tick_soon() -> None:
    if not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=TICK_S, persistent=True)


def _end_jobs() -> None:
    """Blender quits: nothing of ours runs on."""
    for job in (desk.running and desk.running.job, desk.asking):
        if job and job.running:
            job.cancel()


def register() -> None:
    atexit.register(_end_jobs)


def unregister() -> None:
    _end_jobs()
    desk.running = desk.asking = None
    for timer in (_tick, _clear):
        if bpy.app.timers.is_registered(timer):
            bpy.app.timers.unregister(timer)
    atexit.unregister(_end_jobs)
