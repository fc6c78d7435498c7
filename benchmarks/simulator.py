"""What simulating costs, against plain coding of the same pictures.

    python -m benchmarks.simulator FOLDER [SECONDS]       writes results/simulator.md

Five cameras of 960x540, the lamp moves once, SECONDS (20) long; filmed in threads, in processes, and there with
`--quick-coding`, one after the other, each in a fresh Python. Yardstick: the pictures of the first camera's file in
memory, coded again with the settings of a simulation without `--quick-coding`.
"""

from __future__ import annotations

import os
import platform
import resource
import subprocess
import sys
import time
from datetime import date
from fractions import Fraction
from pathlib import Path

from mcsl_core.media.frames import to_planes
from mcsl_core.media.probing import probe
from mcsl_core.media.reading import VideoReader
from mcsl_core.simulation import Recorder, Scenario, load_truth

RESULTS = Path(__file__).parent / "results"
SIMULATE = """
import sys
from mcsl_core.progress import Silent
from mcsl_core.simulation import Recorder, Scenario, filming, simulate
folder, seconds, least, quick = sys.argv[1:]
filming.WORTH_A_PROCESS = float(least)
simulate(Scenario(seed=31, duration_s=float(seconds)), folder, Silent(), Recorder(quick_coding=quick == "quick"))
"""
WAYS = (
    ("in threads of one process", "1e18", "usual"),
    ("in a process for each camera", "0", "usual"),
    ("the same with `--quick-coding`", "0", "quick"),
)


def cpu_s(who: int) -> float:
    usage = resource.getrusage(who)
    return usage.ru_utime + usage.ru_stime


def simulated(out: Path, seconds: float, *way: str) -> tuple[float, float]:
    """Wall and CPU seconds of a simulation into ``out``, its processes' included."""
    began, before = time.monotonic(), cpu_s(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", SIMULATE, str(out), str(seconds), *way], check=True)
    return time.monotonic() - began, cpu_s(resource.RUSAGE_CHILDREN) - before


def plain(recording: Path, scenario: Scenario, most: int = 300) -> float:
    """CPU seconds a picture of coding up to ``most`` pictures of a recording's first camera again."""
    facts = probe(recording / "cam1.mp4")
    reader = VideoReader(facts)
    pictures = []
    for _, frame in reader.read(Fraction(0)):
        pictures.append(to_planes(frame, facts))
        if len(pictures) == most:
            break
    reader.close()
    before = cpu_s(resource.RUSAGE_SELF)
    with Recorder().writer(recording / "again.mp4", scenario, audio=False) as writer:
        for picture in pictures:
            writer.write(picture)
    (recording / "again.mp4").unlink()
    return (cpu_s(resource.RUSAGE_SELF) - before) / len(pictures)


def page(seconds: float, rows: list[tuple[str, float, float, int]], yardsticks: list[float], loads: list[float]) -> str:
    """The results page: a row for each way, against the yardstick measured right after it."""
    table = [
        f"| {name} | {wall:.0f} | {cpu:.0f} | {frames / cpu:.0f} | {1000 * yardstick:.1f} | "
        f"{cpu / frames / yardstick:.1f} | {rows[0][1] / wall:.1f} | {load:.0f} |"
        for (name, wall, cpu, frames), yardstick, load in zip(rows, yardsticks, loads, strict=True)
    ]
    return "\n".join(
        [
            "# Speed of the simulator",
            "",
            f"Made by `python -m benchmarks.simulator FOLDER {seconds:g}` on {date.today().isoformat()}, "
            f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}. Five cameras, 960x540, "
            f"{seconds:g} s, {rows[0][3]} pictures with sound and truth, the scene's making and the processes' start "
            "included. Yardstick: x264 alone codes a picture again, with a simulation's usual settings, right after "
            "each. Where the load of the machine before it was more than the cores, others worked there, and seconds "
            "by the wall say little.",
            "",
            "| filmed | wall s | CPU s | pictures a CPU second | yardstick, CPU ms a picture | times the yardstick | "
            "times as fast by wall | load |",
            "|---|---|---|---|---|---|---|---|",
            *table,
            "",
        ]
    )


def main() -> None:
    folder = Path(sys.argv[1])
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 20.0
    rows, yardsticks, loads = [], [], []
    for n, (name, *way) in enumerate(WAYS):
        out = folder / f"way-{n}"
        loads.append(os.getloadavg()[0])
        wall, cpu = simulated(out, seconds, *way)
        truth = load_truth(out)
        yardsticks.append(plain(out, truth.scenario))
        rows.append((name, wall, cpu, sum(truth.camera_frames)))
        print(rows[-1], yardsticks[-1], flush=True)
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / "simulator.md").write_text(page(seconds, rows, yardsticks, loads), "utf-8")


if __name__ == "__main__":
    main()
