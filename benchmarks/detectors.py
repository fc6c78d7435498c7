"""Occlusion detectors side by side, on simulated recordings whose truth is known and whose seeds nothing was tuned on.

    python -m benchmarks.detectors FOLDER [NAME ...]      makes what is missing, judges, writes results/detectors.md

Every detector is handed the same pictures of the same poses, with the true clocks and movements, so that nothing but
the detectors differs. `learned` and the small network for `onnx` are trained on frames of other operations, painted by
the simulator's truth as somebody would paint them. FOLDER keeps recordings, poses and models: what is there is used.
"""

from __future__ import annotations

import json
import os
import platform
import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import closing
from datetime import date
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from attrs import frozen
from mcsl_learned_occlusion.labelling import painting, read_marked, read_png, save_png, write_frames
from mcsl_learned_occlusion.training import train
from numpy.typing import NDArray

from benchmarks.accuracy import table
from benchmarks.painter import Painter
from benchmarks.small_network import write_network
from mcsl_core.alignment.observations import SolvedPose
from mcsl_core.alignment.pose_solver import PoseSolver
from mcsl_core.alignment.recorded_poses import pose_ranges
from mcsl_core.alignment.settings import SolveSettings
from mcsl_core.analysis.cache import POSES
from mcsl_core.edl import Clock, Movement
from mcsl_core.hooks.registry import Offer, Plugins, discover
from mcsl_core.occlusion.scoring import ScoringSegment, scoring_segments
from mcsl_core.progress import Silent
from mcsl_core.recording.cameras import open_cameras
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.keyframe_sampling import sample_cameras
from mcsl_core.recording.sample_store import SAMPLE_HEIGHT, SampleStore
from mcsl_core.simulation import Scenario, Truth, load_truth, simulate
from mcsl_core.timing import FrameRange

installed = cache(discover)
RESULTS = Path(__file__).parent / "results"
DETECTORS = ("hue-area", "consensus", "onnx", "learned")
FRAMES = 6  # painted in each recording to train on


def _scenario(seed: int, drape: str, skin: str, gloves: str, **other: Any) -> Scenario:
    some: dict[str, Any] = {"duration_s": 90, "movements": 0} | other
    return Scenario(
        seed=seed, size=(640, 360), rate=8, drape=drape, skin=skin, gloves=gloves, audio=False, **some
    )  # fmt: skip


TRAINED_ON = {
    "310": _scenario(310, "green", "light", "white", duration_s=60),
    "311": _scenario(311, "blue", "dark", "blue", duration_s=60),
    "312": _scenario(312, "white", "medium", "skin", duration_s=60),
    "313": _scenario(313, "skin", "light", "white", duration_s=60),
    "314": _scenario(314, "skin", "medium", "skin", duration_s=60),
    "315": _scenario(315, "skin", "dark", "green", duration_s=60),
}
TUNED_ON = {
    "330": _scenario(330, "skin", "medium", "blue", movements=1),
    "331": _scenario(331, "green", "medium", "skin"),
}
JUDGED = {
    "350": _scenario(350, "skin", "light", "skin"),
    "351": _scenario(351, "skin", "medium", "white", movements=1),
    "352": _scenario(352, "skin", "dark", "blue"),
    "353": _scenario(353, "green", "light", "skin"),
    "354": _scenario(354, "blue", "medium", "white", movements=1, heads=4),
}
ALL = TRAINED_ON | TUNED_ON | JUDGED


@frozen(eq=False)
class Prepared:
    """A recording as detectors get it.

    Attributes
    ----------
    truth : Truth
        What the simulator knows.
    samples : SampleStore
        About one a second.
    solved : sequence of SolvedPose
        By mcsl's own alignment.
    movements : tuple of Movement
        The true ones.
    at : (samples, cameras) int64
        The programme frame that each picture really belongs to.
    """

    truth: Truth
    samples: SampleStore
    solved: Sequence[SolvedPose]
    movements: tuple[Movement, ...]
    at: NDArray[np.int64]

    def segments(self, detector: Offer) -> tuple[ScoringSegment, ...]:
        """The segments that a detector scores."""
        return scoring_segments(self.samples, self.solved, self.movements, detector.checked)

    def seen(self) -> NDArray[np.float64]:
        """(samples, cameras): the true visible share in each picture."""
        at = np.clip(self.at, 0, len(self.truth.visible_field) - 1)
        return np.take_along_axis(self.truth.visible_field, at, axis=0)


def prepare(folder: Path, name: str) -> Prepared:
    """A recording, its samples and its poses by mcsl's own alignment, all kept in ``folder``."""
    recording, store = folder / name, folder / f"{name}.samples"
    if not (recording / "truth.json").exists():
        simulate(ALL[name], recording, Silent())
    truth = load_truth(recording)
    cameras = [
        c.__class__(c.name, c.media, c.size, c.rate, Clock(t.offset_s, t.drift_ppm))
        for c, t in zip(open_cameras([recording], folder, Silent()), truth.clocks, strict=True)
    ]
    footage = Footage(cameras, rate=truth.rate, frames=truth.frames, base=folder)
    movements = tuple(Movement(FrameRange(*m)) for m in truth.movements)
    samples = SampleStore.load(store) or SampleStore.record(footage, store, Silent())
    kept = folder / f"{name}.poses.npz"
    if not kept.exists():
        solved = [_solved(piece, samples, movements, footage, truth) for piece in pose_ranges(movements, truth.frames)]
        at = [
            [s.shown_frames[c] for c in samples.cameras]
            for s in sample_cameras(footage, samples.cameras, step_s=1.0, height=16)
        ]
        np.savez_compressed(kept, at=np.array(at), **POSES.pack(solved))  # pyright: ignore[reportArgumentType]
    with np.load(kept) as stored:
        arrays = dict(stored)
    return Prepared(truth, samples, POSES.unpack(arrays), movements, arrays["at"])


def _solved(
    piece: FrameRange, samples: SampleStore, movements: Sequence[Movement], footage: Footage, truth: Truth
) -> SolvedPose:
    solver = PoseSolver(
        {c.name: c.size for c in footage.cameras},
        truth.reference,
        installed().choose("matcher").implementation,
        installed().choose("aligner").implementation,
        SolveSettings(),
    )
    return solver.solve(piece, samples.standing(piece, movements), samples, Silent())


# ------------------------------------------------------------------------------------------------------- training


def marked(folder: Path, name: str) -> Path:
    """The folder of the frames of one recording, painted by truth."""
    out = folder / f"{name}.frames"
    if out.exists():
        return out
    prepared = prepare(folder, name)
    with closing(prepared.samples):
        piece = prepared.segments(installed().choose("occlusion", "consensus"))[0]
        numbers = [prepared.samples.frames[int(i)] for i in piece.samples.positions]
        for picture in write_frames(out, piece.samples.aligned, piece.samples, numbers, count=FRAMES):
            number, camera = picture.stem.split("_")
            column = prepared.samples.cameras.index(camera)
            at = int(prepared.at[prepared.samples.frames.index(int(number)), column])
            own = prepared.truth.own_frame(camera, at)
            assert own is not None
            shape = read_png(picture).shape[:2]
            labels = Painter.of(prepared.truth.scenario, column).labels(own, shape)
            save_png(out / f"{picture.stem}.mask.png", painting(labels))
    return out


def models(folder: Path) -> dict[str, Any]:
    """Trains what is to be trained and names it to the plugins; what training told."""
    learned, network, told = folder / "learned.npz", folder / "small.onnx", folder / "models.json"
    os.environ |= {"MCSL_LEARNED_MODEL": str(learned), "MCSL_ONNX_MODEL": str(network)}
    if not told.exists():
        folders = [marked(folder, name) for name in TRAINED_ON]
        start = time.process_time()
        frames = [m for part in folders for m in read_marked(part)]
        model, judged = train(frames, Silent())
        spent = time.process_time() - start
        model.save(learned)
        told.write_text(
            json.dumps({"frames": judged.frames, "iou": judged.iou, "cpu_s": spent, **write_network(folders, network)})
        )
    return json.loads(told.read_text())


# -------------------------------------------------------------------------------------------------------- judging


def judge(prepared: Prepared, name: str) -> dict[str, float]:
    """One detector on one recording: error of the visible share, what the camera chosen by it shows, CPU a sample."""
    found = installed()
    offer = found.choose("occlusion", name)
    seen, standing = prepared.seen(), np.zeros(len(prepared.samples), bool)
    said = np.full(seen.shape, np.nan)
    start = time.process_time()
    pictures = 0.0
    for piece in prepared.segments(offer):
        for position in piece.samples.positions:
            before = time.process_time()
            views = piece.samples.aligned.views(prepared.samples[int(position)].pictures)
            pictures += time.process_time() - before
            for camera, value in piece.score(views).items():
                said[position, prepared.samples.cameras.index(camera)] = value
            standing[position] = True
    spent = time.process_time() - start - pictures
    known = standing[:, None] & ~np.isnan(said)
    chosen = np.nan_to_num(said, nan=-1).argmax(axis=1)
    rows = np.flatnonzero(standing)
    return {
        "error": float(np.abs(said - seen)[known].mean()),
        "chosen": float(seen[rows, chosen[rows]].sum() / seen[rows].max(axis=1).sum()),
        "programme": _programme(said, prepared, found),
        "cpu_ms": 1000 * spent / max(len(rows), 1),
    }


def _programme(said: NDArray[np.float64], prepared: Prepared, found: Plugins) -> float:
    """Visible field of the shots that the default selector makes of the scores, over the best camera's, per frame."""
    from mcsl_core.occlusion.score_table import ScoreTable

    truth, samples = prepared.truth, prepared.samples
    scores = ScoreTable(np.array(samples.frames), samples.cameras, said, ~np.isnan(said).all(axis=0) & (said == said))
    shots = found.choose("selector").implementation.select(scores, frames=truth.frames, rate=truth.rate)
    got = sum(
        float(truth.visible_field[s.range.start : s.range.stop, truth.cameras.index(s.camera)].sum()) for s in shots
    )
    return got / float(truth.visible_field.max(axis=1).sum())


def measure(folder: Path, name: str) -> dict[str, Any]:
    """All detectors on one recording; kept as JSON beside it."""
    kept = folder / f"{name}.figures.json"
    if not kept.exists():
        prepared = prepare(folder, name)
        with closing(prepared.samples):
            found = {"name": name, **{d: judge(prepared, d) for d in DETECTORS}}
        kept.write_text(json.dumps(found, indent=1) + "\n", "utf-8")
    return json.loads(kept.read_text("utf-8"))


def scene_of(name: str) -> str:
    """What the recording shows, in words."""
    s = ALL[name]
    return f"{s.drape} drape, {s.skin} skin, {s.gloves} gloves, {s.heads} heads"


def markdown(all_figures: Sequence[Mapping[str, Any]], told: Mapping[str, Any]) -> str:
    """The page: a table a measure, a column a detector."""

    def column(key: str, form: str, best: Any) -> str:
        rows = []
        groups = [[f for f in all_figures if (ALL[f["name"]].drape == "skin") == same] for same in (True, False)]
        for f in all_figures:
            rows.append([f["name"], scene_of(f["name"]), *(_bold(f, d, key, form, best) for d in DETECTORS)])
        for label, group in zip(("drapes of the skin's hue", "other drapes"), groups, strict=True):
            if group:
                mean = {d: {key: float(np.mean([f[d][key] for f in group]))} for d in DETECTORS}
                rows.append(["**mean**", label, *(_bold(mean, d, key, form, best) for d in DETECTORS)])
        return table(["", "scene", *DETECTORS], rows)

    iou = ", ".join(f"{name} {value:.2f}" for name, value in told["iou"].items())
    return "\n".join(
        [
            "# Occlusion detectors on simulated recordings",
            "",
            f"Made by `python -m benchmarks.detectors FOLDER` on {date.today().isoformat()}, "
            f"{platform.machine()}, Python {platform.python_version()}. Seeds 350 and up, used for nothing else; "
            f"90 s each, 640x360, five cameras, a sample a second at {SAMPLE_HEIGHT} rows.",
            "",
            f"`learned` was trained on {told['frames']} frames of six other operations (seeds 310 to 315), painted by "
            f"the simulator's truth, in {told['cpu_s']:.0f} s of CPU with its cross-validation; IoU on frames held "
            f"out: {iou}. `onnx` is a small network made of the same frames: {told['network']}. Both never saw the "
            "operations below. `hue-area` is the paper's kind.",
            "",
            "## Visible field: error",
            "",
            "Mean absolute difference from the true visible share of the field (0 to 1), over all samples and cameras "
            "while the lamp stands.",
            "",
            column("error", ".3f", min),
            "",
            "## Chosen camera: visibility",
            "",
            "What the camera of the highest score shows of the field, as a share of what the best one shows, samples.",
            "",
            column("chosen", ".1%", max),
            "",
            "The same of the programme that the default selector makes of the scores (no switch refined), every frame.",
            "",
            column("programme", ".1%", max),
            "",
            "## CPU a sample",
            "",
            "Milliseconds of CPU for all five views of a sample (one second of recording), the scorers' making "
            "included, reading and warping the pictures not.",
            "",
            column("cpu_ms", ".0f", min),
            "",
        ]
    )


def _bold(figures: Mapping[str, Any], detector: str, key: str, form: str, best: Any) -> str:
    text = format(figures[detector][key], form)
    leads = best(figures[d][key] for d in DETECTORS)
    return f"**{text}**" if text == format(leads, form) else text


def main() -> None:
    folder = Path(sys.argv[1]).absolute()
    folder.mkdir(parents=True, exist_ok=True)
    cv2.setNumThreads(1)
    told = models(folder)
    names = sys.argv[2:] or list(JUDGED)
    found = []
    for name in names:
        found.append(measure(folder, name))
        print(json.dumps(found[-1]), flush=True)
    if set(names) <= set(JUDGED):
        RESULTS.mkdir(exist_ok=True)
        (RESULTS / "detectors.md").write_text(markdown(found, told), "utf-8")
    else:
        print(markdown(found, told))


if __name__ == "__main__":
    main()
