"""Families of scenes that real recordings have and the plain scene has not: alignment, field, selection, detectors.

    python -m benchmarks.families FOLDER [--tuning] [NAME[:SEED,...] ...]   makes, analyses, writes the page
    python -m benchmarks.families FOLDER --sheet [NAME[:SEED] ...]          contact sheets, a PNG a family, to look at

Every family has seeds to tune on and seeds for the final table alone. FOLDER keeps recordings and figures: what is
there is used. The page has the rows that FOLDER has figures of.
"""

from __future__ import annotations

import json
import platform
import sys
from collections.abc import Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from benchmarks.accuracy import RESULTS, alignment, table, visible_share
from mcsl_core import edl
from mcsl_core.analysis.cache import PLACED
from mcsl_core.analysis.pipeline import analyse
from mcsl_core.analysis.settings import AnalysisSettings
from mcsl_core.hooks.registry import discover
from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.progress import Silent
from mcsl_core.simulation import FAMILIES, Scenario, Truth, load_truth, simulate, true_field
from mcsl_core.simulation.clocks import clocks
from mcsl_core.simulation.ground import Ground
from mcsl_core.simulation.render import CameraPictures
from mcsl_core.simulation.scene import Scene

DETECTORS = ("consensus", "hue-area")
"""The default first: its programme is the one that is judged."""
TUNING, FINAL = tuple(range(501, 507)), tuple(range(660, 680))
"""Seeds; 601 to 659 were those of tables before, and were looked into."""
SHORT_POSES = ((5.0, 1.2), (11.0, 0.9), (17.5, 1.5))


@frozen
class Kind:
    """A row of the table.

    Attributes
    ----------
    families
        What its scenes have.
    settings
        What else of a `Scenario` is unlike the others'.
    """

    families: tuple[str, ...]
    settings: Mapping[str, Any] = field(factory=dict)

    def scenario(self, seed: int) -> Scenario:
        """The scene of that seed."""
        some: dict[str, Any] = {"duration_s": 24, "size": (640, 360), "rate": 10, "movements": 0, **self.settings}
        return Scenario(seed=seed, families=self.families, **some)


KINDS: Mapping[str, Kind] = {
    "plain": Kind(()),
    **{name: Kind((name,)) for name in FAMILIES},
    "suturing": Kind(("limb", "smooth-skin", "resting-hand", "red-straps", "glare", "defocus", "exposure")),
    "short-poses": Kind(("quick-heads",), {"movements": SHORT_POSES}),
    "hueless": Kind(("near-black-skin", "brown-drape", "monotone-drape")),
}


def measure(folder: Path, name: str, seed: int) -> dict[str, Any]:
    """Everything about one recording; kept as JSON beside it."""
    recording = folder / f"{name}-{seed}"
    kept = folder / f"{name}-{seed}.figures.json"
    if kept.exists():
        return json.loads(kept.read_text("utf-8"))
    if not (recording / "truth.json").exists():
        simulate(KINDS[name].scenario(seed), recording, Silent())
    truth = load_truth(recording)
    out = folder / f"{name}-{seed}.edl" / "edl.json"
    figures: dict[str, Any] = {"name": name, "seed": seed, "detectors": {}}
    for detector in DETECTORS:
        settings = AnalysisSettings(stages={"occlusion": detector})
        made = analyse([recording], out, settings=settings, plugins=discover(), progress=Silent())
        figures["detectors"][detector] = scored(out, truth) | {"programme": visible_share(made, truth)[0]}
        if detector == DETECTORS[0]:
            ratios, weak = alignment(made, truth)
            figures |= {"ratios": ratios, "weak": weak, "iou": field_iou(out, truth), **chosen(made, truth)}
    kept.write_text(json.dumps(figures, indent=1) + "\n", "utf-8")
    return figures


def chosen(made: edl.Edl, truth: Truth) -> dict[str, float]:
    """What the programme shows, over the best camera of each frame; the same of the best camera that never changes."""
    seen = truth.visible_field[: made.frames]
    best = seen.max(axis=1).sum()
    return {
        "visible": visible_share(made, truth)[0],
        "fixed": float(seen.sum(axis=0).max() / best),
        "switches_per_minute": 60 * (len(made.shots) - 1) / float(made.frames / made.rate),
    }


def field_iou(out: Path, truth: Truth) -> float:
    """Intersection over union of the field that the analysis went by and the true one, mean of the poses."""
    newest = max((out.parent / "edl.cache").glob("placed-*.npz"), key=lambda file: file.stat().st_mtime_ns)
    with np.load(newest) as arrays:
        solved = PLACED.unpack(dict(arrays))
    found = []
    for pose in solved:
        middle = (pose.pose.range.start + pose.pose.range.stop) // 2
        index = min(
            range(len(truth.poses)),
            key=lambda n: max(truth.poses[n].range[0] - middle, middle - truth.poses[n].range[1]),
        )
        true, said = true_field(truth, index, truth.reference, pose.aligned.size), pose.aligned.field
        found.append(float((true & said).sum() / max((true | said).sum(), 1)))
    return float(np.mean(found))


def scored(out: Path, truth: Truth) -> dict[str, float]:
    """Mean absolute error of the scores, and what the camera of the highest score shows over the best one, samples.

    Scores are held against the frame that a picture really belongs to, the camera of the highest score against the
    sample's.
    """
    with np.load(out.with_name("edl.scores.npz")) as arrays:
        scores = ScoreTable.from_arrays(dict(arrays))
    frames, shown = (np.clip(at, 0, truth.frames - 1) for at in (scores.frames, scores.shown))
    stands = np.array([any(p.range[0] <= f < p.range[1] for p in truth.poses) for f in frames])
    known = stands[:, None] & ~np.isnan(scores.visible)
    first = np.where(known, scores.seen_at(scores.frames), -1.0).argmax(axis=1)
    off = np.abs(scores.visible - np.take_along_axis(truth.visible_field, shown, axis=0))
    true, rows = truth.visible_field[frames], np.flatnonzero(stands)
    return {
        "error": float(off[known].mean()),
        "best": float(true[rows, first[rows]].sum() / true[rows].max(axis=1).sum()),
    }


# ------------------------------------------------------------------------------------------------------------ sheets


def sheet(name: str, seed: int, times_s: Sequence[float] = (1.0, 8.0, 18.0), every: int = 2) -> NDArray:
    """(H, W, 3) uint8, BGR: pictures of some cameras, a row a camera, at full size."""
    scenario = KINDS[name].scenario(seed)
    scene = Scene.of(scenario)
    ground = Ground.of(scenario, scene.surface, scene.rig)
    rows = []
    for camera in range(0, scenario.cameras, every):
        pictures = CameraPictures(scene, ground, camera, clocks(scenario)[camera])
        rows.append(np.hstack([planes_to_bgr(pictures.frame(int(t * scenario.rate))[0]) for t in times_s]))
    return np.vstack(rows)


# --------------------------------------------------------------------------------------------------------- the page


def markdown(found: Sequence[Mapping[str, Any]]) -> str:
    """The page: a row a family, over all its recordings."""
    rows, detectors = [], []
    for name in KINDS:
        group = [f for f in found if f["name"] == name]
        if not group:
            continue
        ratios = np.concatenate([f["ratios"] for f in group])
        rows.append(
            [
                name,
                ", ".join(str(f["seed"]) for f in group),
                f"{ratios.mean():.2f} / {ratios.max():.2f}" if len(ratios) else "none",
                sum(f["weak"] for f in group),
                _spread(group, "iou", "{:.2f}"),
                _spread(group, "visible", "{:.1%}"),
                _spread(group, "fixed", "{:.1%}"),
                f"{np.mean([f['switches_per_minute'] for f in group]):.1f}",
            ]
        )
        for key, form in (("error", "{:.3f}"), ("best", "{:.1%}"), ("programme", "{:.1%}")):
            means = [form.format(np.mean([f["detectors"][d][key] for f in group])) for d in DETECTORS]
            detectors.append([name, MEANING[key], *means])
    return "\n".join([*_head(), table(HEADS, rows), "", *_detectors_head(), table(["", "", *DETECTORS], detectors), ""])


HEADS = ["", "seeds", "alignment", "weak", "field IoU", "visible field", "best fixed camera", "switches a minute"]
MEANING = {"error": "score error", "best": "camera of the highest score", "programme": "programme"}


def _head() -> list[str]:
    return [
        "# Families of scenes",
        "",
        f"Made by `python -m benchmarks.families FOLDER` on {date.today().isoformat()}, {platform.machine()}, Python "
        f"{platform.python_version()}. 24 s, 640x360, 10 frames a second, five cameras; see `mcsl simulate --family`. "
        f"Seeds {TUNING[0]} to {TUNING[-1]} are for tuning, {FINAL[0]} to {FINAL[-1]} for this table; rows name those "
        "that were run. The plain scene's own tables, of ten minutes: [accuracy](accuracy.md), "
        "[detectors](detectors.md).",
        "",
        "Alignment: error over the best plane's, mean / worst camera (reach: 1.15 / 1.5); cameras named weak are not "
        "in it. Field: intersection over union with the true one, mean / worst (reach: 0.8). Visible field: of the "
        "chosen cameras over the best camera's in each frame, mean / worst recording (reach: 97 %), beside the best "
        "single camera's.",
        "",
    ]


def _detectors_head() -> list[str]:
    return [
        "## Detectors",
        "",
        "Score error: mean absolute difference from the true visible share, a sample a second while the lamp stands "
        "(reach: 0.05), at the frame that the sample's picture really belongs to. Then what the camera of the highest "
        "score shows in the samples, and what the programme of each detector shows in all frames, over the best "
        "camera's.",
        "",
    ]


def _spread(group: Sequence[Mapping[str, Any]], key: str, form: str) -> str:
    values = [f[key] for f in group]
    return f"{form.format(np.mean(values))} / {form.format(min(values))}"


def main() -> None:
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    flags = {a for a in sys.argv[2:] if a.startswith("--")}
    names = [a for a in sys.argv[2:] if a not in flags] or list(KINDS)
    cv2.setNumThreads(1)
    if "--sheet" in flags:
        for name in names:
            kind, _, few = name.partition(":")
            seed = int(few or TUNING[0])
            cv2.imwrite(str(folder / f"{kind}-{seed}.png"), sheet(kind, seed))
        return
    seeds = TUNING if "--tuning" in flags else FINAL
    for name in names:
        kind, _, few = name.partition(":")
        for seed in [int(s) for s in few.split(",")] if few else seeds:
            print(json.dumps(measure(folder, kind, seed)), flush=True)
    found = [json.loads(file.read_text("utf-8")) for file in sorted(folder.glob("*.figures.json"))]
    page = markdown([f for f in found if f["seed"] in seeds])
    if seeds == FINAL:
        RESULTS.mkdir(exist_ok=True)
        (RESULTS / "families.md").write_text(page, "utf-8")
    print(page)


if __name__ == "__main__":
    main()
