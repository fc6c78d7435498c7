"""One harness for each kind of input: valid documents to begin with, and what reads and uses them.

A harness takes the bytes of a file. Nothing but `McslError` may come out of it; `FuzzedFile` says which input did else.
"""

from __future__ import annotations

import io
import json
import warnings
from collections.abc import Callable, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from attrs import frozen

from mcsl_core import edl as edls
from mcsl_core.analysis import cache
from mcsl_core.analysis.measurements import Measurements, load_measurements
from mcsl_core.blender.messages import ReadDecisions, structure, to_json
from mcsl_core.centering.gaze_files import Shown, read_gaze
from mcsl_core.centering.positions import gaze_positions
from mcsl_core.delivery.presets import load_preset, presets_folder
from mcsl_core.documents import read_json
from mcsl_core.edl import (
    IDENTITY,
    Camera,
    Clock,
    Colour,
    Correction,
    Edl,
    Look,
    MadeBy,
    Media,
    Movement,
    Override,
    Pose,
    Shot,
)
from mcsl_core.edl.dependencies import views_of
from mcsl_core.edl.resolve import resolve_by_pose, shift_at
from mcsl_core.errors import McslError
from mcsl_core.evaluation.manual_alignment import aligned_by_hand, load_manual
from mcsl_core.evaluation.questionnaire import analyse_questionnaire, to_csv
from mcsl_core.evaluation.questionnaire import to_json as study_json
from mcsl_core.evaluation.results import (
    Conditions,
    Evaluation,
    Measured,
    Pair,
    Steadiness,
    Switch,
    load_evaluation,
)
from mcsl_core.evaluation.results import to_csv as figures_csv
from mcsl_core.evaluation.results import to_json as figures_json
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.progress import Silent
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.report.facts import gather
from mcsl_core.report.steady import steady_facts
from mcsl_core.timing import FrameRange

warnings.simplefilter("ignore", RuntimeWarning)  # of numpy, about numbers that are then refused
R = FrameRange
SHIFT = ((1.0, 0.0, 5.0), (0.0, 1.0, -3.0), (0.0, 0.0, 1.0))


@frozen
class Harness:
    """Where the file lies by its name, what it begins with, and what is done with it."""

    name: str
    seeds: tuple[bytes, ...]
    use: Callable[[Path], object]

    def run(self, folder: Path, data: bytes) -> bool:
        """Whether the input was taken; False where it was refused in our own words."""
        path = folder / self.name
        path.write_bytes(data)
        try:
            self.use(path)
        except McslError as error:
            str(error).encode("utf-8", "backslashreplace")
            return False
        return True


def full_edl() -> Edl:
    """Two cameras, two poses, and something of everything that an EDL may hold."""
    names = ("cam1", "cam2")
    pose = {"cam1": IDENTITY, "cam2": SHIFT}
    row = (1.0, 0.0, 0.0, 2.0)
    return Edl(
        rate=Fraction(30000, 1001),
        size=(320, 180),
        frames=300,
        reference="cam1",
        cameras=tuple(
            Camera(
                n, (Media(f"{n}.mp4", 300, "f"),), (320, 180), Fraction(30), Clock(0.5, 3.0, "audio", 0.9), (R(3, 5),)
            )
            for n in names
        ),
        movements=(Movement(R(140, 160), 0.9),),
        poses=(
            Pose(R(0, 150), pose, anchor=SHIFT, colour={"cam2": Colour((row, row, row))}, solved_from=(1, 2)),
            Pose(R(150, 300), pose, residual_px={"cam2": 1.5}, support={"cam2": 40}),
        ),
        shots=(Shot(R(0, 120), "cam2", 0.8, "sees more"), Shot(R(120, 300), "cam1")),
        overrides=(Override(R(10, 60), camera="cam1", offset=(4.0, -2.0), note="x"), Override(R(50, 200), fill=False)),
        corrections=(Correction(R(0, 150), "cam2", SHIFT),),
        look=Look(),
        centering=((0, 1.0, 2.0), (200, -3.0, 4.0)),
        scores="e.scores.npz",
        made_by=MadeBy(
            "0.1", {"sync": "auto", "gaze": [{"file": "a", "samples": 3, "used": 2}]}, {"filler": "footprint"}
        ),
    )


EDL = full_edl()


def use_edl(path: Path) -> None:
    edl = edls.load(path)
    assert edls.loads(edls.dumps(edl)) == edl
    for piece, decision, pose_index in resolve_by_pose(edl):
        shift_at(edl, decision, piece.start)
        views_of(edl, edl.poses[pose_index], decision)
    gather(edl, None)


def use_gaze(path: Path) -> None:
    shown = Shown(30.0, 300, (320, 180), {c.name: c.size for c in EDL.cameras})
    file = read_gaze(path, shown)
    str(file)
    assert all(-1e9 < v < 1e9 for position in gaze_positions(file.looks, EDL) for v in position.middle)


def use_hand(path: Path) -> None:
    for fit in ("similarity", "homography"):
        aligned_by_hand(EDL, load_manual(path, EDL, fit=fit))


def use_ratings(path: Path) -> None:
    results = analyse_questionnaire(path)
    study_json(results), to_csv(results)


def use_cache(path: Path) -> None:
    """The first byte says whose result it is."""
    data = path.read_bytes()
    stages = (cache.CLOCKS, cache.MOVEMENTS, cache.POSES, cache.SCORES, cache.CUTS)
    stage: Any = stages[data[0] % len(stages)] if data else cache.CLOCKS
    kept = path.with_name(f"{stage.name}-key.npz")
    kept.write_bytes(data[1:])
    try:
        cache.StageCache(path.parent, Silent()).remember(stage, "key", _made_again)
    finally:
        kept.unlink(missing_ok=True)


def _made_again() -> Any:
    raise McslError("made again")


def use_samples(path: Path) -> None:
    store = path.with_name("samples")
    store.write_bytes(b"jpeg")
    found = SampleStore.load(store)
    if found is not None:
        found.close()


def use_toml(path: Path) -> None:
    from mcsl_onnx_occlusion.description import read_description
    from mcsl_switching_style import load_style

    refused = 0
    for read in (read_description, load_style):
        try:
            read(path)
        except McslError:
            refused += 1
    if refused == 2:
        raise McslError("refused by both")


def use_figures(path: Path) -> None:
    evaluation = load_evaluation(path)
    steady_facts(evaluation, Fraction(30))
    figures_csv(evaluation), figures_json(evaluation)


def npz(arrays: Mapping[str, Any]) -> bytes:
    stream = io.BytesIO()
    np.savez(stream, **arrays)
    return stream.getvalue()


def text(value: Any) -> bytes:
    return json.dumps(value, ensure_ascii=False).encode()


TABLE = ScoreTable(np.arange(0, 300, 30), ("cam1", "cam2"), np.full((10, 2), 0.5), np.ones((10, 2), bool))
ROWS = b"".join(b"s%d,1,comfort,%s,%d\n" % (n, m, 1 + n % 5) for n in range(6) for m in (b"a", b"b", b"c"))
POINTS = [[0, 0, 5, 3], [300, 10, 310, 12], [20, 170, 30, 180], [310, 160, 300, 170]]
ENTRIES = [
    {"camera": "cam1", "transform": {"scale": 1.1, "offset_x": 3}},
    {"camera": "cam2", "points": POINTS},
    {"camera": "cam2", "pose": 1, "homography": SHIFT},
]
CSV = b"pose,camera,x,y,programme_x,programme_y\n" + b"".join(b",cam2,%d,%d,%d,%d\n" % tuple(p) for p in POINTS)
GAZE = b"".join(b"%.3f,Kim,%d,%d,cam2\n" % (n / 30, 100 + n % 9, 80) for n in range(0, 300, 9))
TOBII = b"".join(b"%d\tP1\t%d\t%d\n" % (n * 33333, 100 + n % 9, 80) for n in range(40))
DECIDED = ReadDecisions(Path("/a/edl.json"), EDL.overrides, EDL.corrections, EDL.look, EDL.drawn_fields, (), None, True)
ONNX = (
    b'[output]\nmeaning = "sigmoid"\nfield = [0]\nthreshold = 0.4\n[input]\nsize = [96, 64]\nmean = [0.5, 0.5, 0.5]\n'
)
STYLE = b'base = "calm"\nmin_shot_s = 3\nmax_shot_s = inf\npreferred = "cam1"\nhold = 0.5\n'
SAMPLES = {"cameras": ["a", "b"], "frames": [0, 30], "pictures": [{"a": [0, 2]}, {"b": [2, 2]}]}
MEANS = Steadiness(30.0, 31.0, None, 1.5, 1.2, 10, 9)
MEASURED = Measured("auto", "Auto", MEANS, MEANS, (Pair(30.0, None, 31.0, 1.0, None),))
FIGURES = Evaluation(Conditions((640, 360), 10, 1), (Switch(120, "cam2", "cam1"),), (MEASURED,))

HARNESSES: dict[str, Harness] = {
    "edl": Harness("e.json", (edls.dumps(EDL).encode(),), use_edl),
    "gaze": Harness(
        "g.csv",
        (
            b"time,observer,x,y,camera\n" + GAZE,
            b"Recording timestamp\tParticipant name\tGaze point X\tGaze point Y\n" + TOBII,
            b"gaze_timestamp;confidence;norm_pos_x;norm_pos_y\n0,1;0,9;0,5;0,4\n0,2;0,9;0,5;0,4\n",
        ),
        use_gaze,
    ),
    "ratings": Harness("r.csv", (b"participant,video,factor,method,rating\n" + ROWS,), use_ratings),
    "points": Harness("p.csv", (CSV,), use_hand),
    "hand": Harness("h.json", (text({"alignments": ENTRIES}),), use_hand),
    "preset": Harness(
        "p.json", tuple(p.read_bytes() for p in sorted(presets_folder().glob("*.json"))), lambda p: load_preset(p)
    ),
    "toml": Harness("t.toml", (ONNX, STYLE), use_toml),
    "scores": Harness("s.npz", (npz({**TABLE.arrays(), **Measurements(TABLE).movement.arrays()}),), load_measurements),
    "cache": Harness(
        "c.npz",
        (
            b"\0" + npz(cache.CLOCKS.pack((Clock(), Clock(1.0)))),
            b"\3" + npz(cache.SCORES.pack(TABLE)),
            b"\4" + npz(cache.CUTS.pack((10, 20))),
        ),
        use_cache,
    ),
    "samples": Harness("samples.json", (text(SAMPLES),), use_samples),
    "blend": Harness(
        "b.json",
        (text(to_json(DECIDED)),),
        lambda p: structure(read_json(p), ReadDecisions, where="Blender's answer"),
    ),
    "figures": Harness("f.json", (figures_json(FIGURES).encode(),), use_figures),
}
