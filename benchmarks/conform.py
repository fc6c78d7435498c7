"""How fast pictures are conformed, against a plain transcode of one of the files; and whether memory stays flat.

    python -m benchmarks.conform FOLDER [ROUNDS]       writes results/conform.md

Five cameras, 1920x1080 at 30 frames a second, simulated; planes and relief from the simulation's truth. Yardstick: PyAV
decodes and encodes one file with the conformed intermediate's encoder settings, both with as many threads as they like;
for pictures laid by the relief (`surface`) beside it the same laid by planes. Every run is a process of its own, timed
from after its imports; rounds go through all runs, so that a load on the machine hits all alike, and ratios are taken
within a round. Memory: the same small file again and again as a camera's files.
"""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from datetime import date
from fractions import Fraction
from pathlib import Path
from statistics import median
from typing import Any

import attrs
import av
import numpy as np

from benchmarks.speed import CLIP_S, RATE, RESULTS, SIZE
from mcsl_core.alignment.colour_match import as_matrix
from mcsl_core.delivery.conform import conform
from mcsl_core.delivery.quality import STANDARD
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.edl import Camera, Edl, Look, Media, Pose, Shot
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate
from mcsl_core.simulation.relief_truth import true_relief
from mcsl_core.simulation.truth import best_plane, load_truth
from mcsl_core.timing import FrameRange

SMALL = (480, 270)
RUN_S = 3 * CLIP_S  # of programme in each run: what is found out once a pose takes two seconds
MINUTES = (2, 20)  # the short and the long run of which memory is compared
WARP, ALL, MOVING = "warp alone", "fill, colour and centering", "the same, the picture gliding"
BY_RELIEF = ", by the relief"
PLANES = {
    WARP: Look(centering=False, fill=False, colour=False, surface=False),
    ALL: Look(surface=False),
    MOVING: Look(surface=False),
}
LOOKS = {name + how: attrs.evolve(look, surface=bool(how)) for name, look in PLANES.items() for how in ("", BY_RELIEF)}
REACH = {WARP + how: 0.9 for how in ("", BY_RELIEF)} | {ALL + BY_RELIEF: 0.7, MOVING + BY_RELIEF: 0.5}
SURFACE_REACH = 0.8  # of the plane's rate
YARDSTICK = "transcode"


def source(folder: Path, size: tuple[int, int]) -> Path:
    """20 s of five cameras, made when they are not there yet; that of 1080p is `benchmarks.speed`'s."""
    made = folder / ("still" if size == SIZE else f"still-{size[0]}")
    if not (made / "truth.json").exists():
        common = {"duration_s": CLIP_S, "rate": RATE, "clock_offset_s": 0.0, "drift_ppm": 0.0}
        simulate(Scenario(seed=451, movements=0, size=size, **common), made, Silent())
    return made


def programme(clip: Path, kind: str, seconds: float) -> Edl:
    """An EDL of ``seconds`` from the second camera, turned by a fifth of a circle against the first, the reference."""
    truth = load_truth(clip)
    frames, repeats = round(seconds * truth.rate), round(seconds * truth.rate / truth.frames)
    cameras = tuple(
        Camera(name, (Media(file, truth.frames),) * repeats, truth.size, truth.rate)
        for name, file in zip(truth.cameras, truth.files, strict=True)
    )
    planes = {name: best_plane(truth, 0, name) for name in truth.cameras}
    planes[truth.reference] = np.eye(3)
    pose = Pose(
        FrameRange(0, frames),
        {name: tuple(map(tuple, plane.tolist())) for name, plane in planes.items()},  # pyright: ignore
        colour={
            name: as_matrix(np.array([1.04, 0.97, 1.02]), np.array([-2.0, 1.0, 3.0])) for name in truth.cameras[1:]
        },
        relief=true_relief(truth, 0),
    )
    held = (12.0, -8.0)  # whole pixels, as `FieldCenterer` holds them
    end = (40.5, 30.25) if kind.startswith(MOVING) else held
    return Edl(
        rate=truth.rate,
        size=truth.size,
        frames=frames,
        reference=truth.reference,
        cameras=cameras,
        poses=(pose,),
        shots=(Shot(FrameRange(0, frames), truth.cameras[1]),),
        look=LOOKS[kind],
        centering=((0, *held), (frames - 1, *end)),
    )


def transcode(path: Path, out: Path) -> int:
    """Decodes and encodes a file with PyAV alone; the number of frames."""
    count = 0
    with av.open(str(path)) as reading, av.open(str(out), "w") as writing:
        stream = reading.streams.video[0]
        stream.thread_type = "AUTO"
        coded: Any = writing.add_stream(STANDARD.encoding.codec, rate=RATE, options=dict(STANDARD.encoding.options))
        coded.width, coded.height, coded.pix_fmt = stream.width, stream.height, "yuv420p"
        coded.codec_context.gop_size = STANDARD.group
        for frame in reading.decode(stream):
            frame.pts, frame.time_base, frame.pict_type = count, Fraction(1, RATE), 0
            writing.mux(coded.encode(frame))
            count += 1
        writing.mux(coded.encode(None))
    return count


def child(kind: str, clip: Path, seconds: float) -> None:
    """One run, in a process of its own: prints what it cost."""
    edl = programme(clip, ALL if kind == YARDSTICK else kind, seconds)
    with tempfile.TemporaryDirectory(prefix="mcsl-conform-") as out:
        wall, cpu = time.monotonic(), time.process_time()
        if kind == YARDSTICK:
            frames = sum(transcode(clip / media.path, Path(out) / "out.mp4") for media in edl.cameras[1].media)
        else:
            frames = edl.frames
            conform(ProgrammeSource(edl, clip), Path(out))
        figures = {
            "wall_ms": 1000 * (time.monotonic() - wall) / frames,
            "cpu_ms": 1000 * (time.process_time() - cpu) / frames,
            "mib": most_mib(),
            "mbit_s": sum(p.stat().st_size for p in Path(out).glob("*.mp4")) * 8e-6 / seconds,
        }
    print(json.dumps(figures))


def most_mib() -> float:
    """The most memory of this process; what `getrusage` says is at least its parent's when it was started."""
    status = Path("/proc/self/status").read_text("ascii")
    return int(status.split("VmHWM:")[1].split()[0]) / 1024


def run(kind: str, clip: Path, seconds: float) -> dict[str, float]:
    """`child` in a process of its own; what it cost."""
    call = [sys.executable, "-m", "benchmarks.conform", "--child", kind, str(clip), str(seconds)]
    figures = json.loads(subprocess.run(call, check=True, capture_output=True, text=True).stdout)
    print(f"{kind} of {seconds:g} s:", {k: round(v, 1) for k, v in figures.items()}, flush=True)
    return figures


def markdown(rounds: list[dict[str, dict[str, float]]], memory: dict[float, float], load: float) -> str:
    """The page: a row a run, then the memory."""
    rows = []
    for kind in rounds[0]:
        of_kind = [r[kind] for r in rounds]
        ratios = {unit: sorted(r[YARDSTICK][unit] / r[kind][unit] for r in rounds) for unit in ("wall_ms", "cpu_ms")}
        rates = [f"{median(v):.2f} ({v[0]:.2f} to {v[-1]:.2f})" for v in ratios.values()]
        values = (f"{median(f[unit] for f in of_kind):.0f}" for unit in ("wall_ms", "cpu_ms", "mbit_s", "mib"))
        rows.append(f"| {kind} | {' | '.join((*values, *rates))} | {REACH.get(kind, '')} |")
    by_relief = []
    for kind in PLANES:
        units = ("wall_ms", "cpu_ms")
        rates = (sorted(r[kind][unit] / r[kind + BY_RELIEF][unit] for r in rounds) for unit in units)
        spread = (f"{median(v):.2f} ({v[0]:.2f} to {v[-1]:.2f})" for v in rates)
        by_relief.append(f"| {kind} | {' | '.join(spread)} | {SURFACE_REACH} |")
    short, long = memory[60.0 * MINUTES[0]], memory[60.0 * MINUTES[1]]
    options = " ".join(f"{k} {v}" for k, v in STANDARD.encoding.options.items())
    return "\n".join(
        [
            "# Speed and memory of conform",
            "",
            f"Made by `python -m benchmarks.conform FOLDER {len(rounds)}` on {date.today().isoformat()}, "
            f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}. {RUN_S:g} s of "
            f"{SIZE[0]}x{SIZE[1]} at {RATE} frames a second; medians of {len(rounds)} rounds. Encoder of both: "
            f"{STANDARD.encoding.codec} {options}, a keyframe every {STANDARD.group} frames. A rate is the "
            "yardstick's time through the run's, in the same round, with the least and the most. When it began, "
            f"{load:.1f} other processes wanted the cores: above 0.5 only CPU times say something.",
            "",
            "| | wall ms a frame | CPU ms | Mbit/s | most MiB | rate by wall time | rate by CPU time | reach |",
            "|---|---|---|---|---|---|---|---|",
            *rows,
            "",
            "Laid by the relief, against the same laid by planes in the same round:",
            "",
            "| | rate by wall time | rate by CPU time | reach |",
            "|---|---|---|---|",
            *by_relief,
            "",
            f"Memory at {SMALL[0]}x{SMALL[1]}, all aids on: {MINUTES[0]} minutes take at most {short:.0f} MiB, "
            f"{MINUTES[1]} minutes {long:.0f} MiB: {long / short - 1:+.1%} (reach: 10 % more at most, and 2048 MiB).",
            "",
        ]
    )


def main() -> None:
    folder, count = Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 5
    load = os.getloadavg()[0]  # before its own recordings are made
    clip, small = source(folder, SIZE), source(folder, SMALL)
    kinds, rounds = [YARDSTICK, *LOOKS], []
    for index in range(count):
        order = kinds if index % 2 == 0 else kinds[::-1]
        made = {kind: run(kind, clip, RUN_S) for kind in order}
        rounds.append({kind: made[kind] for kind in kinds})
    memory = {60.0 * minutes: run(ALL, small, 60.0 * minutes)["mib"] for minutes in MINUTES}
    text = markdown(rounds, memory, load)
    (RESULTS / "conform.md").write_text(text, "utf-8")
    print(text)


if __name__ == "__main__":
    if sys.argv[1] == "--child":
        child(sys.argv[2], Path(sys.argv[3]), float(sys.argv[4]))
    else:
        main()
