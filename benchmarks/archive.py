"""What an archive of many operations takes before any work begins: to look through it, to plan it, to rank it.

    python -m benchmarks.archive FOLDER [OPERATIONS ...]        writes results/archive.md (1000 10000 100000)

Recordings are stubs: their facts stand in the jobs' documents as if they had been opened, two hours of five cameras
each, conformed in six parts. Snakemake plans really; a job that it starts does nothing, so that what is measured is the
engine's own share. Times are of the processor: other work on the machine does not count.
"""

from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from datetime import date
from pathlib import Path
from typing import Any

import attrs
from attrs import frozen

from mcsl_core.archive import job as jobs
from mcsl_core.archive.engine import BATCH, Engine
from mcsl_core.archive.outcome import steps
from mcsl_core.archive.run import survey
from mcsl_core.archive.triage import write_triage
from mcsl_core.documents import canonical_json
from mcsl_core.progress import Silent

RESULTS = Path(__file__).parent / "results"
FACTS = jobs.Facts(5, 20, 7200.0, 29.97003, (1920, 1080), 5 * 10**10)
RUN = 50  # operations whose jobs are really started


# A child counts the memory of who started it as its own: so a small process does.
_APART = """
import resource, subprocess, sys
subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
used = resource.getrusage(resource.RUSAGE_CHILDREN)
print(used.ru_utime + used.ru_stime, used.ru_maxrss)
"""


@frozen
class Cost:
    """What a child process took: seconds of the processor with its own children's, and its most memory in MiB."""

    seconds: float
    mib: float


def cost_of(call: Callable[[], Any]) -> float:
    """Seconds of this process's processor time that a call took."""
    began = time.process_time()
    call()
    return time.process_time() - began


def stubs(root: Path, count: int) -> tuple[Path, Path]:
    """An archive of empty folders, and results in which each has a job as if its files had been opened."""
    archive, out = root / "archive", root / "out"
    for number in range(count):
        (archive / f"{number:06d}").mkdir(parents=True)
    out.mkdir()
    for work in survey(archive, out, progress=Silent()):  # they hold no files: the facts are put in afterwards
        job = attrs.evolve(work.job, facts=FACTS, parts=6)
        text = canonical_json(jobs._converter.unstructure(job))
        (out / work.operation.key / "job.json").write_text(text)
    return archive, out


def planned(out: Path, keys: Sequence[str], *more: str, mcsl: str = "true") -> Cost:
    """Snakemake over these operations in one go."""
    engine = Engine(cores=2, mcsl=mcsl)
    (out / "log").mkdir(exist_ok=True)
    given = {"operations": list(keys), "threads": 1, "mcsl": mcsl}
    (out / "log" / "workflow.json").write_text(json.dumps(given))
    command = [*engine.command(out), *more]
    told = subprocess.run([sys.executable, "-c", _APART, *command], check=True, capture_output=True, text=True).stdout
    seconds, kib = told.split()
    return Cost(float(seconds), int(kib) / 1024)


def measured(root: Path, count: int) -> list[str]:
    """A column of the table: what so many operations take."""
    archive, out = stubs(root, count)
    keys = [f"{number:06d}" for number in range(count)]
    works = survey(archive, out, progress=Silent())
    looked = cost_of(lambda: survey(archive, out, progress=Silent()))
    one = planned(out, keys[:BATCH], "--dry-run")
    batches = -(-count // BATCH)
    ranked = cost_of(lambda: write_triage(works, out, anonymous=False, progress=Silent()))
    each = len(steps(works[0].job))
    page = (out / "triage.html").stat().st_size
    return [
        f"{count:,}",
        f"{count * each:,}",
        f"{looked:.1f}",
        f"{one.seconds:.1f}",
        f"{batches * one.seconds / 60:.1f}",
        f"{ranked:.1f}",
        f"{page / 1e6:.2f}",
        f"{max(sum(1 for _ in os.scandir(out)), each + 1):,}",
    ]


HEAD = ("operations", "jobs", "looked through, s", f"a batch of {BATCH} planned, s", "all batches planned, min")
HEAD += ("ranked, s", "page, MB", "most entries of a folder")


def main() -> None:
    root = Path(sys.argv[1])
    counts = [int(text) for text in sys.argv[2:]] or [1000, 10_000, 100_000]
    lines = ["| " + " | ".join(HEAD) + " |", "|" + "---|" * len(HEAD)]
    for count in counts:
        shutil.rmtree(root, ignore_errors=True)
        lines.append("| " + " | ".join(measured(root, count)) + " |")
        print(lines[-1], flush=True)
    (RESULTS / "archive.md").write_text(results(counts, lines, root), "utf-8")


def results(counts: Sequence[int], lines: Sequence[str], root: Path) -> str:
    """The page: the table of ``lines``, and what Snakemake takes without batches."""
    shutil.rmtree(root, ignore_errors=True)
    archive, out = stubs(root, 4 * BATCH)
    keys = [path.name for path in sorted(archive.iterdir())]
    once = [(size, planned(out, keys[:size], "--dry-run")) for size in (250, BATCH, 4 * BATCH)]
    run = planned(out, keys[:RUN])
    again = planned(out, keys[:RUN])
    each = len(steps(jobs.load_job(out / keys[0] / "job.json")))
    shutil.rmtree(root, ignore_errors=True)
    said = " ".join((__doc__ or "").split("\n\n")[-1].split())
    machine = f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}"
    call = f"`python -m benchmarks.archive FOLDER {' '.join(map(str, counts))}`"
    text = [
        "# An archive of many operations, before any work\n",
        f"Made by {call} on {date.today()}, {machine}. {said}\n",
        *lines,
        "\nIn one go, without batches:\n",
        "| operations at once | planned, s | s a thousand | memory of Snakemake, MiB |\n|---|---|---|---|",
        *(f"| {n:,} | {c.seconds:.1f} | {1000 * c.seconds / n:.1f} | {c.mib:.0f} |" for n, c in once),
        f"\nStarting jobs that do nothing: {1000 * run.seconds / RUN / each:.0f} ms of the processor a job, "
        f"of {RUN} operations; again, with nothing to do: {again.seconds:.1f} s.\n",
    ]
    return "\n".join(text)


if __name__ == "__main__":
    main()
