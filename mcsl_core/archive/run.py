"""One run over an archive: what there is, what is to be done, the engine, and what has become of each operation."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import attrs
from attrs import frozen

from mcsl_core.delivery.quality import QUALITIES
from mcsl_core.errors import writing
from mcsl_core.outputs.locks import alone
from mcsl_core.progress import Progress, counted
from mcsl_core.timing import format_time

from .engine import Engine
from .job import Job, planned
from .operations import Operation, find_operations
from .outcome import Outcome, forget_outdated, nameless, outcome_of, steps

_AT_ONCE = 16  # files are opened over networks, too


@frozen
class Work:
    """An operation, what is to be done for it, and how far that is."""

    operation: Operation
    job: Job
    outcome: Outcome

    @property
    def open(self) -> bool:
        """Whether another run may bring it further."""
        return self.outcome.state in ("waiting", "failed")


def survey(
    archive: Path,
    out: Path,
    *,
    table: Path | None = None,
    anonymous: bool = False,
    write: bool = True,
    progress: Progress,
) -> tuple[Work, ...]:
    """Every operation of an archive with what is to be done for it. Files that are as they were are not opened again.

    write: whether what is to be done is written for the engine; without, nothing is.

    Raises
    ------
    McslError
        What `find_operations` raises, and where ``out`` cannot be written to. A recording that cannot be read is told
        by its outcome.
    """
    operations = find_operations(archive, out, table=table, anonymous=anonymous, write=write)
    progress.stage("Looking through the archive", len(operations), "operations")
    found = []
    with ThreadPoolExecutor(_AT_ONCE) as pool:
        for done, work in enumerate(pool.map(partial(_work, archive, out, anonymous, write), operations), start=1):
            found.append(work)
            progress.advance(done)
    return tuple(found)


def _work(archive: Path, out: Path, anonymous: bool, write: bool, operation: Operation) -> Work:
    folder = out / operation.key
    job = planned(operation, archive, folder, write=write, anonymous=anonymous)
    if write:
        forget_outdated(folder, job)
    outcome = outcome_of(folder, job)
    return Work(operation, job, attrs.evolve(outcome, why=nameless(outcome.why, job)) if anonymous else outcome)


def carry_out(
    archive: Path, out: Path, engine: Engine, *, table: Path | None, anonymous: bool, progress: Progress
) -> tuple[Work, ...]:
    """Has the engine do what is open, and says what has become of everything.

    Raises
    ------
    BusyError
        Where another run is at work on ``out``; nothing of it is touched then.
    McslError
        As of `survey`.
    """
    engine.check()
    find_operations(archive, out, table=table, anonymous=anonymous, write=False)  # before anything is made
    with writing(out):
        out.mkdir(parents=True, exist_ok=True)
    look = partial(survey, archive, out, table=table, anonymous=anonymous, progress=progress)
    with alone(out / "archive.json", "archive"):
        if keys := [work.operation.key for work in look() if work.open]:
            engine.run(keys, out, anonymous=anonymous, progress=progress)
        return look()


def describe(works: Sequence[Work], out: Path) -> str:
    """What would be done, how long and how large, for people."""
    states = Counter(work.outcome.state for work in works)
    todo = [work for work in works if work.open]
    lines = [
        f"{counted(len(works), 'operations')}: " + ", ".join(f"{n} {state}" for state, n in sorted(states.items()))
    ]
    if todo:
        jobs = sum(len(steps(work.job)) for work in todo)
        lines.append(f"to do: {counted(len(todo), 'operations')}, {jobs} jobs at most, {_length(todo)} of recording")
        lines.append(
            f"results: about {_bytes(_results(works, todo, out))}, beside {_bytes(_sum(todo, 'bytes'))} of recording"
        )
        lines.append(_time(works, todo))
    lines += [f"  {w.operation.key}: {w.outcome.state} ({w.outcome.why})" for w in works if w.outcome.why]
    return "\n".join(lines)


def _length(works: Sequence[Work]) -> str:
    return format_time(round(_sum(works, "seconds")))


def _time(works: Sequence[Work], todo: Sequence[Work]) -> str:
    """By what the finished operations took: machines and pictures differ too much for any other guess."""
    done = [work for work in works if work.outcome.state == "done"]
    recorded = _sum(done, "seconds")
    if not recorded:
        return "time: told as soon as one operation is done"
    took = sum(work.outcome.seconds for work in done) / recorded * _sum(todo, "seconds")
    return f"time: about {format_time(round(took))} of jobs one after another, as those took that are done"


def _results(works: Sequence[Work], todo: Sequence[Work], out: Path) -> float:
    """Bytes: as those that are done have, else what conformed pictures take by their size."""
    done = [work for work in works if work.outcome.state == "done"]
    if recorded := _sum(done, "seconds"):
        folders = (out / work.operation.key for work in done)
        made = sum(path.stat().st_size for f in folders for path in f.rglob("*") if path.is_file())
        return made / recorded * _sum(todo, "seconds")
    return sum(_conformed(work.job) for work in todo)


def _conformed(job: Job) -> float:
    quality = QUALITIES[job.conform[1]]
    return job.frames * job.facts.size[0] * job.facts.size[1] * quality.bits_a_pixel / 8


def _sum(works: Sequence[Work], name: str) -> float:
    return sum(getattr(work.job.facts, name) for work in works)


def _bytes(size: float) -> str:
    for unit in ("kB", "MB", "GB", "TB"):
        size /= 1000
        if size < 1000 or unit == "TB":
            return f"{size:.3g} {unit}"
    raise AssertionError
