"""Colours of programmes from cameras whose exposure or white balance drifts: one match a pose against keys.

    python -m benchmarks.colour_drift FOLDER [--tuning] [NAME[:SEED,...] ...]    makes, analyses, writes the page

FOLDER keeps recordings and figures: what is there is used. Each programme is made twice by the compositor, without
centering and fill: with the one match a pose that the alignment found, and with the analysis's keys. Both are held
against the ideal programme (see `ideal_pictures`) of the same scene without any drift, over the surgical field.
"""

from __future__ import annotations

import json
import platform
import sys
from collections.abc import Mapping, Sequence
from datetime import date
from itertools import pairwise
from pathlib import Path
from typing import Any

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy import RESULTS, table
from benchmarks.families import KINDS, TUNING, Kind
from mcsl_core import edl
from mcsl_core.analysis.cache import POSES
from mcsl_core.analysis.pipeline import analyse
from mcsl_core.analysis.settings import AnalysisSettings
from mcsl_core.compositing.compositor import Compositor
from mcsl_core.hooks.registry import discover
from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import footage_of
from mcsl_core.simulation import Truth, load_truth, simulate, true_field
from mcsl_core.simulation.ground import Ground
from mcsl_core.simulation.ideal import ideal_pictures
from mcsl_core.simulation.scene import Scene
from mcsl_core.timing import FrameRange

FINAL = tuple(range(601, 607))
SCENES: Mapping[str, Kind] = {
    "plain": KINDS["plain"],
    "exposure": KINDS["exposure"],
    "white-balance": KINDS["white-balance"],
    "both": Kind(("exposure", "white-balance")),
}
ONE, KEYS = "one match", "keys"
UNCOVERED = 0.6  # of the field that the shown camera must see
NEAR = 24  # codes from the others' difference on a pixel shows something else: a head, or a hand seen from elsewhere


def variants(out: Path) -> dict[str, edl.Edl]:
    """The analysed programme, and the same with the one match a pose that the alignment found."""
    made = edl.load(out)
    newest = max((out.parent / "edl.cache").glob("poses-*.npz"), key=lambda file: file.stat().st_mtime_ns)
    with np.load(newest) as arrays:
        solved = POSES.unpack(dict(arrays))
    plain = tuple(
        attrs.evolve(pose, colour=own.pose.colour, colour_keys={}) for pose, own in zip(made.poses, solved, strict=True)
    )
    look = attrs.evolve(made.look, centering=False, fill=False, colour=True)
    return {ONE: attrs.evolve(made, poses=plain, look=look), KEYS: attrs.evolve(made, look=look)}


def measure(folder: Path, name: str, seed: int) -> dict[str, Any]:
    """Everything about one recording; kept as JSON beside it."""
    recording, kept = folder / f"{name}-{seed}", folder / f"{name}-{seed}.colours.json"
    if kept.exists():
        return json.loads(kept.read_text("utf-8"))
    if not (recording / "truth.json").exists():
        simulate(SCENES[name].scenario(seed), recording, Silent())
    out = folder / f"{name}-{seed}.edl" / "edl.json"
    made = analyse([recording], out, settings=AnalysisSettings(), plugins=discover(), progress=Silent())
    truth = load_truth(recording)
    figures: dict[str, Any] = {
        "name": name,
        "seed": seed,
        "counts": [len(k) for k in made.poses[0].colour_keys.values()],
    }
    for variant, programme in variants(out).items():
        figures[variant] = described(programme, differences(programme, out.parent, truth))
    kept.write_text(json.dumps(figures, indent=1) + "\n", "utf-8")
    return figures


def differences(programme: edl.Edl, folder: Path, truth: Truth) -> NDArray[np.float64]:
    """(frames, 3): programme less ideal over the field, codes of B, G, R; NaN where little of it is seen."""
    steady = attrs.evolve(truth.scenario, families=())
    scene, footage = Scene.of(steady), footage_of(programme, folder)
    ideal = ideal_pictures(scene, Ground.of(steady, scene.surface, scene.rig))
    field = true_field(truth, 0, truth.reference, programme.size)
    field = cv2.erode(field.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    found = np.full((programme.frames, 3), np.nan)
    with Compositor(programme, footage) as compositor:
        shown = compositor.frames(FrameRange(0, programme.frames))
        for frame, (planes, wanted) in enumerate(zip(shown, ideal, strict=True)):
            camera = next(shot.camera for shot in programme.shots if frame in shot.range)
            if truth.visible_field[min(frame, truth.frames - 1), truth.camera_index(camera)] < UNCOVERED:
                continue
            off = cv2.blur(planes_to_bgr(planes).astype(np.float32) - planes_to_bgr(wanted), (5, 5))[field]
            middle = np.median(off, axis=0)
            for _ in range(4):
                middle = np.median(off[(np.abs(off - middle) < NEAR).all(axis=1)], axis=0)
            found[frame] = middle
    return found


def described(programme: edl.Edl, off: NDArray[np.float64]) -> dict[str, float]:
    """Of one programme: how far it is from its own middle, how far that changes within a second, and at switches."""
    rate = round(float(programme.rate))
    apart = np.abs(off - np.nanmedian(off, axis=0)).mean(axis=1)
    in_shot = [off[shot.range.start : shot.range.stop] for shot in programme.shots]
    seconds = np.concatenate([np.abs(own[rate:] - own[:-rate]).mean(axis=1) for own in in_shot if len(own) > rate])
    cuts = [_jump(off, before.range.stop, rate // 2) for before, _ in pairwise(programme.shots)]
    cuts = [cut for cut in cuts if not np.isnan(cut)]
    return {
        "mean": float(np.nanmean(apart)),
        "p95": float(np.nanpercentile(apart, 95)),
        "second": float(np.nanmean(seconds)),
        "second_p95": float(np.nanpercentile(seconds, 95)),
        "switch": float(np.mean(cuts)) if cuts else float("nan"),
        "switches": len(cuts),
    }


def _jump(off: NDArray[np.float64], cut: int, reach: int) -> float:
    """Between the last frames before a switch and the first behind it in which enough is seen."""
    before, behind = off[max(0, cut - reach) : cut], off[cut : cut + reach]
    before, behind = (part[~np.isnan(part[:, 0])] for part in (before, behind))
    return float(np.abs(behind[0] - before[-1]).mean()) if len(before) and len(behind) else float("nan")


def markdown(found: Sequence[Mapping[str, Any]]) -> str:
    """The page: a row a family and variant, over all its recordings."""
    rows = []
    for name in SCENES:
        group = [f for f in found if f["name"] == name]
        if not group:
            continue
        seeds = ", ".join(str(f["seed"]) for f in group)
        keys = [count for f in group for count in f["counts"]]
        for variant in (ONE, KEYS):
            own = [f[variant] for f in group]
            cuts = [f["switch"] for f in own for _ in range(f["switches"])]
            rows.append(
                [
                    name,
                    seeds,
                    variant if variant == ONE else f"keys ({np.mean(keys):.0f} a camera)" if keys else "keys (none)",
                    *(f"{np.mean([f[key] for f in own]):.1f}" for key in ("mean", "p95", "second", "second_p95")),
                    f"{np.mean(cuts):.1f} ({len(cuts)})" if cuts else "no switch",
                ]
            )
    return "\n".join([*_head(), table(HEADS, rows), ""])


HEADS = ["", "seeds", "colours", "off", "off, 95 %", "in a second", "in a second, 95 %", "at a switch"]


def _head() -> list[str]:
    return [
        "# Colours that drift",
        "",
        f"Made by `python -m benchmarks.colour_drift FOLDER` on {date.today().isoformat()}, {platform.machine()}, "
        f"Python {platform.python_version()}. 24 s, 640x360, 10 frames a second, five cameras; see "
        f"`mcsl simulate --family`. Seeds {TUNING[0]} to {TUNING[-1]} are for tuning, {FINAL[0]} to {FINAL[-1]} for "
        "this table; rows name those that were run.",
        "",
        "8-bit codes, mean of R', G' and B', of the programme against the ideal one of the same scene in steady light: "
        "median over the surgical field. **Off**: from the programme's own middle over time. "
        "**In a second**: by how much that changes from a frame to the one a second later, within a shot: what a "
        "viewer sees as pumping. **At a switch**: from the frame before to the one behind (how many).",
        "",
    ]


def main() -> None:
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    seeds = TUNING if "--tuning" in sys.argv else FINAL
    names = [a for a in sys.argv[2:] if not a.startswith("--")] or list(SCENES)
    cv2.setNumThreads(1)
    chosen = [
        (int(seed), scene)
        for scene, _, few in (name.partition(":") for name in names)
        for seed in (few.split(",") if few else seeds)
    ]
    for seed, scene in sorted(chosen, key=lambda one: one[0]):
        print(json.dumps(measure(folder, scene, seed)), flush=True)
    found = [json.loads(file.read_text("utf-8")) for file in sorted(folder.glob("*.colours.json"))]
    page = markdown([f for f in found if f["seed"] in seeds])
    if seeds == FINAL:
        (RESULTS / "colour_drift.md").write_text(page, "utf-8")
    print(page)


if __name__ == "__main__":
    main()
