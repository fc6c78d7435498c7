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
_COUNTED = re.compile(r"[-_ ]*\d+$")


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
        made = _seen(mark)
        if made is None or made < _asked(step, planned, decided):
            first = first or step
        else:
            seconds += _seconds(mark)
    if not first:
        return Outcome("done", seconds=seconds)
    log = folder / "log" / f"{first}.jsonl"
    tried = _changed(log)
    if tried is None or tried < _asked(first, planned, decided):
        return Outcome("waiting", first, seconds=seconds)
    return _failure(first, log, Path(job.recording), seconds)


def forget_outdated(folder: Path, job: Job) -> None:
    """Removes the marks of jobs that began before what they were to see: engines know when they ended alone."""
    planned, decided = _changed(folder / "job.json"), _changed(folder / "edl.json")
    for step in steps(job):
        mark = folder / "done" / step
        made = _seen(mark)
        if made is not None and made < _asked(step, planned, decided):
            mark.unlink(missing_ok=True)


def _seen(mark: Path) -> int | None:
    """When the job that left a mark began; None where there is no mark."""
    made = _changed(mark)
    return made if made is None else _changed(mark.with_name(f"{mark.name}.began")) or made


def _asked(step: str, planned: int | None, decided: int | None) -> int:
    """When a step was last asked for: its job planned, or the EDL that it is made from changed."""
    return max(planned or 0, (decided or 0) if step != "analyse" else 0)


def nameless(why: str, job: Job) -> str:
    """What stands against an operation without the names of its folder, cameras and files, and without its options."""
    recording = Path(job.recording)
    found = [path for pattern in ("*", "*/*") for path in recording.glob(pattern)]
    cameras = {_COUNTED.sub("", path.stem) for path in found}  # of files that follow each other
    told_of = (*job.analyse[1::2], *job.conform[3::2])
    names = {*job.operation.split("/"), *(path.name for path in found), *(path.stem for path in found)}
    names = {name for name in (*names, *cameras, *told_of) if name}
    word = "|".join(re.escape(name) for name in sorted(names, key=len, reverse=True))
    return re.sub(rf"(?<!\w)({word})(?!\w)", "...", why, flags=re.IGNORECASE)


def _failure(step: str, log: Path, recording: Path, seconds: float) -> Outcome:
    with log.open("rb") as stream:
        stream.seek(max(0, log.stat().st_size - _TAIL))
        last = (stream.read().decode("utf-8", "replace").splitlines() or [""])[-1]
    try:
        error = json.loads(last)["error"]
        what, remedy, code = error["what"], error["remedy"], error["exit_code"]
        where = told(Exception(error["where"]), recording)
    except (ValueError, LookupError, TypeError):
        said = f": {last.strip()}" if last.strip() and not last.startswith("{") else ""
        return Outcome("failed", step, f"ended without saying why: it was killed, or is at work{said}", seconds)
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
