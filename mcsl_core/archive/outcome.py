"""What has become of an operation, by the marks that its jobs left and the last words of those that failed."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Literal

from attrs import frozen

from .job import Job, told

State = Literal["done", "refused", "failed", "waiting"]
_REFUSED = (2, 3)  # exit codes: the same files and options will be refused again
_TAIL = 1 << 16


@frozen
class Outcome:
    """How far an operation is.

    Attributes
    ----------
    state : {"done", "refused", "failed", "waiting"}
        ``refused``: what its files or options are stands against it, until they change. ``failed``: another try may
        help. ``waiting``: nobody has tried what comes next.
    step : str
        The job that is next or failed; empty where all is done.
    why : str
        What stands against it, in words for people.
    seconds : float
        How long its finished jobs took together.
    """

    state: State
    step: str = ""
    why: str = ""
    seconds: float = 0.0


def steps(job: Job) -> tuple[str, ...]:
    """The jobs of an operation by the names of their marks, in order."""
    parts = (f"conform-{part}-of-{job.parts}" for part in range(1, job.parts + 1))
    return ("analyse", *parts, "render", "evaluate", "report")


def outcome_of(folder: Path, job: Job) -> Outcome:
    """How far the operation with the results in ``folder`` is."""
    if job.facts.fault:
        return Outcome("refused", "open", job.facts.fault)
    planned, decided = _changed(folder / "job.json"), _changed(folder / "edl.json")
    seconds, first = 0.0, ""
    for step in steps(job):
        mark = folder / "done" / step
        made = _changed(mark)
        if made is None or made < max(planned or 0, decided or 0 if step != "analyse" else 0):
            first = first or step
        else:
            seconds += _seconds(mark)
    if not first:
        return Outcome("done", seconds=seconds)
    log = folder / "log" / f"{first}.jsonl"
    tried = _changed(log)
    if tried is None or tried < (planned or 0):
        return Outcome("waiting", first, seconds=seconds)
    return _failure(first, log, Path(job.recording), seconds)


def nameless(why: str, job: Job) -> str:
    """What stands against an operation without the names of its folder, cameras and files."""
    recording = Path(job.recording)
    found = [path for pattern in ("*", "*/*") for path in recording.glob(pattern)]
    names = {*job.operation.split("/"), *(path.name for path in found), *(path.stem for path in found)}
    word = "|".join(re.escape(name) for name in sorted(names, key=len, reverse=True))
    return re.sub(rf"(?<!\w)({word})(?!\w)", "...", why)


def _failure(step: str, log: Path, recording: Path, seconds: float) -> Outcome:
    with log.open("rb") as stream:
        stream.seek(max(0, log.stat().st_size - _TAIL))
        last = (stream.read().decode("utf-8", "replace").splitlines() or [""])[-1]
    try:
        error = json.loads(last)["error"]
        what, remedy, code = error["what"], error["remedy"], error["exit_code"]
        where = told(Exception(error["where"]), recording)
    except (ValueError, LookupError, TypeError):
        return Outcome("failed", step, "ended without saying why: it was killed, or is at work", seconds)
    name = where.rpartition("/")[2]
    words = f"{name}: {what}. {remedy}" if name else f"{what}. {remedy}"
    return Outcome("refused" if code in _REFUSED else "failed", step, words.rstrip(". "), seconds)


def _changed(path: Path) -> int | None:
    try:
        return path.stat().st_mtime_ns
    except OSError:
        return None


def _seconds(mark: Path) -> float:
    try:
        return float(mark.read_text())
    except (OSError, ValueError):  # made by hand, or by `snakemake --touch`
        return 0.0
