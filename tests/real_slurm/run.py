"""An archive on a real Slurm of two nodes on one machine: run by hand, as root, on Debian.

    python tests/real_slurm/run.py WORK

WORK takes everything: Debian's packages of Slurm and munge (unpacked there, nothing is installed), the daemons' files,
an archive of simulated operations, results. This Python has the extra `archive` and
snakemake-executor-plugin-slurm. The daemons listen on the loopback interface. It

- works the archive through by `mcsl archive --profile` while running jobs are killed by scancel, and while a node dies
  in the middle with all that runs on it, and comes back;
- holds EDLs, chunks and videos against those of the same archive worked through without a cluster;
- says on which nodes jobs ran, and ends with 1 where something is not as it should be.

The daemons that it started are ended with it.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import hashlib
import os
import shutil
import socket
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import psutil

from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate

PORT = 26817
NODES = ("node1", "node2")
OPERATIONS = 8
KILLS = 3
NODE_DIES_AT = 12  # jobs seen
NODE_IS_AWAY_S = 10
SCENE = Scenario(seed=5, duration_s=12, size=(128, 72), rate=5, cameras=2, movements=0)
CONFIGURATION = """
ClusterName=mcsl
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={work}/munge.socket
CredType=cred/munge
PluginDir={plugins}
StateSaveLocation={work}/state
SlurmdSpoolDir={work}/spool.%n
SlurmctldPidFile={work}/slurmctld.pid
SlurmdPidFile={work}/slurmd.%n.pid
SlurmctldLogFile={work}/slurmctld.log
SlurmdLogFile={work}/slurmd.%n.log
SlurmdParameters=config_overrides
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
MinJobAge=3600
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
ReturnToService=2
SlurmdTimeout=30
{nodes}
PartitionName=batch Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""
PROFILE = """
executor: slurm
jobs: 4
latency-wait: 30
slurm-no-account: true
slurm-status-command: squeue
slurm-init-seconds-before-status-checks: 5
default-resources:
  slurm_partition: batch
"""


class Cluster:
    """Slurm's and munge's programs below a folder, and the daemons that run from there."""

    def __init__(self, work: Path) -> None:
        self.work, self.root = work, work / "root"
        self.started: list[subprocess.Popen[bytes]] = []
        self.nodes: dict[str, subprocess.Popen[bytes]] = {}
        libraries = self.root / "usr/lib/x86_64-linux-gnu"
        self.plugins = libraries / "slurm-wlm"
        self.environment = {
            **os.environ,
            "SLURM_CONF": str(work / "slurm.conf"),
            "LD_LIBRARY_PATH": f"{self.plugins}:{libraries}",
            "PATH": f"{work}/bin:{os.environ['PATH']}",
        }

    def fetch(self) -> None:
        """Debian's packages, unpacked."""
        debs = self.work / "debs"
        (debs / "partial").mkdir(parents=True, exist_ok=True)
        words = ["apt-get", "install", "-y", "--download-only", "--no-install-recommends"]
        subprocess.run([*words, "-o", f"Dir::Cache::archives={debs}", "slurm-wlm", "munge"], check=True)
        for deb in debs.glob("*.deb"):
            subprocess.run(["dpkg", "-x", str(deb), str(self.root)], check=True)

    def configure(self) -> None:
        for name in ("bin", "state", *(f"spool.{node}" for node in NODES)):
            shutil.rmtree(self.work / name, ignore_errors=True)
            (self.work / name).mkdir()
        for program in (self.root / "usr/bin").iterdir():  # jobs lose SLURM_CONF: Snakemake's plugin clears SLURM_*
            ours = self.work / "bin" / program.name
            ours.write_text(f'#!/bin/sh\nSLURM_CONF={self.work}/slurm.conf exec {program} "$@"\n')
            ours.chmod(0o755)
        key = self.work / "munge.key"
        key.unlink(missing_ok=True)
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        host = socket.gethostname().partition(".")[0]
        nodes = "\n".join(
            f"NodeName={node} NodeHostname={host} NodeAddr=127.0.0.1 Port={PORT + 1 + at} CPUs=2 RealMemory=12000"
            for at, node in enumerate(NODES)
        )
        text = CONFIGURATION.format(work=self.work, plugins=self.plugins, host=host, port=PORT, nodes=nodes)
        (self.work / "slurm.conf").write_text(text)

    @contextlib.contextmanager
    def running(self) -> Iterator[None]:
        """Within it the daemons run; afterwards those that were started here have ended."""
        sbin, work = self.root / "usr/sbin", self.work
        munge = [f"--{name}={work}/munge.{name.partition('-')[0]}" for name in ("socket", "pid-file", "log-file")]
        munge += [f"--key-file={work}/munge.key", f"--seed-file={work}/munge.seed", "--foreground", "--force"]
        commands = [
            [str(sbin / "munged"), *munge],
            [str(sbin / "slurmctld-wlm"), "-D"],
        ]
        try:
            for command in commands:
                self._start(command)
            for node in NODES:
                self.nodes[node] = self._start_node(node)
            self.wait_until_idle()
            yield
        finally:
            for child in reversed(self.started):
                child.terminate()
            for child in self.started:
                child.wait(30)

    def _start(self, command: list[str]) -> subprocess.Popen[bytes]:
        log = (self.work / f"{Path(command[0]).name}.out").open("ab")
        self.started.append(subprocess.Popen(command, env=self.environment, stdout=log, stderr=log))
        time.sleep(2)
        return self.started[-1]

    def _start_node(self, node: str) -> subprocess.Popen[bytes]:
        sbin = self.root / "usr/sbin"
        return self._start([str(sbin / "slurmd-wlm"), "-D", "-N", node, "-d", str(sbin / "slurmstepd-wlm")])

    def kill_node(self, node: str) -> int:
        """Ends a node and all that runs on it as a power cut would, and starts it again; how many processes went."""
        jobs = self.call("squeue", "-h", "-t", "RUNNING", "-w", node, "-o", "%i").split()
        self.nodes[node].kill()
        doomed = {
            each
            for process in psutil.process_iter(["cmdline"])
            if any(f"slurmstepd-wlm: [{job}." in " ".join(process.info["cmdline"] or ()) for job in jobs)
            for each in (process, *process.children(recursive=True))
        }
        for process in doomed:
            with contextlib.suppress(psutil.Error):
                process.kill()
        time.sleep(NODE_IS_AWAY_S)
        self.nodes[node] = self._start_node(node)
        return len(doomed)

    def call(self, *words: str) -> str:
        return subprocess.run(words, env=self.environment, capture_output=True, text=True, check=False).stdout

    def wait_until_idle(self) -> None:
        for _ in range(60):
            if self.call("sinfo", "-h", "-o", "%D %t").strip() == f"{len(NODES)} idle":
                return
            time.sleep(1)
        sys.exit(f"the nodes do not come up: {self.call('sinfo')}; see {self.work}/*.log")


def products(out: Path) -> dict[str, str]:
    """EDLs, chunks, sound and videos by their hash."""
    found = (path for path in sorted(out.rglob("*")) if path.suffix in (".mp4", ".wav") or path.name == "edl.json")
    return {path.relative_to(out).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in found}


def archived(cluster: Cluster, out: Path, *more: str) -> subprocess.Popen[bytes]:
    words = ["archive", str(cluster.work / "archive"), "-o", str(out), "--threads", "1", *more]
    command = [sys.executable, "-m", "mcsl_core.cli", "--progress", "lines", *words]
    return subprocess.Popen(command, env=cluster.environment)


def watched(cluster: Cluster, child: subprocess.Popen[bytes]) -> tuple[Counter[str], int, int]:
    """Until the run ends: which nodes had jobs, how many jobs were killed, and processes with a node."""
    seen: dict[str, str] = {}
    killed: set[str] = set()
    with_node = 0
    while child.poll() is None:
        for line in cluster.call("squeue", "-h", "-t", "RUNNING", "-o", "%i %N").splitlines():
            job, node = line.split()
            if job not in seen and len(killed) < KILLS and len(seen) % 4 == 2:
                cluster.call("scancel", "--signal=KILL", "--full", job)
                killed.add(job)
            seen[job] = node
            if not with_node and len(seen) >= NODE_DIES_AT and node == NODES[1]:
                with_node = cluster.kill_node(node)
        time.sleep(0.5)
    return Counter(seen.values()), len(killed), with_node


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", type=Path)
    work: Path = parser.parse_args().work.resolve()
    work.mkdir(parents=True, exist_ok=True)
    cluster = Cluster(work)
    if not (cluster.root / "usr/bin/sbatch").exists():
        cluster.fetch()
    cluster.configure()
    for name in ("archive", "calm", "results"):
        shutil.rmtree(work / name, ignore_errors=True)
    simulate(SCENE, work / "archive" / "op1", Silent())
    for number in range(2, OPERATIONS + 1):
        shutil.copytree(work / "archive" / "op1", work / "archive" / f"op{number}")
    (work / "profile").mkdir(exist_ok=True)
    (work / "profile" / "config.yaml").write_text(PROFILE)
    assert archived(cluster, work / "calm").wait() == 0
    with cluster.running():
        nodes, killed, with_node = watched(
            cluster, archived(cluster, work / "results", "--profile", str(work / "profile"))
        )
        if killed:  # a job that was killed is tried again in the same run, or in the next
            archived(cluster, work / "results", "--profile", str(work / "profile")).wait()
    with (work / "results" / "operations.csv").open() as stream:
        states = Counter(row["state"] for row in csv.DictReader(stream))
    same = products(work / "results") == products(work / "calm")
    print(
        f"jobs by node: {dict(nodes)}; {killed} killed; {with_node} processes killed with {NODES[1]}, which came back; "
        f"operations: {dict(states)}; products are the same: {same}"
    )
    if not (same and with_node and set(nodes) == set(NODES) and states == {"done": OPERATIONS}):
        sys.exit(1)


if __name__ == "__main__":
    main()
