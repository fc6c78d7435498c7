"""How long a command lives after Ctrl-C, SIGTERM or SIGHUP, sent at random moments from its start to its end.

    python benchmarks/stops.py --times 20 [COMMAND ...]

Prints a table: for each command the longest and the median time to death, and everything that is not as it should be:
another exit code than 130 (or 0, where it had ended), a traceback, a child that lives on, a file that is half-written.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from attrs import field, frozen

MCSL = (sys.executable, "-m", "mcsl_core.cli", "--progress", "lines")
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
COMMANDS = {
    "simulate": ("simulate", "made", "--duration", "12", "--size", "320x180", "--rate", "10"),
    "analyse": ("analyse", "rec", "-o", "new.json"),
    "analyse --no-cache": ("analyse", "rec", "-o", "new.json", "--no-cache"),
    "conform": ("conform", "edl.json", "-o", "conformed"),
    "render direct": ("render", "edl.json", "-o", "film.mp4", "--engine", "direct"),
    "render": ("render", "edl.json", "-o", "film.mp4"),
    "render a timeline": ("render", "work.blend", "-o", "film.mp4"),
    "timeline": ("timeline", "edl.json", "-o", "edit.blend"),
    "pull": ("pull", "work.blend", "-o", "pulled.json"),
    "evaluate": ("evaluate", "edl.json", "--json", "figures.json"),
    "report": ("report", "edl.json", "-o", "page.html"),
    "look": ("look", "edl.json", "--no-fill"),
    "plugins": ("plugins",),
    "blender": ("blender",),
}
MADE = (
    "made",
    "new.json",
    "new.cache",
    "new.scores.npz",
    "conformed",
    "film.mp4",
    "edit.blend",
    "pulled.json",
    "edl.conformed",
    "figures.json",
    "page.html",
)


@frozen
class Stop:
    """One command stopped once: how long it lived after the signal, and what was wrong."""

    after_s: float
    lived_s: float
    code: int
    faults: tuple[str, ...] = field(default=())


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--times", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("commands", nargs="*", default=list(COMMANDS))
    how = parser.parse_args(arguments)
    chance, wrong = random.Random(how.seed), False
    with tempfile.TemporaryDirectory(prefix="mcsl-stops-") as name:
        folder = Path(name)
        prepare(folder, any("work.blend" in COMMANDS[command] for command in how.commands))
        print("| command | stops | after s | median s | longest s | codes | faults |\n|---|---|---|---|---|---|---|")
        for command in how.commands:
            stops = list(stopped(folder, COMMANDS[command], how.times, chance))
            lived = [stop.lived_s for stop in stops]
            after = f"{min(s.after_s for s in stops):.1f} to {max(s.after_s for s in stops):.1f}"
            codes = ", ".join(
                f"{code}: {sum(s.code == code for s in stops)}" for code in sorted({s.code for s in stops})
            )
            faults = "; ".join(sorted({fault for stop in stops for fault in stop.faults})) or "none"
            row = (command, len(stops), after, f"{statistics.median(lived):.2f}", f"{max(lived):.2f}", codes, faults)
            print("|", " | ".join(map(str, row)), "|", flush=True)
            wrong = wrong or faults != "none"
    return int(wrong)


def prepare(folder: Path, timeline: bool) -> None:
    """A recording and its EDL, and its timeline where one is worked at."""
    for command in (
        ("simulate", "rec", "--duration", "12", "--size", "320x180", "--rate", "10"),
        ("analyse", "rec", "-o", "edl.json"),
        *((("timeline", "edl.json", "-o", "work.blend"),) if timeline else ()),
    ):
        subprocess.run([*MCSL, *command], cwd=folder, check=True, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)


def stopped(folder: Path, command: Sequence[str], times: int, chance: random.Random) -> Iterator[Stop]:
    """The command begun and stopped so often, at moments spread over the time that it takes when nobody stops it."""
    whole_s = stop_after(folder, command, None).after_s
    first = 2 * start_s()
    for number in range(times):
        moment = first + max(whole_s - first, first) * (number + chance.random()) / times
        yield stop_after(folder, command, SIGNALS[number % len(SIGNALS)], moment)


def start_s() -> float:
    """How long Python takes here until it runs mcsl; before, it ends by the signal itself."""
    began = time.monotonic()
    subprocess.run([sys.executable, "-c", "from mcsl_core.cli import stopping; stopping.install()"], check=True)
    return time.monotonic() - began


def stop_after(folder: Path, command: Sequence[str], number: int | None, after_s: float = 600.0) -> Stop:
    """Begins the command in the folder, sends it the signal ``number`` after so many seconds, and looks around."""
    for name in MADE:
        path = folder / name
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
    before = {path.name for path in folder.iterdir()}
    room = folder / "tmp"
    room.mkdir(exist_ok=True)
    said, edl = folder / "said", (folder / "edl.json").read_bytes()
    began = time.monotonic()
    with said.open("wb") as stream:
        child = subprocess.Popen(
            [*MCSL, *command],
            cwd=folder,
            stdout=stream,
            stderr=stream,
            env={**os.environ, "TMPDIR": str(room)},
            # A shell's background job passes on that it ignores Ctrl-C; a person's terminal does not.
            preexec_fn=lambda: [signal.signal(n, signal.SIG_DFL) for n in SIGNALS],
        )
    try:
        child.wait(after_s)
        ended_s, lived_s = time.monotonic() - began, 0.0
    except subprocess.TimeoutExpired:
        sent = time.monotonic()
        child.send_signal(number or signal.SIGKILL)
        child.wait(60)
        ended_s, lived_s = sent - began, time.monotonic() - sent
    faults = list(_faults(folder, room, said.read_text("utf-8", "replace"), child.returncode, before, lived_s > 0))
    if (folder / "edl.json").read_bytes() != edl and command[0] != "look":
        faults.append("the EDL changed")
    (folder / "edl.json").write_bytes(edl)
    shutil.rmtree(room)
    said.unlink()
    return Stop(ended_s, lived_s, child.returncode, tuple(faults))


def _faults(folder: Path, room: Path, said: str, code: int, before: set[str], was_stopped: bool) -> Iterator[str]:
    if code not in ((0, 130) if was_stopped else (0,)):
        yield f"exit code {code}: {' '.join(said.split()[-20:])}"
    if "Traceback" in said or "Exception ignored" in said:
        yield f"a traceback: {said.strip().splitlines()[-1]}"
    if code == 130 and said.count("mcsl: stopped") != 1:
        yield f"told {said.count('mcsl: stopped')} times"
    time.sleep(0.1)
    for path in room.iterdir():
        yield f"left in the temporary folder: {path.name.rstrip('0123456789abcdef_')}"
    for path in folder.rglob("*"):
        if path.name.endswith((".part", ".tmp")) or ".tmp." in path.name:
            yield f"half-written: {path.parent.name}/*{path.suffix}"
    if left := _living(room):
        yield f"a child lives on: {left}"


def _living(room: Path) -> str:
    """The command line of a process that works in the temporary folder ``room``."""
    for place in Path("/proc").glob("[0-9]*"):
        try:
            line = (place / "cmdline").read_bytes().decode(errors="replace").replace("\0", " ")
            if str(room) in line:
                return line[:80]
        except OSError:
            continue
    return ""


if __name__ == "__main__":
    sys.exit(main())
