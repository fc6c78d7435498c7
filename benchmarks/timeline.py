"""What a timeline costs: 430 shots as of an operation and 2,000 as of a long day, 5 cameras, 5,000 centering keys.

    python -m benchmarks.timeline FOLDER [BLENDER]       writes results/timeline.md

Building, reading back and cutting by key are timed inside one Blender process, in seconds of its CPU, against what
Blender itself takes for as many bare Multicam strips: the yardstick of every ratio. Best of three, since a machine has
other things to do.
The media are real: one file of 120,000 small pictures (64x36), which all five cameras play.
"""

from __future__ import annotations

import json
import os
import platform
import random
import subprocess
import sys
import tempfile
from datetime import date
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import numpy as np

from mcsl_core.blender.child import search_paths
from mcsl_core.blender.installation import find
from mcsl_core.edl import IDENTITY, Camera, Edl, Matrix, Media, Movement, MovementView, Override, Pose, Shot, save
from mcsl_core.edl.placement import multiply
from mcsl_core.media.writing import Encoding, VideoWriter
from mcsl_core.timing import FrameRange

RESULTS = Path(__file__).parent / "results"
FRAMES, CAMERAS, MOVEMENTS, KEYS = 120_000, 5, 20, 5_000
SHOTS, OVERRIDDEN = (430, 2_000), 10  # one timeline each; every tenth shot is overridden
CUTS, EXACT = 15, 3_000  # cuts by key in each round, and frames of each conformed file
MOVES, VIEW_EVERY = 150, 2  # frames of a movement, and between its views
RATE, SIZE = Fraction(30), (64, 36)
REACH = {"build": 10.0, "read": 1.0, "cut": 0.1}  # seconds

INSIDE = """
import json, os, random, statistics, sys, time
request = json.load(open(sys.argv[-1]))
sys.path.extend(request["paths"])
import bpy
import blender_addon
from pathlib import Path
from mcsl_core.edl import load
from mcsl_core.edl.resolve import resolve
from mcsl_core.blender.messages import ConformedPiece
from mcsl_core.timing import FrameRange
from blender_addon.core.multicam import overridden
from blender_addon.core.read_overrides import read_edl
from blender_addon.core.strip_plan import make_plan
from blender_addon.sequencer.build import build_timeline
from blender_addon.sequencer.compat import ends, new_effect, use_sequencer_scene
from blender_addon.sequencer import conformed, scene_properties
from blender_addon.sequencer.read import read_timeline
from blender_addon.ui import refresh

def timed(work):
    wall, cpu = time.perf_counter(), time.process_time()
    result = work()
    return result, time.process_time() - cpu, time.perf_counter() - wall

def fresh():
    bpy.ops.wm.read_homefile(app_template="Video_Editing", use_factory_startup=True)
    scene = bpy.context.scene
    use_sequencer_scene(scene)
    return scene

def bare():
    scene = fresh()
    scene.sequence_editor_create()
    def make():
        for n, (start, stop) in enumerate(request["shots"]):
            new_effect(scene, f"shot {n}", "MULTICAM", 7, start, stop)
    _, *make_s = timed(make)
    def inspect():
        return [(*ends(s), s.channel, s.multicam_source) for s in scene.sequence_editor.strips]
    _, *inspect_s = timed(inspect)
    return make_s, inspect_s

def cuts(scene, chance):
    # each with what follows 0.4 s later in a window: there the timeline is read again
    found = []
    while len(found) < request["cuts"]:
        scene.frame_set(chance.randrange(1, scene.frame_end))
        press = lambda: bpy.ops.mcsl.switch_camera("EXEC_DEFAULT", True, number=chance.randint(1, 5))
        done, *press_s = timed(press)
        if done == {"FINISHED"}:
            _, *quiet_s = timed(refresh.refresh_changed)
            found.append((press_s, quiet_s))
    return [[statistics.median(times) for times in zip(*part)] for part in zip(*found)]

def exact(scene, edl):
    n = request["exact"]
    starts = range(0, edl.frames - n + 1, n)
    pieces = [ConformedPiece(range=FrameRange(a, a + n), path=f"{a:07d}-exact.mp4") for a in starts]
    for _ in conformed.insert(scene, edl, pieces, None, path.parent): pass

path = Path(request["edl"])
rounds = []
blender_addon.register()
chance = random.Random(3)
for _ in range(request["rounds"]):
    make_s, inspect_s = bare()
    scene = fresh()
    edl, *load_s = timed(lambda: load(path))
    plan, *plan_s = timed(lambda: make_plan(edl))
    _, *strips_s = timed(lambda: build_timeline(scene, plan, path.parent))
    state, *found_s = timed(lambda: read_timeline(scene))
    new, *read_s = timed(lambda: read_edl(edl, state))
    assert new == edl, "an untouched timeline must decide nothing"
    _, *colour_s = timed(lambda: overridden(resolve(new), state.strips))
    strips = len(scene.sequence_editor.strips)
    scene_properties.set_ids(scene, edl, path, path.parent)
    bpy.ops.wm.save_as_mainfile(filepath=str(path.with_suffix(".blend")))
    refresh.refresh_timeline(scene)
    press_s, quiet_s = cuts(scene, chance)
    exact(scene, edl)
    refresh.refresh_timeline(scene)
    exact_press_s, exact_quiet_s = cuts(scene, chance)
    rounds.append({"bare": make_s, "inspect": inspect_s, "load": load_s, "plan": plan_s, "strips": strips_s,
                   "found": found_s, "decide": read_s, "colour": colour_s, "press": press_s, "quiet": quiet_s,
                   "exact_press": exact_press_s, "exact_quiet": exact_quiet_s})
json.dump({"version": bpy.app.version_string, "rounds": rounds, "strips": strips},
          open(request["answer"], "w"))
sys.stdout.flush()
os._exit(0)
"""


def media(folder: Path, frames: int, name: str) -> Path:
    """A film of that many pictures, made when it is not there yet."""
    path = folder / name
    if not path.exists():
        part = folder / f"part-{name}"
        encoding = Encoding(options={"preset": "ultrafast", "crf": "40"})
        picture = np.full((SIZE[1], SIZE[0], 3), 90, np.uint8)
        with VideoWriter(part, size=SIZE, rate=RATE, encoding=encoding, keyframe_interval=250) as writer:
            for _ in range(frames):
                writer.write(picture)
        part.rename(path)
    return path


def long_day(name: str, count: int, frames: int = FRAMES) -> Edl:
    """``count`` shots: cuts, keys and overrides at random places, the same in every run."""
    chance = random.Random(1)
    cuts = [0, *sorted(chance.sample(range(1, frames), count - 1)), frames]
    cameras = [f"cam{n}" for n in range(1, CAMERAS + 1)]
    shots = tuple(
        Shot(FrameRange(a, b), cameras[i % CAMERAS], 0.9, "sees most of the field")
        for i, (a, b) in enumerate(zip(cuts, cuts[1:], strict=False))
    )
    turned = ((0.31, -0.95, 40.0), (0.95, 0.31, -12.0), (1e-4, -2e-4, 1.0))
    homographies = {c: IDENTITY if c == "cam1" else turned for c in cameras}
    begins = [n * frames // (MOVEMENTS + 1) for n in range(MOVEMENTS + 2)]
    return Edl(
        rate=RATE,
        size=SIZE,
        frames=frames,
        reference="cam1",
        cameras=tuple(Camera(c, (Media(name, frames),), SIZE, RATE) for c in cameras),
        movements=tuple(_movement(FrameRange(n - MOVES // 2, n + MOVES // 2), homographies) for n in begins[1:-1]),
        poses=tuple(Pose(FrameRange(a, b), homographies) for a, b in pairwise(begins)),
        shots=shots,
        overrides=tuple(
            Override(shot.range, camera=cameras[(i + 2) % CAMERAS])
            for i, shot in enumerate(shots)
            if i % OVERRIDDEN == 5
        ),
        centering=tuple(
            (i * frames // KEYS, chance.randint(-90, 90) / 10, chance.randint(-90, 90) / 10) for i in range(KEYS)
        ),
    )


def _movement(moves: FrameRange, homographies: dict[str, Matrix]) -> Movement:
    """All cameras drift off and come back."""
    views = []
    for frame in range(moves.start - 2, moves.stop + 3, VIEW_EVERY):
        away = min(frame - moves.start, moves.stop - frame) / 10
        off = (1.0, 0.0, away), (0.0, 1.0, -away), (0.0, 0.0, 1.0)
        views.append(MovementView(frame, {c: multiply(off, matrix) for c, matrix in homographies.items()}))
    return Movement(moves, 1.0, tuple(views))


def run(command: list[str], folder: Path, edl: Edl, rounds: int) -> dict:
    """The times of each round, as the Blender inside took them."""
    path = folder / "edl.json"
    save(edl, path)
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        order, answer, script = work / "order.json", work / "answer.json", work / "inside.py"
        script.write_text(INSIDE, encoding="utf-8")
        request = {"edl": str(path), "paths": search_paths(), "rounds": rounds, "answer": str(answer)}
        request |= {"cuts": CUTS, "exact": EXACT}
        order.write_text(json.dumps({**request, "shots": [[s.range.start, s.range.stop] for s in edl.shots]}))
        environment = {**os.environ, "BLENDER_USER_RESOURCES": str(Path(name) / "user")}
        subprocess.run(
            [*command, str(script), "--", str(order)], check=True, stdout=subprocess.DEVNULL, env=environment
        )
        return json.loads(answer.read_text())


def table(found: dict, count: int) -> str:
    """Seconds of CPU (and of the clock), the best round, and the ratio to the yardstick."""
    best = {part: min((r[part] for r in found["rounds"]), key=lambda times: times[0]) for part in found["rounds"][0]}
    summed = {
        "build": [sum(best[p][i] for p in ("load", "plan", "strips")) for i in (0, 1)],
        "read": [sum(best[p][i] for p in ("load", "found", "decide")) for i in (0, 1)],
        "cut": [best["press"][i] + best["quiet"][i] for i in (0, 1)],
        "exact": [best["exact_press"][i] + best["exact_quiet"][i] for i in (0, 1)],
    }
    rows = [
        ("**build**: EDL read, planned, strips made", summed["build"], "bare", f"{REACH['build']:g} s"),
        ("  of it: reading and checking the EDL", best["load"], "bare", ""),
        ("  of it: planning", best["plan"], "bare", ""),
        ("  of it: strips, keys, five movies split and keyed at movements", best["strips"], "bare", ""),
        (f"yardstick: {count:,} bare Multicam strips", best["bare"], "bare", ""),
        ("**read back**: EDL read, strips found, decided", summed["read"], "inspect", f"{REACH['read']:g} s"),
        ("  of it: finding strips and transforms", best["found"], "inspect", ""),
        ("  of it: what was decided", best["decide"], "inspect", ""),
        ("colours of the overrides, after a change", best["colour"], "inspect", ""),
        ("**a cut by key**: what the key does and what follows it", summed["cut"], "inspect", f"{REACH['cut']:g} s"),
        ("  of it: the key, until the picture stands", best["press"], "inspect", ""),
        ("  of it: read again when it is quiet", best["quiet"], "inspect", ""),
        ("**a cut by key, exact pictures in place**", summed["exact"], "inspect", f"{REACH['cut']:g} s"),
        ("  of it: the key", best["exact_press"], "inspect", ""),
        ("yardstick: ends, channel and source of each strip", best["inspect"], "inspect", ""),
    ]
    lines = ["| what | CPU s | clock s | times the yardstick | to reach |", "|---|---|---|---|---|"]
    for name, (cpu, clock), yardstick, reach in rows:
        lines.append(f"| {name} | {cpu:.3f} | {clock:.3f} | {cpu / best[yardstick][0]:.2f} | {reach} |")
    return "\n".join(lines)


def main() -> None:
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    desk = find(sys.argv[2] if len(sys.argv) > 2 else None)
    if desk.kind != "module":
        raise SystemExit("name a Python with bpy: a Blender binary takes its script another way")
    film, exact = media(folder, FRAMES, "camera.mp4"), media(folder, EXACT, "exact.mp4")
    for start in range(0, FRAMES, EXACT):
        if not (link := folder / f"{start:07d}-exact.mp4").exists():
            os.link(exact, link)
    found = {count: run([*desk.command], folder, long_day(film.name, count), rounds=3) for count in SHOTS}
    parts = []
    for count, made in found.items():
        stand = f"{count // OVERRIDDEN:,} overrides; {made['strips']:,} strips stand in the sequencer."
        parts.append(f"## {count:,} shots\n\n{stand}\n\n{table(made, count)}")
    text = f"""# The timeline of an operation and of a long day

Made by `python -m benchmarks.timeline FOLDER` on {date.today()}, Blender {found[SHOTS[0]]["version"]} as a module,
{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}. Best of three rounds in one process;
of cuts by key the median of {CUTS} in a round.

{CAMERAS} cameras, {MOVEMENTS} movements followed through {MOVES} frames each, {KEYS:,} centering keys,
{FRAMES:,} frames.
Untouched, a timeline gives back the same EDL: each round checks. Exact pictures: {FRAMES // EXACT} conformed files over
everything.

{(chr(10) * 2).join(parts)}
"""
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / "timeline.md").write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
