"""The whole way through a real Blender 5.2 LTS with its window: run by hand, as root, on Debian.

    python tests/real_blender/run.py TREE WORK [--project FOLDER] [--pictures FOLDER] [--steps install,desk,...]

TREE holds Debian sid with Blender (made when it is not there: a minute or three, 1.6 GB). WORK takes everything else.
--project: a folder with edl.json and its media, copied to WORK; without it the demo's. --pictures: the window's
pictures go there as well, as JPEG. Each step is done by the real thing:

install   the extension is built, and installed by Blender's own command
desk      its buttons build the timeline, switch cameras and write the overrides into the EDL
conform   this machine's mcsl makes the exact pictures and puts them in place
render    `blender -b edit.blend -a`; the video is compared with `--engine direct`, frame by frame
serve     a range is removed, and the panel's Render runs without a window; compared in the same way
window    the window opens under Xvfb: real keys cut and undo, a nudge is pulled; pictures are taken
first     a new file in the window, the timeline built into it: what is seen before anything is touched
editing   angles, a cut while it plays, locked tracks, a ripple, sound, a range removed and the rest rendered there,
          and exact pictures and an analysis by the panel's buttons
long_day  two hours with 430 shots, built into a new file and cut there

It says what it found and ends with 1 where something is not as it should be. Before TREE is deleted nothing may be
mounted in it (`mount | grep TREE`); this script unmounts what it mounts, also when it fails.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any

import av
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))
sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parent))
import chroot
from chroot import DOOR, Bound
from pictures import psnr

from benchmarks import timeline
from mcsl_core import edl as edls

ROOT = Path(__file__).resolve().parents[2]
STEPS = ("install", "desk", "conform", "render", "serve", "window", "first", "editing", "long_day")
MCSL = Path(sys.executable).with_name("mcsl")
LEAST_DB = 38.0  # two engines' delivery at CRF 17 add up to 39 dB; a frame off comes out below 32: see test_render.py
SCREEN = (1920, 1080)
LONG_DAY, SHOTS = 2 * 60 * 60 * 30, 430  # frames


class Desk:
    """The tree, the work folder, and the commands that run inside and outside."""

    def __init__(self, tree: Path, work: Path) -> None:
        self.tree, self.work = tree, work
        self.project = work / "project"
        self.edl, self.blend = self.project / "edl.json", self.project / "edit.blend"
        self.blender = chroot.blender_for_outside(tree, work / "blender")
        chroot.mcsl_for_inside(tree, MCSL)
        for name in ("tmp", "user", "pictures"):
            (work / name).mkdir(exist_ok=True)
        self.environment = {
            "HOME": str(work),
            "PATH": "/usr/local/bin:/usr/bin:/bin",
            "LANG": "C.UTF-8",
            "TMPDIR": str(work / "tmp"),
            "LIBGL_ALWAYS_SOFTWARE": "1",
            "BLENDER_USER_RESOURCES": str(work / "user"),
        }

    def inside(self, *words: str, within_s: float = 1800) -> str:
        """Runs a command in the tree; returns what it printed, and fails with it."""
        command = [shutil.which("chroot") or "chroot", str(self.tree), *words]
        done = subprocess.run(
            command, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=within_s
        )
        (self.work / "last.log").write_text(done.stdout)
        if done.returncode != 0:
            raise SystemExit(f"{' '.join(words)} ended with {done.returncode}:\n{done.stdout[-4000:]}")
        return done.stdout

    def mcsl(self, *words: str) -> None:
        """This machine's mcsl, with the tree's Blender."""
        environment = os.environ | {"MCSL_BLENDER": str(self.blender), "TMPDIR": str(self.work / "tmp")}
        subprocess.run([str(MCSL), "--progress", "lines", *words], check=True, env=environment)


def install(desk: Desk) -> None:
    target = desk.work / "mcsl.zip"
    environment = os.environ | {"MCSL_BLENDER": str(desk.blender), "TMPDIR": str(desk.work / "tmp")}
    subprocess.run([sys.executable, str(ROOT / "tools" / "extension.py"), str(target)], check=True, env=environment)
    # Fresh: Blender keeps a wheel that is there under the same version, and mcsl_core's is the same from day to day.
    shutil.rmtree(desk.work / "user")
    (desk.work / "user").mkdir()
    said = desk.inside("blender", "--command", "extension", "install-file", "-r", "user_default", "-e", str(target))
    assert 'Installed "mcsl"' in said, said


def make_desk(desk: Desk) -> None:
    script = str(Path(__file__).with_name("inside.py"))
    start = ["blender", "-b", "--python-exit-code", "1"]
    edl = edls.load(desk.edl)
    edls.save(edls.from_json({**edls.to_json(edl), "overrides": [], "corrections": []}), desk.edl)
    desk.inside(*start, "-P", script, "--", "build", str(desk.edl), str(desk.blend))
    shots = [shot for shot in edl.shots if len(shot.range) > 4 * edl.rate][:2]
    wanted = []
    for shot in shots:  # another camera from the middle of the shot on
        other = next(c.name for c in edl.cameras if c.name != shot.camera)
        wanted += [other, str(float((shot.range.start + len(shot.range) // 2) / edl.rate))]
    desk.inside(*start, str(desk.blend), "-P", script, "--", "override", *wanted)
    found = [(o.camera, o.range.stop) for o in edls.load(desk.edl).overrides]
    assert found == [(c, s.range.stop) for c, s in zip(wanted[::2], shots, strict=True)], found
    print(f"overrides by the panel's own operators: {found}")


def conform(desk: Desk) -> None:
    desk.mcsl("conform", str(desk.edl))
    desk.mcsl("timeline", str(desk.edl), "-o", str(desk.blend), "--force")  # the panel built it; its work is pulled


def render(desk: Desk) -> None:
    said = desk.inside("blender", "-b", str(desk.blend), "-a")
    assert "mcsl: warning" not in said, said[-2000:]
    direct = desk.work / "direct.mp4"
    desk.mcsl("render", str(desk.edl), "-o", str(direct), "--engine", "direct")
    compare(desk.project / "edit.mp4", direct, edls.load(desk.edl).frames)


def serve(desk: Desk) -> None:
    """What the docs tell a server where something is removed: the panel's Render, without a window."""
    frames = edls.load(desk.edl).frames
    removed = slice(frames // 4, frames // 2)
    desk.mcsl("remove", str(desk.edl), "--range", f"{removed.start}:{removed.stop}")
    desk.mcsl("timeline", str(desk.edl), "-o", str(desk.blend), "--force")
    press = "import bpy; bpy.ops.mcsl.render()"
    desk.inside("blender", "-b", str(desk.blend), "--python-exit-code", "1", "--python-expr", press)
    direct = desk.work / "direct.mp4"
    desk.mcsl("render", str(desk.edl), "-o", str(direct), "--engine", "direct")
    compare(desk.project / "edit.mp4", direct, frames - len(range(frames)[removed]))
    desk.mcsl("remove", str(desk.edl), "--bring-back")
    desk.mcsl("timeline", str(desk.edl), "-o", str(desk.blend), "--force")


def compare(rendered: Path, direct: Path, frames: int) -> None:
    """The two engines' pictures, luma by luma."""
    figures = []
    with av.open(str(rendered)) as a, av.open(str(direct)) as b:
        for one, other in zip(a.decode(video=0), b.decode(video=0), strict=True):
            figures.append(psnr(*(p.to_ndarray()[: p.height] for p in (one, other))))
    print(f"{len(figures)} frames of {frames}; luma PSNR {min(figures):.1f} to {max(figures):.1f} dB, ", end="")
    print(f"median {np.median(figures):.1f}, between `blender -a` and `--engine direct`")
    assert len(figures) == frames
    assert min(figures) >= LEAST_DB


def at_the_window(desk: Desk, name: str, *start: str) -> dict[str, Any]:
    """One of the pieces of work beside this file, done in Blender's window; what was seen there."""
    script = str(Path(__file__).with_name("window.py"))
    screen = f"-screen 0 {SCREEN[0]}x{SCREEN[1]}x24"
    blender = ["blender", "--gpu-backend", "opengl", "--window-geometry", "0", "0", *map(str, SCREEN)]
    out = desk.work / "pictures"
    desk.inside("xvfb-run", "-a", "-s", screen, *blender, *start, "-P", script, "--", str(out), name, within_s=1800)
    found = json.loads((out / f"{name}.json").read_text())
    assert "error" not in found, found["error"]
    assert found["wrong"] == [], found["wrong"]
    return found


def window(desk: Desk) -> None:
    found = at_the_window(desk, "work", str(desk.blend))
    [correction] = edls.load(desk.edl).corrections
    assert correction.camera == found["nudged"][0]
    moved = [round(correction.matrix[row][2], 2) for row in (0, 1)]
    assert moved == [24, 10], moved  # y down in the programme
    print(
        f"Blender {found['version']}: a key cut and coloured, Ctrl-Z and Ctrl-Shift-Z did what they do, and the nudge"
    )
    print(f"of {correction.camera} came back as {moved} px over {correction.range}")


def first(desk: Desk) -> None:
    found = at_the_window(desk, "first")
    print(f"a new file: tab open, {found['frames']} frames framed, nothing selected")


def editing(desk: Desk) -> None:
    found = at_the_window(desk, "editing", str(desk.blend))
    with av.open(str(desk.work / "tmp" / "window.mp4")) as video:
        frames = sum(1 for _ in video.decode(video=0))
    assert frames == found["delivered"], (frames, found["delivered"])
    print(f"a cut while it played, locked tracks, sound; {frames} frames delivered without {found['range']}; conformed")


def long_day(desk: Desk) -> None:
    """The media are one small film, which all cameras play: what is tried is the desk."""
    folder = desk.work / "long"
    folder.mkdir(exist_ok=True)
    film = timeline.media(folder, LONG_DAY, "camera.mp4")
    before = timeline.long_day(film.name, SHOTS, LONG_DAY)
    edls.save(before, folder / "edl.json")
    found = at_the_window(desk, "long_day")
    after = edls.load(folder / "edl.json")
    assert len(after.overrides) == len(before.overrides) + 1, after.overrides
    print(f"{found['shots']} shots over {found['frames']} frames, built in {found['built in CPU s']} s of CPU, and cut")


def pictures(desk: Desk, target: Path) -> None:
    """As JPEG for the docs, small enough to be read over a slow line."""
    for path in sorted((desk.work / "pictures").glob("*.png")):
        to = target / f"blender-{path.stem}.jpg"
        desk.inside("convert", str(path), "-quality", "80", str(desk.work / "tmp" / to.name))
        shutil.move(desk.work / "tmp" / to.name, to)
        print(f"{to}: {to.stat().st_size // 1024} KB")


TASKS = dict(zip(STEPS, (install, make_desk, conform, render, serve, window, first, editing, long_day), strict=True))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tree", type=Path)
    parser.add_argument("work", type=Path)
    parser.add_argument("--project", type=Path)
    parser.add_argument("--pictures", type=Path)
    parser.add_argument("--mirror")
    parser.add_argument("--steps", default=",".join(STEPS))
    given = parser.parse_args()
    tree, work = given.tree.resolve(), given.work.resolve()
    work.mkdir(parents=True, exist_ok=True)
    chroot.make(tree, given.mirror or chroot.own_mirror())
    folders = [
        Bound(ROOT),
        Bound(Path(sysconfig.get_path("purelib"))),
        Bound(work, writable=True),
        Bound(Path("/"), DOOR),
        Bound(Path("/proc"), DOOR / "proc"),
        Bound(Path("/dev"), DOOR / "dev", writable=True),
        Bound(work, DOOR / work.relative_to("/"), writable=True),
    ]
    with chroot.bound(tree, folders):
        desk = Desk(tree, work)
        if not desk.edl.exists():
            if given.project is None:
                desk.mcsl("demo", str(desk.project))
            else:
                shutil.copytree(given.project, desk.project, ignore=shutil.ignore_patterns("*.cache", "*.conformed"))
        for step in given.steps.split(","):
            print(f"--- {step}", flush=True)
            TASKS[step](desk)
        if given.pictures is not None:
            pictures(desk, given.pictures.resolve())


if __name__ == "__main__":
    main()
