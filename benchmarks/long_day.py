"""Whether memory stays flat over a long operation, and what an hour takes of the disk.

    python -m benchmarks.long_day FOLDER [MINUTES]       writes results/long_day.md and .svg

Five cameras, small, at 10 frames a second: simulated clips of 20 s joined to ten minutes, in which the lamp moves once,
and those again and again under other names as the parts of each camera, MINUTES (180) in all. `mcsl analyse` and
`mcsl conform` run as a user runs them; their resident memory is read twice a second, and laid over what they tell of
their progress. Reach: from ten minutes of recording on, at most 10 % more than there.
"""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from datetime import date
from pathlib import Path

from attrs import define, field

from benchmarks.speed import CLIP_S, join
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate

RESULTS = Path(__file__).parent / "results"
PART_MIN, SIZE, RATE = 10, (256, 144), 10
REACH = 0.10


@define
class Run:
    """A command's memory over its stages.

    Attributes
    ----------
    name
        The command.
    stages
        Stage -> (share that is done, MiB), in order of time.
    wall_s
        How long it took.
    """

    name: str
    stages: dict[str, list[tuple[float, float]]] = field(factory=dict)
    wall_s: float = 0.0


def recording(folder: Path, minutes: int) -> Path:
    """The parts of the five cameras, made when they are not there yet."""
    made = folder / f"day-{minutes}"
    if made.exists():
        return made
    common = {"duration_s": CLIP_S, "size": SIZE, "rate": RATE, "clock_offset_s": 0.0, "drift_ppm": 0.0}
    clips = {"still": 0, "moved": ((8.0, 3.0),)}
    for name, movements in clips.items():
        if not (folder / f"day-{name}" / "truth.json").exists():
            simulate(Scenario(seed=451, movements=movements, **common), folder / f"day-{name}", Silent())
    count = round(PART_MIN * 60 / CLIP_S)
    order = ["moved" if n == count // 2 else "still" for n in range(count)]
    part = made.with_name(made.name + ".part")
    part.mkdir(parents=True, exist_ok=True)
    for camera in sorted(path.stem for path in (folder / "day-still").glob("*.mp4")):
        first = part / f"{camera}_000.mp4"
        join([folder / f"day-{name}" / f"{camera}.mp4" for name in order], first)
        for number in range(1, minutes // PART_MIN):
            os.link(first, part / f"{camera}_{number:03d}.mp4")
    part.rename(made)
    return made


def watched(name: str, *arguments: str) -> Run:
    """Runs a command of mcsl, and watches its memory."""
    run, began = Run(name), time.monotonic()
    command = [sys.executable, "-m", "mcsl_core.cli", "--progress", "json", *arguments]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    now: dict[str, object] = {"stage": "Starting", "total": None, "done": 0}

    def listen() -> None:
        for line in process.stdout or ():
            message = json.loads(line)
            now.update({"done": 0} | message if "stage" in message else message)

    listener = threading.Thread(target=listen)
    listener.start()
    while process.poll() is None:
        total, done = now["total"], now["done"]
        share = done / total if isinstance(done, int) and isinstance(total, int) and total else 0.0
        run.stages.setdefault(str(now["stage"]), []).append((share, resident_mib(process.pid)))
        time.sleep(0.5)
    listener.join()
    if process.returncode:
        raise SystemExit(f"failed: {arguments}")
    run.wall_s = time.monotonic() - began
    return run


def resident_mib(pid: int) -> float:
    try:
        fields = Path(f"/proc/{pid}/statm").read_text().split()
    except (OSError, IndexError):
        return 0.0
    return int(fields[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20 if len(fields) > 1 else 0.0


def growth(samples: Sequence[tuple[float, float]], minutes: int) -> tuple[float, float] | None:
    """(MiB up to ten minutes of recording, the most after them); None for stages too short to say."""
    early = [mib for share, mib in samples if share * minutes <= PART_MIN and mib]
    late = [mib for share, mib in samples if share * minutes > PART_MIN]
    return (max(early), max(late)) if early and len(late) > 5 else None


def folder_mib(folder: Path) -> float:
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) / 2**20


def chart(runs: Sequence[Run]) -> str:
    """Resident memory over the course of each command, a line each."""
    width, height, most = 860, 300, max(m for r in runs for s in r.stages.values() for _, m in s) * 1.1
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" '
        'font-size="12">',
        f'<text x="4" y="14">{most:.0f} MiB</text><text x="4" y="{height - 4}">0</text>',
    ]
    for run, colour in zip(runs, ("#2a6fbb", "#bb4a2a"), strict=False):
        every = [mib for samples in run.stages.values() for _, mib in samples]
        points = " ".join(
            f"{60 + (width - 70) * i / max(1, len(every) - 1):.1f},{height - 20 - (height - 40) * mib / most:.1f}"
            for i, mib in enumerate(every)
        )
        lines.append(f'<polyline fill="none" stroke="{colour}" points="{points}"/>')
        lines.append(
            f'<text x="{80 + 200 * runs.index(run)}" y="14" fill="{colour}">{run.name}, 0 to {run.wall_s:.0f} s</text>'
        )
    return "\n".join([*lines, "</svg>", ""])


def markdown(runs: Sequence[Run], minutes: int, disk: Mapping[str, float]) -> str:
    rows = []
    for run in runs:
        for stage, samples in run.stages.items():
            found = growth(samples, minutes)
            if found is not None:
                rows.append(
                    f"| {run.name} | {stage} | {found[0]:.0f} | {found[1]:.0f} | {found[1] / found[0] - 1:+.1%} |"
                )
    hours = minutes / 60
    return "\n".join(
        [
            "# A long day",
            "",
            f"Made by `python -m benchmarks.long_day FOLDER {minutes}` on {date.today().isoformat()}, "
            f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}. Five cameras of "
            f"{SIZE[0]}x{SIZE[1]} at {RATE} frames a second, {minutes} minutes in parts of {PART_MIN}. Reach: at most "
            f"{REACH:.0%} more than in the first {PART_MIN} minutes of recording.",
            "",
            "| | stage | MiB in the first ten minutes | most after | |",
            "|---|---|---|---|---|",
            *rows,
            "",
            ", ".join(f"{run.name} took {run.wall_s / 60:.1f} minutes" for run in runs)
            + ". Disk an hour: "
            + ", ".join(f"{name} {mib / hours:.0f} MiB" for name, mib in disk.items())
            + ".",
            "",
            "![Memory over time](long_day.svg)",
            "",
        ]
    )


def main() -> None:
    folder, minutes = Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 180
    source, edl = recording(folder, minutes), folder / f"day-{minutes}.json"
    runs = [
        watched("analyse", "analyse", str(source), "-o", str(edl), "--sync", "none", "--no-cache"),
        watched("conform", "conform", str(edl), "--quality", "draft"),
    ]
    disk = {"conform, draft": folder_mib(edl.with_suffix(".conformed"))}
    text = markdown(runs, minutes, disk)
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / "long_day.md").write_text(text, "utf-8")
    (RESULTS / "long_day.svg").write_text(chart(runs), "utf-8")
    print(text)


if __name__ == "__main__":
    main()
