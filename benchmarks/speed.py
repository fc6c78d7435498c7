"""What the analysis costs, against decoding only the keyframes of the same files.

    python -m benchmarks.speed FOLDER [MINUTES]       writes results/speed.md

Five cameras, 1920x1080 at 30 frames a second, a keyframe a second, with sound. Two simulated clips of 20 s, in one of
which the lamp moves, are joined packet by packet to MINUTES (10): every join after the one with the movement is one
more jump of the lamp. Yardstick and analysis each run in one process of their own.
"""

from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
import sys
import time
from datetime import date
from pathlib import Path
from typing import Any

import av

from benchmarks.recordings import elsewhere
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate

RESULTS = Path(__file__).parent / "results"
CLIP_S = 20.0
SIZE, RATE = (1920, 1080), 30

KEYFRAMES = """
import sys, threading
import av
def decode(path):
    with av.open(path) as container:
        stream = container.streams.video[0]
        stream.codec_context.skip_frame = "NONKEY"
        stream.codec_context.thread_count = 1
        print(path, sum(1 for _ in container.decode(stream)))
threads = [threading.Thread(target=decode, args=(p,)) for p in sys.argv[1:]]
[t.start() for t in threads]; [t.join() for t in threads]
"""
# The clips' sound repeats, so that it fits at every 20 s: all of it is heard, and then refused.
WAY = ("--progress", "none", "analyse", "--sync", "audio")
ANALYSE = "import sys; from mcsl_core.cli.main import main; sys.exit(main(sys.argv[1:]))"


def recording(folder: Path, minutes: float) -> Path:
    """The five files, made when they are not there yet."""
    made = folder / f"{minutes:g}-minutes"
    if made.exists():
        return made
    common = {"duration_s": CLIP_S, "size": SIZE, "rate": RATE, "clock_offset_s": 0.0, "drift_ppm": 0.0}
    clips = {
        "still": Scenario(seed=451, movements=0, **common),
        "moved": Scenario(seed=451, movements=((8.0, 3.0),), **common),
    }
    for name, scenario in clips.items():
        if not (folder / name / "truth.json").exists():
            simulate(scenario, folder / name, Silent())
    count = round(minutes * 60 / CLIP_S)
    order = ["moved" if n == count // 2 else "still" for n in range(count)]
    part = made.with_name(made.name + ".part")
    part.mkdir(parents=True, exist_ok=True)
    for camera in clips["still"].camera_names:
        join([folder / name / f"{camera}.mp4" for name in order], part / f"{camera}.mp4")
    part.rename(made)
    return made


def join(sources: list[Path], target: Path) -> None:
    """Files of one kind one after another, packet by packet."""
    with av.open(str(target), "w") as out:
        streams: dict[str, Any] = {}
        last: dict[str, Any] = {}
        shift_s = 0.0
        for source in sources:
            with av.open(str(source)) as container:
                for stream in container.streams:
                    if stream.type not in streams:
                        streams[stream.type] = out.add_stream_from_template(stream)
                for packet in container.demux():
                    if packet.dts is None or packet.time_base is None:
                        continue
                    kind, shift = packet.stream.type, round(shift_s / packet.time_base)
                    packet.pts, packet.dts = (packet.pts or 0) + shift, packet.dts + shift
                    if packet.dts * packet.time_base <= last.get(kind, -1):
                        continue  # the last block of sound reaches into the next clip
                    last[kind] = packet.dts * packet.time_base
                    packet.stream = streams[kind]
                    out.mux(packet)
            shift_s += CLIP_S


def run(code: str, *arguments: str) -> dict[str, float]:
    """Wall and CPU seconds and the most memory (MiB) of a fresh Python that runs ``code``."""
    began = time.monotonic()
    process = subprocess.Popen([sys.executable, "-c", code, *arguments], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"failed: {arguments}")
    wall = time.monotonic() - began
    return {"wall_s": wall, "cpu_s": usage.ru_utime + usage.ru_stime, "mib": usage.ru_maxrss / 1024}


def main() -> None:
    folder = Path(sys.argv[1])
    minutes = float(sys.argv[2]) if len(sys.argv) > 2 else 10.0
    source = elsewhere(recording, folder, minutes)
    files = [str(p) for p in sorted(source.glob("*.mp4"))]
    out = folder / f"{minutes:g}-minutes.edl.json"
    keyframes = run(KEYFRAMES, *files)
    shutil.rmtree(out.with_name(f"{out.stem}.cache"), ignore_errors=True)
    print("keyframes", keyframes, flush=True)
    analysis = run(ANALYSE, *WAY, str(source), "-o", str(out))
    print("analysis", analysis, flush=True)
    selector = run(ANALYSE, *WAY, str(source), "-o", str(out), "--selector", "fixed")
    seconds = 60 * minutes
    figures = {
        "keyframes": keyframes,
        "analysis": analysis,
        "another selector, from the cache": selector,
    }
    print(json.dumps(figures, indent=1))
    rows = [
        f"| {name} | {f['wall_s']:.0f} | {f['cpu_s']:.0f} | {f['wall_s'] / keyframes['wall_s']:.2f} | "
        f"{f['cpu_s'] / keyframes['cpu_s']:.2f} | {seconds / f['wall_s']:.1f} | {f['mib']:.0f} |"
        for name, f in figures.items()
    ]
    made = json.loads(out.read_text("utf-8"))
    text = "\n".join(
        [
            "# Speed and memory of the analysis",
            "",
            f"Made by `python -m benchmarks.speed FOLDER {minutes:g}` on {date.today().isoformat()}, "
            f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}. Five files of "
            f"{minutes:g} minutes, 1920x1080 at 30 frames a second, a keyframe a second; the lamp moved or jumped "
            f"{len(made['movements'])} times. Yardstick: decoding only the keyframes, a thread a camera. Reach: at "
            "most 2 times its time, 6 times real time, 2048 MiB.",
            "",
            "| | wall s | CPU s | times the yardstick's wall | CPU | times real time | most MiB |",
            "|---|---|---|---|---|---|---|",
            *rows,
            "",
        ]
    )
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / "speed.md").write_text(text, "utf-8")
    print(text)


if __name__ == "__main__":
    main()
