"""Any process of an archive's run killed at random, again and again: the end is that of an undisturbed one."""

from __future__ import annotations

import hashlib
import os
import random
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from archive_desk import mcsl

from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate

KILLS = int(os.environ.get("MCSL_KILLS", "4"))  # 20 take some minutes more
SCENE = Scenario(seed=5, duration_s=12, size=(128, 72), rate=5, cameras=2, movements=0)  # two chunks
TABLE = "operation,parts\none,2\ntwo,2\n"
MOST_RUNS = 100


def products(out: Path) -> dict[str, str]:
    """EDLs, chunks, sound and videos by their hash."""
    found = (path for path in sorted(out.rglob("*")) if path.suffix in (".mp4", ".wav") or path.name == "edl.json")
    return {path.relative_to(out).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in found}


def at_work(psutil: Any, out: Path) -> list[Any]:
    """The command, Snakemake, shells and jobs on ``out``, those of killed runs as well."""
    found = []
    for process in psutil.process_iter(["cmdline", "cwd"]):
        told = [*(process.info["cmdline"] or ()), process.info["cwd"] or ""]
        if process.pid != os.getpid() and any(str(out) in words for words in told):
            found.append(process)
    return found


def disturbed(psutil: Any, words: list[str], out: Path, chance: random.Random, killed: list[str]) -> None:
    """One run in which processes are killed as long as there are kills left."""
    child = subprocess.Popen([sys.executable, "-m", "mcsl_core.cli", "--progress", "none", *words, str(out)])
    while child.poll() is None:
        time.sleep(chance.uniform(0.3, 12))  # jobs end in between, so that others come to be killed
        victims = at_work(psutil, out)
        if chance.random() < 0.8:  # most of them jobs: the command itself is at work from the first moment on
            victims = [process for process in victims if "json" in (process.info["cmdline"] or ())]
        if len(killed) >= KILLS or not victims:
            continue
        victim = chance.choice(victims)
        try:
            name = " ".join(victim.cmdline())
            victim.kill()
        except psutil.Error:  # it has ended meanwhile
            continue
        jobs = ("analyse", "conform", "render", "evaluate", "report", "snakemake", "archive")
        killed.append(next((job for job in jobs if f" {job} " in f" {name} "), "another"))


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_whatever_is_killed_the_end_is_the_same(tmp_path: Path) -> None:
    pytest.importorskip("snakemake", reason="the extra `archive` is not installed")
    psutil = pytest.importorskip("psutil")
    archive, table, chance = tmp_path / "archive", tmp_path / "table.csv", random.Random()
    simulate(SCENE, archive / "one", Silent())
    shutil.copytree(archive / "one", archive / "two")
    table.write_text(TABLE)
    words = ["archive", str(archive), "--table", str(table), "--threads", "1", "-o"]
    calm = tmp_path / "calm" / "out"
    assert mcsl(*words, calm).returncode == 0
    expected = products(calm)
    assert sum(name.endswith("programme.mp4") for name in expected) == 2
    assert sum("conformed/" in name and name.endswith(".mp4") for name in expected) == 4
    killed, runs, rounds = list[str](), 0, 0
    while len(killed) < KILLS:
        rounds += 1
        out = tmp_path / f"round{rounds}" / "out"
        while products(out).keys() != expected.keys() or at_work(psutil, out):
            disturbed(psutil, words, out, chance, killed)
            runs += 1
            assert runs < MOST_RUNS, killed
        last = mcsl("--progress", "json", *words, out)
        assert '"operations": {"done": 2}' in last.stdout, (killed, last.stdout, last.stderr)
        assert products(out) == expected, killed
        assert not list(out.rglob(".mcsl-*")), killed
        shutil.rmtree(out)
    print(f"{len(killed)} killed in {runs} runs of {rounds} rounds: {sorted(killed)}")
