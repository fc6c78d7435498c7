"""How well the relief lays the cameras' pictures over each other: against planes and other warps, and at what cost.

    python -m benchmarks.relief FOLDER [--tuning] [--again] [NAME ...]   makes what is missing, writes results/relief.md

NAME is a seed of the plain scene, such as 701, a family with its seed, such as limb:616 (see ideal.py), or real
material: suturing, planar, board (``../shared/data``, which is no part of the project). FOLDER keeps recordings,
analyses and figures, and shares recordings and analyses with those that `benchmarks.ideal` and `benchmarks.families`
leave in it: what is there is used; --again measures anew, by the analysis that is there. The page has the rows that
FOLDER has figures of; seeds to tune on are kept out of it, and with --tuning the others.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from attrs import frozen

from benchmarks import ideal
from benchmarks.accuracy import by_hand, by_truth
from benchmarks.ideal_geometry import SHIFT_WIDTH, Map, Points, drilled, inverse, spread, to_programme, views
from benchmarks.real_pictures import DATA
from benchmarks.relief_baselines import SeenPose, baseline, moving_dlt, seen_poses, thin_plate
from benchmarks.relief_page import markdown
from benchmarks.relief_stills import board_views, planar_recording, planar_views, suturing_views
from mcsl_core import edl
from mcsl_core.alignment.relief.cameras import solve_cameras, tracks_of
from mcsl_core.alignment.relief.estimation import estimate_relief
from mcsl_core.alignment.relief.pose_relief import PoseRelief
from mcsl_core.alignment.relief.sweep import PlaneSweep
from mcsl_core.analysis.pipeline import analyse
from mcsl_core.analysis.settings import AnalysisSettings
from mcsl_core.compositing.parallax import Parallax
from mcsl_core.compositing.placement import programme_matrix
from mcsl_core.edl.placement import first_of_perspective, placement_matrix
from mcsl_core.evaluation.evaluate import Variant, evaluate, standard_variants
from mcsl_core.evaluation.manual_alignment import aligned_by_hand
from mcsl_core.hooks.registry import discover
from mcsl_core.imaging.relief import Placement
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.simulation import Truth, load_truth, simulate
from mcsl_core.simulation.truth import fit_homography, transfer

RESULTS = Path(__file__).parent / "results"
PLAIN = tuple(str(seed) for seed in ideal.FINAL)
FAMILIES = ("limb:663", "suturing:669", "resting-hand:661", "near-black-skin:666", "brown-drape:665", "short-poses:670")
REAL = ("suturing", "planar", "board")
TUNING = ("702", "703", "705", "706", "limb:501", "suturing:503")
ADJUSTMENTS = 2  # of the cameras in an analysis: laid by the plane, then by the relief


@frozen(eq=False)
class Recorded:
    """A recording with its analysis, and what is known about it.

    Attributes
    ----------
    name, scene : str
        Which, and what it shows.
    edl : Edl
        The analysis.
    base : Path
        The folder that its media are relative to.
    views : sequence of (int, str, (N, 2) array, (N, 2) array)
        Pose, camera, points in its picture, where they belong in the programme.
    truth : Truth or None
        Of a simulated one.
    """

    name: str
    scene: str
    edl: edl.Edl
    base: Path
    views: Sequence[tuple[int, str, Points, Points]]
    truth: Truth | None = None


def measure(folder: Path, name: str, *, again: bool = False) -> dict[str, Any]:
    """Everything about one recording; kept as JSON beside it."""
    kept = folder / f"{word(name)}.relief.json"
    if kept.exists() and not again:
        return json.loads(kept.read_text("utf-8"))
    own = recorded(folder, name)
    with closing(samples_of(own)) as samples:
        poses = seen_poses(own.edl, samples)
        ways = laid(own, poses)
        figures = {"name": name, "scene": own.scene, **off(own, ways), "cost": cost(own.edl, poses)}
    if own.truth is not None:
        figures["steadiness"] = steadiness(own.edl, own.base, own.truth)
    kept.write_text(json.dumps(figures, indent=1) + "\n", "utf-8")
    return figures


# ----------------------------------------------------------------------------------------------------- the recordings


def word(name: str) -> str:
    """What a recording's files are called in FOLDER."""
    return name.replace(":", "-")


def recorded(folder: Path, name: str) -> Recorded:
    """The recording of that name with its analysis; both made where they are not there."""
    if name in REAL:
        return _real(folder, name)
    source = folder / word(name)
    if not (source / "truth.json").exists():
        simulate(ideal.scenario(name), source, Silent(), ideal=":" not in name)  # as benchmarks.ideal wants it
    truth, out = load_truth(source), folder / f"{word(name)}.edl" / "edl.json"
    made = _analysed(source, out)
    return Recorded(name, ideal.scene_of(truth), made, out.parent, list(views(made, truth)), truth)


def _real(folder: Path, name: str) -> Recorded:
    out = folder / f"real-{name}.edl" / "edl.json"
    if name == "planar":
        made = _analysed(planar_recording(DATA / "planar", folder / "real-planar"), out, sync="none")
        return Recorded(name, "two photographs of a wall", made, out.parent, planar_views(DATA / "planar", made))
    if name == "board":
        made = _analysed(DATA / "four_cameras" / "board", out)
        return Recorded(name, "cameras around a room", made, out.parent, board_views(DATA / "four_cameras", made))
    made = _analysed(DATA / "suturing", out)
    truth = DATA / "suturing_truth" / "truth.json"
    return Recorded(name, "photograph over an exact relief", made, out.parent, suturing_views(truth, made))


def _analysed(source: Path, out: Path, *, sync: str = "auto") -> edl.Edl:
    if out.exists():
        return edl.load(out)
    return analyse([source], out, settings=AnalysisSettings(sync=sync), plugins=discover(), progress=Silent())


def samples_of(own: Recorded) -> SampleStore:
    """What the analysis sampled; sampled again where its cache is gone."""
    for store in sorted((own.base / "edl.cache").glob("samples-*")):
        found = None if store.suffix == ".json" else SampleStore.load(store)
        if found is not None:
            return found
    footage = Footage(own.edl.cameras, rate=own.edl.rate, frames=own.edl.frames, base=own.base)
    return SampleStore.record(footage, own.base / "relief.cache" / "samples", Silent())


# ----------------------------------------------------------------------------------------------------------- the ways


def laid(own: Recorded, poses: Sequence[SeenPose | None]) -> dict[str, Callable[[int, str], Map]]:
    """By way: the map from a camera's pixels to the programme's before centering, of a pose and camera.

    A view that a way has nothing for is laid by its plane.
    """
    made = own.edl
    footage = Footage(made.cameras, rate=made.rate, frames=made.frames, base=own.base)
    parallax = Parallax(made, footage)

    def plane(index: int, camera: str) -> Map:
        return to_programme(made, made.poses[index], camera, surface=False)

    def flow(index: int, camera: str) -> Map:
        matrix = programme_matrix(made, made.poses[index], camera)
        back = Placement(matrix, parallax.of(index, camera)).to_camera
        return lambda points: inverse(back, points, transfer(matrix, points))

    def of(fit: Callable[[Points, Points], Map]) -> Callable[[int, str], Map]:
        found = baseline(made, poses, fit)
        return lambda index, camera: found.get((index, camera)) or plane(index, camera)

    return {
        "plane": plane,
        "APAP": of(moving_dlt),
        "spline": of(thin_plate),
        "flow": flow,
        "surface": lambda index, camera: to_programme(made, made.poses[index], camera, surface=True),
    }


def off(own: Recorded, ways: Mapping[str, Callable[[int, str], Map]]) -> dict[str, Any]:
    """How far points lie from their place: by view and way, and over all views."""
    scale = SHIFT_WIDTH / own.edl.size[0]
    rows, every = [], {name: [] for name in (*ways, "best plane")}
    for index, camera, seen, home in own.views:
        places = {name: way(index, camera)(seen) for name, way in ways.items()}
        places["best plane"] = transfer(fit_homography(seen, home), seen)
        lengths = {name: scale * np.hypot(*(at - home).T) for name, at in places.items()}
        for name, values in lengths.items():
            every[name].append(values)
        moved = scale * np.hypot(*(places["surface"] - places["plane"]).T)
        figures = {name: spread(values) for name, values in lengths.items()}
        rows.append({"pose": index, "camera": camera, **figures, "moved": spread(moved)})
    pooled = {name: spread(np.concatenate(values)) for name, values in every.items() if values}
    reliefs = [len(pose.relief.projections) if pose.relief else 0 for pose in own.edl.poses]
    return {"views": rows, "pooled": pooled, "reliefs": reliefs, "cameras": len(own.edl.cameras)}


# ----------------------------------------------------------------------------------------------------------- the cost


def cost(made: edl.Edl, poses: Sequence[SeenPose | None]) -> dict[str, Any]:
    """CPU seconds a pose that the relief takes once its matches are found, and those of the yardstick."""
    seconds, found = [], {}
    for index, pose in enumerate(poses):
        if pose is None or pose.cameras is None:
            continue
        tracks = tracks_of(pose.matches, list(pose.cameras.projections))
        start = {name: np.array(h) for name, h in made.poses[index].homographies.items()}
        adjusted = _cpu(lambda t=tracks, h=start, s=pose.views.sizes: solve_cameras(t, h, s))[0]
        planes = {
            name: np.array(matrix)
            for name in pose.cameras.projections
            if (matrix := placement_matrix(made, made.poses[index], name)) is not None
        }
        before: PoseRelief | None = found.get(first_of_perspective(made, index))
        estimated, relief = _cpu(
            lambda p=pose, h=planes, b=before: p.cameras and estimate_relief(PlaneSweep(), p.cameras, p.views, h, b)
        )
        found[index] = relief
        seconds.append(round(ADJUSTMENTS * adjusted + estimated, 2))
    return {"seconds": seconds, "yardstick": round(yardstick(), 3)}


def yardstick() -> float:
    """CPU seconds of OpenCV's semi-global matching (StereoSGBM, eight paths, 128 levels) of two pictures of 960x540."""
    rng = np.random.default_rng(1)
    small = rng.integers(0, 255, (68, 120), np.uint8)
    left = cv2.resize(small, (960, 540), interpolation=cv2.INTER_CUBIC)
    right = np.roll(left, -20, axis=1)
    matcher = cv2.StereoSGBM.create(0, 128, 5, 200, 800, mode=cv2.STEREO_SGBM_MODE_HH)
    return min(_cpu(lambda: matcher.compute(left, right))[0] for _ in range(3))


def _cpu(work: Callable[[], Any]) -> tuple[float, Any]:
    began = time.process_time()
    made = work()
    return time.process_time() - began, made


# ------------------------------------------------------------------------------------------------------ the evaluation


def steadiness(made: edl.Edl, base: Path, truth: Truth) -> dict[str, Any]:
    """ITF in dB and AvSpeed in pixels at switches, about the field and over the whole picture, by variant.

    In the cut that goes to the next camera every little while (`drilled`): the analysis's own has a switch or none.
    """
    cut = drilled(made, truth)
    chosen = standard_variants(cut, manual=by_hand(cut, truth, truth.scenario.seed))
    own = [v for v in chosen if v.name in ("no", "manual", "plane", "surface")]
    own.append(Variant("best plane", "Best plane", aligned_by_hand(cut, by_truth(cut, truth)), own[0].look))
    done = evaluate(cut, base, own, width=640, every=0)
    rows = {
        m.name: [m.switches.itf_field_db, m.switches.av_speed_field_px, m.switches.itf_db, m.switches.av_speed_px]
        for m in done.measured
    }
    return {"switches": len(done.switches), "rows": rows}


# ------------------------------------------------------------------------------------------------------------ the run


def main(arguments: Sequence[str]) -> None:
    folder = Path(arguments[0])
    folder.mkdir(parents=True, exist_ok=True)
    flags = {a for a in arguments[1:] if a.startswith("--")}
    tuning = "--tuning" in flags
    names = [a for a in arguments[1:] if a not in flags] or [*(TUNING if tuning else (*PLAIN, *FAMILIES)), *REAL]
    cv2.setNumThreads(1)
    for name in names:
        print(json.dumps(measure(folder, name, again="--again" in flags)["pooled"]), flush=True)
    found = [json.loads(file.read_text("utf-8")) for file in sorted(folder.glob("*.relief.json"))]
    page = markdown([f for f in found if f["name"] in REAL or ideal.is_tuning(f) == tuning])
    if not tuning:
        (RESULTS / "relief.md").write_text(page, "utf-8")
    print(page)


if __name__ == "__main__":
    main(sys.argv[1:])
