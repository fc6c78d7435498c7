"""Kills analyse, conform, render and pull at random moments and looks at what is left. By hand, at length:

    PYTHONPATH=. python tests/kill_runs.py [--times 20] [--seed 1] [analyse conform render timeline pull blender]

After every kill: no input changed, the EDL reads and holds every override, nothing half-written has a final name; the
same command then ends well, its files have the bytes of an undisturbed run, and nothing of the killed run is left.
`timeline`, `pull` and `blender` (a render by Blender) need one. A timeline's bytes are another's with every run: it is
read instead, and holds what was decided. tests/test_kill_runs.py runs a share of it.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import attrs
from attrs import field, frozen

from mcsl_core import edl as edls
from mcsl_core.edl import Override
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate
from mcsl_core.timing import FrameRange

SCENE = Scenario(seed=5, duration_s=24, size=(320, 180), rate=10, cameras=3, movements=0)
DECIDED = Override(FrameRange(30, 60), fill=False, note="by hand")
SHOWN = Override(FrameRange(100, 130), camera="cam2")
KINDS = ("analyse", "conform", "render", "timeline", "pull", "blender")
WORDS = {
    "analyse": ("analyse", "recording", "-o", "edl.json"),
    "conform": ("conform", "edl.json", "--jobs", "2"),
    "render": ("render", "edl.json", "--engine", "direct", "--preset", "review", "-o", "out.mp4"),
    "timeline": ("timeline", "edl.json", "-o", "edit.blend"),
    "pull": ("pull", "edit.blend"),
    "blender": ("render", "edl.json", "--preset", "review", "-o", "out.mp4"),
}


def start(words: tuple[str, ...], folder: Path) -> subprocess.Popen[bytes]:
    """A command in a session of its own, with temporary files of its own."""
    environment = {**os.environ, "TMPDIR": str(folder / "tmp")}
    command = [sys.executable, "-m", "mcsl_core.cli", "--progress", "none", *words]
    log = (folder / "log").open("ab")
    return subprocess.Popen(command, cwd=folder, env=environment, stdout=log, stderr=log, start_new_session=True)


def run(words: tuple[str, ...], folder: Path) -> float:
    """Runs a command to its end; seconds that it took."""
    began = time.monotonic()
    code = start(words, folder).wait()
    assert code == 0, f"{' '.join(words)} ended with {code}: {(folder / 'log').read_text()[-2000:]}"
    return time.monotonic() - began


def contents(folder: Path) -> dict[str, str]:
    """The files below ``folder`` by their hash; lists of outputs hold times and are left out."""
    files = (path for path in folder.rglob("*") if path.is_file() and path.name != "log")
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in files
        if not path.name.endswith("outputs.json")
    }


def read_timeline(folder: Path) -> None:
    """AssertionError where the timeline in ``folder`` cannot be read, or says anything else than the EDL there."""
    run(("pull", "edit.blend", "-o", "read.json"), folder)
    assert (folder / "read.json").read_bytes() == (folder / "edl.json").read_bytes(), "the timeline is another"
    (folder / "read.json").unlink()


@frozen
class Desk:
    """A folder as it is before the command, and what an undisturbed run of it makes."""

    kind: str
    before: Path
    after: dict[str, str] = field(repr=False)
    seconds: float

    @classmethod
    def made(cls, kind: str, begun: Path, root: Path) -> Desk:
        before = root / kind
        shutil.copytree(begun, before)
        path = before / "edl.json"
        edl = attrs.evolve(edls.load(path), overrides=(DECIDED,))
        if kind in ("pull", "timeline"):  # a timeline that shows another camera than its EDL says
            edls.save(attrs.evolve(edl, overrides=(DECIDED, SHOWN)), path)
            run(WORDS["timeline"], before)
        edls.save(edl, path)
        if kind == "analyse":
            shutil.rmtree(before / "edl.cache")
        undisturbed = root / f"{kind}-undisturbed"
        shutil.copytree(before, undisturbed)
        seconds = run(WORDS[kind], undisturbed)
        return cls(kind, before, contents(undisturbed), seconds)

    def killed_once(self, folder: Path, at_s: float) -> bool:
        """Kills one run after ``at_s``; whether it was still at work. AssertionError where anything is lost."""
        shutil.copytree(self.before, folder)
        was = contents(folder)
        child = start(WORDS[self.kind], folder)
        time.sleep(at_s)
        alive = child.poll() is None
        if alive:
            os.killpg(child.pid, signal.SIGKILL)
        child.wait()
        left = contents(folder)
        for name in was:
            assert not name.startswith("recording") or left.get(name) == was[name], "an input has changed"
        assert DECIDED in edls.load(folder / "edl.json").overrides, "an override is gone"
        for name, key in left.items():
            final = not Path(name).name.startswith(".") and name.endswith((".mp4", ".wav"))
            assert not final or key == self.after[name], f"{name} is not whole"
        if self.kind == "timeline" and left["edit.blend"] != was["edit.blend"]:
            read_timeline(folder)
        run(WORDS[self.kind], folder)
        self.check_end(folder)
        shutil.rmtree(folder)
        return alive

    def check_end(self, folder: Path) -> None:
        """The bytes of an undisturbed run, and nothing else."""
        end, after = contents(folder), dict(self.after)
        if self.kind == "timeline":
            read_timeline(folder)
            end["edit.blend"] = after["edit.blend"]
        assert {n: k for n, k in end.items() if not _private(n)} == {
            n: k for n, k in after.items() if not _private(n)
        }, "another end than undisturbed"
        hidden = [name for name in end if Path(name).name.startswith(".")]
        hidden += [path.name for path in (folder / "tmp").iterdir()]
        assert not hidden, f"left: {hidden}"


def _private(name: str) -> bool:
    """Of the cache, where the order of the same results may differ; hidden files are judged by themselves."""
    return name.startswith(("edl.cache/", "tmp/")) or Path(name).name.startswith(".")


def analysed(folder: Path) -> Path:
    """A folder with a recording, its EDL and what was kept in making it."""
    (folder / "tmp").mkdir(parents=True)
    simulate(SCENE, folder / "recording", Silent())
    run(WORDS["analyse"], folder)
    return folder


def kill(kind: str, times: int, chance: random.Random, root: Path, begun: Path) -> tuple[int, int]:
    """How many runs were killed at work, and how many ended before they could be; ``begun`` is `analysed`."""
    desk = Desk.made(kind, begun, root)
    at_work = sum(
        desk.killed_once(root / f"{kind}-{n}", chance.uniform(0.2, desk.seconds * 1.05)) for n in range(times)
    )
    return at_work, times - at_work


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kinds", nargs="*", default=list(KINDS))
    parser.add_argument("--times", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        begun = analysed(Path(name) / "analysed")
        for kind in given.kinds:
            at_work, ended = kill(kind, given.times, random.Random(given.seed), Path(name), begun)
            print(f"{kind}: {at_work} killed at work, {ended} had ended; nothing lost", flush=True)


if __name__ == "__main__":
    main()
