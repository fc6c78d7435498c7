"""Alignment and choice on pictures that nobody here made, whose geometry is known.

How far from the best single plane, and how much of the field the programme shows.

    python -m benchmarks.real_pictures [DATA]       prints what results/real_pictures.md has

DATA, ``../shared/data`` without, holds ``suturing`` with ``suturing_truth`` and ``four_cameras/board``; what is not
there is left out with a word. None of it belongs to the project.
"""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path

import numpy as np

from benchmarks.accuracy import table
from mcsl_core import edl
from mcsl_core.analysis.pipeline import analyse
from mcsl_core.analysis.settings import AnalysisSettings
from mcsl_core.hooks.registry import discover
from mcsl_core.progress import Silent
from mcsl_core.simulation.truth import fit_homography, rms_distance, transfer

DATA = Path(__file__).parents[2] / "shared" / "data"
UNTIED = ("four_cameras/board",)  # cameras around a room: no plane is common to them


def over_best_plane(made: edl.Edl, truth: Path) -> dict[str, float]:
    """Camera -> rms error over the field's true points as a multiple of the best single plane's; weak ones left out."""
    document = json.loads(truth.read_text("utf-8"))
    names = [camera.name for camera in made.cameras]
    reference = names.index(made.reference)
    ratios: dict[str, float] = {}
    for true in document["poses"]:
        points = np.array(true["points"], np.float64)  # (cameras, N, 2), full-size pixels
        solved = made.pose_at((true["first"] + true["last"]) // 2)
        for index, name in enumerate(names):
            if index == reference or name in solved.weak_cameras or name not in solved.homographies:
                continue
            best = transfer(fit_homography(points[index], points[reference]), points[index])
            ours = transfer(np.array(solved.homographies[name]), points[index])
            ratios[name] = rms_distance(ours, points[reference]) / rms_distance(best, points[reference])
    return ratios


def chosen(made: edl.Edl, truth: Path) -> tuple[float, float]:
    """What the programme shows of the field, and the best camera that never changes, over each frame's best camera."""
    seen = np.array(json.loads(truth.read_text("utf-8"))["visible"])[: made.frames]  # (frames, cameras)
    names = [camera.name for camera in made.cameras]
    shown = sum(seen[s.range.start : s.range.stop, names.index(s.camera)].sum() for s in made.shots)
    best = seen.max(axis=1).sum()
    return float(shown / best), float(seen.sum(axis=0).max() / best)


def analysed(folder: Path) -> edl.Edl:
    """The recording's EDL, by the defaults."""
    with tempfile.TemporaryDirectory() as out:
        return analyse(
            [folder],
            Path(out) / "edl.json",
            settings=AnalysisSettings(),
            plugins=discover(),
            progress=Silent(),
        )


def main() -> None:
    data = Path(sys.argv[1]) if len(sys.argv) > 1 else DATA
    if (data / "suturing").is_dir():
        made = analysed(data / "suturing")
        ratios = over_best_plane(made, data / "suturing_truth" / "truth.json")
        weak = made.poses[0].weak_cameras
        cameras = [camera.name for camera in made.cameras if camera.name != made.reference]
        row = ["suturing", *("weak" if name in weak else f"{ratios[name]:.2f}" for name in cameras)]
        print(table(["times the best plane's error", *cameras], [row]))
        programme, fixed = chosen(made, data / "suturing_truth" / "truth.json")
        heads = ["field, over the best camera's of each frame", "programme", "best fixed camera", "switches"]
        print("\n" + table(heads, [["suturing", f"{programme:.1%}", f"{fixed:.1%}", len(made.shots) - 1]]))
    else:
        print(f"suturing: not in {data}")
    for name in UNTIED:
        if not (data / name).is_dir():
            print(f"{name}: not in {data}")
            continue
        made = analysed(data / name)
        rows = [[weak.camera, weak.reason] for weak in made.poses[0].weak]
        print(f"\n{name}: {len(rows)} of {len(made.cameras) - 1} cameras are weak\n")
        print(table(["camera", "why"], rows))


if __name__ == "__main__":
    main()
