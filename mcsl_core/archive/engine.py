"""Hands an archive's jobs to Snakemake, a thousand operations at a time, and listens how far it is."""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import IO

from attrs import field, frozen

from mcsl_core.children import ended_afterwards
from mcsl_core.documents import write_atomic
from mcsl_core.errors import McslError
from mcsl_core.progress import Progress

WORKFLOW = Path(__file__).with_name("workflow.smk")
BATCH = 1000  # operations whose jobs Snakemake plans at once: see benchmarks/results/archive.md
_TAKEN_BACK_S = 1.0
_DONE = re.compile(r"(\d+) of (\d+) steps")


def _this_mcsl() -> str:
    return f"{shlex.quote(sys.executable)} -m mcsl_core.cli"


@frozen
class Engine:
    """Where jobs run.

    Parameters
    ----------
    cores : int
        Of this machine that are used, where there is no profile.
    profile : str, optional
        Snakemake's profile, which says to which cluster or cloud jobs go, and how many at a time.
    threads : int
        Cores a job asks for.
    mcsl : str
        How a job's shell calls mcsl; by this Python without.
    """

    cores: int = field(factory=lambda: os.cpu_count() or 1)
    profile: str | None = None
    threads: int = 2
    mcsl: str = field(factory=_this_mcsl)

    def check(self) -> None:
        """McslError where there is no Snakemake."""
        if importlib.util.find_spec("snakemake") is None:
            raise McslError("an archive needs Snakemake", remedy='Install it: pip install "mcsl[archive]"')

    def run(self, keys: Sequence[str], out: Path, *, anonymous: bool, progress: Progress) -> None:
        """Does what is to be done for the operations of these names in ``out``; jobs that fail stop no others.

        Raises
        ------
        McslError
            Where Snakemake itself cannot work. Failed jobs are told by what they left.
        """
        self.check()
        (out / "log").mkdir(parents=True, exist_ok=True)
        for start in range(0, len(keys), BATCH):
            batch = keys[start : start + BATCH]
            given = {"operations": list(batch), "threads": self.threads, "mcsl": self.mcsl, "anonymous": anonymous}
            write_atomic(out / "log" / "workflow.json", json.dumps(given).encode())
            which = f"operations {start + 1} to {start + len(batch)}" if len(keys) > BATCH else "operations"
            self._run(out, which, progress)

    def command(self, out: Path) -> list[str]:
        """Snakemake's command line for what ``out``/log/workflow.json names."""
        where = ["--profile", self.profile] if self.profile else ["--cores", str(self.cores)]
        return [
            *(sys.executable, "-m", "snakemake", "--snakefile", str(WORKFLOW), "--directory", str(out), *where),
            *("--configfile", str((out / "log" / "workflow.json").resolve())),
            *("--keep-going", "--rerun-incomplete", "--rerun-triggers", "mtime"),
            # Our own lock is let go of however a run ends; a file of facts for every mark is of no use to us.
            *("--nolock", "--drop-metadata", "--quiet", "rules", "reason", "host"),
        ]

    def _run(self, out: Path, which: str, progress: Progress) -> None:
        progress.stage(f"Planning {which}")
        log = out / "log" / "snakemake.txt"
        child = subprocess.Popen(
            self.command(out),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            start_new_session=os.name != "nt",  # so that nothing of it outlives a run that is stopped
        )
        with ended_afterwards(child), _asked_to_stop(child), log.open("a", encoding="utf-8", errors="replace") as kept:
            lines = _listened(child, kept, which, progress)
            code = child.wait()
        if code and not any("Complete log" in line for line in lines):
            said = next((line.strip() for line in reversed(lines) if line.strip()), "")
            raise McslError(f"Snakemake ended with {code}: {said}", where=str(log), remedy="Read what it says there")


def _listened(child: subprocess.Popen[str], kept: IO[str], which: str, progress: Progress) -> list[str]:
    """Tells how far Snakemake is; its last lines."""
    total, lines = 0, list[str]()
    assert child.stdout is not None
    for line in child.stdout:
        kept.write(line)
        lines = [*lines[-19:], line]
        if found := _DONE.search(line):
            if total != int(found[2]):
                total = int(found[2])
                progress.stage(f"Working on {which}", total, "jobs")
            progress.advance(int(found[1]))
    return lines


@contextlib.contextmanager
def _asked_to_stop(child: subprocess.Popen[str]) -> Iterator[None]:
    """Who stops within it leaves Snakemake a moment to take its jobs back from a cluster."""
    try:
        yield
    except BaseException:
        if os.name != "nt":
            with contextlib.suppress(OSError, subprocess.TimeoutExpired):
                os.killpg(child.pid, signal.SIGINT)
                child.wait(_TAKEN_BACK_S)
        raise
