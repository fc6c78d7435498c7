"""How the time and memory of a recording grow with its length, its cameras and its pixels.

    python -m benchmarks.growth FOLDER [length|cameras|pixels ...]       writes results/growth.md and .svg

Each series varies one thing and holds the others. `mcsl analyse` and `mcsl conform` run as a user runs them, and what
they tell of their progress says which stage a CPU second went to. CPU seconds, and not the time on the clock, are
fitted: other work on the machine hardly changes them. Every point is kept in FOLDER: a stopped run goes on.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import threading
import time
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
from attrs import frozen

from benchmarks.growth_page import STRAIGHT, chart, markdown, section
from benchmarks.long_day import resident_mib
from benchmarks.recordings import elsewhere
from benchmarks.speed import CLIP_S, join
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate

RESULTS = Path(__file__).parent / "results"
RATE = 5
SAMPLED_S = 0.5
COMMANDS = ("analyse", "conform")


@frozen
class Series:
    """What varies, and what is held.

    Attributes
    ----------
    unit
        Of what varies.
    values
        What it is, at each point.
    labels
        How the page calls these.
    cameras, size
        Of the simulated clips; the series of cameras links the first of them, that of pixels scales them.
    order
        The clips, 20 s each, that are joined to a part.
    """

    unit: str
    values: tuple[float, ...]
    labels: tuple[str, ...]
    cameras: int
    size: tuple[int, int]
    order: tuple[str, ...]


def _parts(minutes: int) -> tuple[str, ...]:
    """Clips of so many minutes, in the middle of which the lamp moves."""
    count = round(minutes * 60 / CLIP_S)
    return tuple("moved" if n == count // 2 else "still" for n in range(count))


SIZES = {"540p": (960, 540), "720p": (1280, 720), "1080p": (1920, 1080), "1440p": (2560, 1440), "2160p": (3840, 2160)}
SERIES = {
    "length": Series("hours", (1, 2, 3, 4), ("1 h", "2 h", "3 h", "4 h"), 3, (192, 108), _parts(60)),
    "cameras": Series("cameras", (3, 4, 5, 6, 7, 8), tuple("345678"), 8, (480, 270), ("still", "moved", "still")),
    "pixels": Series(
        "megapixels", tuple(w * h / 1e6 for w, h in SIZES.values()), tuple(SIZES), 3, SIZES["540p"], ("moved", "moved")
    ),
}


def clips(folder: Path, name: str) -> dict[str, Path]:
    """The simulated clips of a series, by kind, made when they are not there yet."""
    series, made = SERIES[name], {}
    movements = {"still": 0, "moved": ((8.0, 3.0),)}
    for kind in sorted(set(series.order)):
        made[kind] = folder / f"{name}-{kind}"
        if not (made[kind] / "truth.json").exists():
            scenario = Scenario(
                seed=451,
                duration_s=CLIP_S,
                movements=movements[kind],
                size=series.size,
                rate=RATE,
                cameras=series.cameras,
                clock_offset_s=0.0,
                drift_ppm=0.0,
            )
            simulate(scenario, made[kind], Silent())
    return made


def recording(folder: Path, name: str, label: str) -> Path:
    """The camera files of a point, made when they are not there yet."""
    made = folder / f"{name}-{label.replace(' ', '')}"
    if made.exists():
        return made
    series, part = SERIES[name], made.with_name(made.name + ".part")
    value = series.values[series.labels.index(label)]
    count = int(value) if name == "cameras" else series.cameras
    again = round(value * 3600 / (CLIP_S * len(series.order))) if name == "length" else 1
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir(parents=True)
    for camera in (f"cam{n + 1}" for n in range(count)):
        whole = _joined(folder, name, label, f"{camera}.mp4")
        for number in range(again):
            os.link(whole, part / f"{camera}_{number:03d}.mp4")
    part.rename(made)
    return made


def _joined(folder: Path, name: str, label: str, file: str) -> Path:
    """A camera's clips in a series' order as one file, which points of the same pictures share."""
    made = folder / f"{name}-{label if name == 'pixels' else 'all'}-{file}"
    if not made.exists():
        sources = {kind: source / file for kind, source in clips(folder, name).items()}
        if name == "pixels":
            sources = {k: _scaled(s, made.with_name(f"{k}-{made.name}"), SIZES[label]) for k, s in sources.items()}
        part = made.with_name(f"part-{made.name}")
        join([sources[kind] for kind in SERIES[name].order], part)
        part.rename(made)
    return made


def _scaled(source: Path, target: Path, size: tuple[int, int]) -> Path:
    """A clip's pictures at another size, with a keyframe a second, and without sound."""
    with av.open(str(source)) as container, av.open(str(target), "w") as out:
        options = {"crf": "20", "preset": "ultrafast", "bf": "0", "g": str(RATE)}
        stream = out.add_stream("libx264", rate=Fraction(RATE), options=options)
        stream.width, stream.height = size
        stream.pix_fmt = "yuv420p"
        for number, frame in enumerate(container.decode(video=0)):
            picture = frame.reformat(*size, format="yuv420p", interpolation="BICUBIC")
            picture.pts, picture.time_base = number, Fraction(1, RATE)
            out.mux(stream.encode(picture))
        out.mux(stream.encode())
    return target


def family(pid: int) -> list[tuple[int, float]]:
    """A process and all that it has started: ids, and CPU seconds with those of children that have ended."""
    fields: dict[int, list[str]] = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields[int(path.parent.name)] = path.read_text().rpartition(")")[2].split()
        except OSError:
            continue  # it has ended
    found, waiting = [], [pid]
    while waiting:
        now = waiting.pop()
        if now in fields:
            found.append((now, sum(map(int, fields[now][11:15])) / os.sysconf("SC_CLK_TCK")))
            waiting += [child for child, own in fields.items() if int(own[1]) == now]
    return found


def watched(*arguments: str) -> dict[str, Any]:
    """CPU and wall seconds and the most memory (MiB) of a command of mcsl and its children, and CPU seconds a stage."""
    began, stages, most, before = time.monotonic(), {}, 0.0, 0.0
    command = [sys.executable, "-m", "mcsl_core.cli", "--progress", "json", *arguments]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    now = {"stage": "Starting"}

    def listen() -> None:
        for message in map(json.loads, process.stdout or ()):
            if "stage" in message:
                now["stage"] = message["stage"]

    listener = threading.Thread(target=listen)
    listener.start()
    while os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None:
        alive, stage = family(process.pid), now["stage"]
        used = max(before, sum(cpu for _, cpu in alive))
        stages[stage] = stages.get(stage, 0.0) + used - before
        most, before = max(most, sum(resident_mib(pid) for pid, _ in alive)), used
        time.sleep(SAMPLED_S)
    listener.join()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if status:
        raise SystemExit(f"failed: {arguments}")
    return {
        "cpu_s": usage.ru_utime + usage.ru_stime,
        "wall_s": time.monotonic() - began,
        "mib": max(most, usage.ru_maxrss / 1024),
        "stages": stages,
    }


def point(folder: Path, name: str, label: str, command: str) -> dict[str, Any]:
    """The figures of a command at a point, kept; a conform needs the analysis before it."""
    source = elsewhere(recording, folder, name, label)
    kept, edl = folder / f"{source.name}.{command}.json", folder / f"{source.name}.edl.json"
    if kept.exists():
        return json.loads(kept.read_text("utf-8"))
    if command == "analyse":
        found = watched("analyse", str(source), "-o", str(edl), "--sync", "none", "--no-cache", "--force")
        found["poses"] = len(json.loads(edl.read_text("utf-8"))["movements"]) + 1
    else:
        out = folder / f"{source.name}.conformed"
        shutil.rmtree(out, ignore_errors=True)
        found = watched("conform", str(edl), "-o", str(out), "--quality", "draft", "--jobs", "1", "--audio", "none")
        shutil.rmtree(out)
    kept.write_text(json.dumps(found, indent=1), "utf-8")
    print(source.name, command, f"{found['cpu_s']:.0f} s of CPU, {found['mib']:.0f} MiB", flush=True)
    return found


INTRO = (
    f"Simulated clips of {CLIP_S:.0f} s at {RATE} frames a second, joined packet by packet; a clip in which the lamp "
    "moves is one movement, and the join after it a jump.",
    "CPU seconds and memory are those of the command and all it starts (resident, read twice a second).",
    "The time on the clock is kept, not told: it depends on what else is at work.",
    "",
    "- Length: 3 cameras of 192x108, parts of an hour in each of which the lamp moves and jumps once. An hour has its "
    "movements, so that poses grow with the length.",
    "- Cameras: the first 3 to 8 of a recording of 8, 480x270, a minute with a movement and a jump.",
    "- Pixels: 3 cameras, 40 s with two movements and a jump, simulated in 540p and scaled to each size, encoded anew "
    "alike. What they show is the same; the larger ones are no finer, so that a real camera's have more to decode.",
    "",
    f"Straight is what the line through all points misses nowhere by more than {STRAIGHT:.0%} of its value.",
)


def main() -> None:
    folder, names = Path(sys.argv[1]), sys.argv[2:] or list(SERIES)
    if wrong := [name for name in names if name not in SERIES]:
        raise SystemExit(f"no such series: {', '.join(wrong)}; there are {', '.join(SERIES)}")
    found = {
        name: (
            dict(zip(SERIES[name].labels, SERIES[name].values, strict=True)),
            {c: [point(folder, name, label, c) for label in SERIES[name].labels] for c in COMMANDS},
        )
        for name in names
    }
    sections = [line for name, (x, figures) in found.items() for line in section(name, SERIES[name].unit, x, figures)]
    text = markdown(sections, INTRO)
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / "growth.md").write_text(text, "utf-8")
    (RESULTS / "growth.svg").write_text(chart(found), "utf-8")
    print(text)


if __name__ == "__main__":
    main()
