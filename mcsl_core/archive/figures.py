"""All figures of one operation in a row: what researchers sort by, and what triage ranks by."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import attrs
from attrs import frozen

from mcsl_core import edl as edls
from mcsl_core.analysis.measurements import load_measurements
from mcsl_core.documents import canonical_json, write_atomic
from mcsl_core.edl import Edl
from mcsl_core.edl.field import MIDDLE
from mcsl_core.edl.resolve import resolve
from mcsl_core.errors import McslError
from mcsl_core.evaluation.results import load_evaluation
from mcsl_core.report.headline import visible_field

from .job import Job
from .outcome import Outcome

SURE = 0.5  # a clock less sure than that is named
_FORM = 1  # of what is kept; another number has it made anew


@frozen(kw_only=True)
class Figures:
    """A row of the table. None: not known, not measured, or not there yet.

    Attributes
    ----------
    operation : str
        Its folder in the archive, or its number where names are kept out.
    results : str
        Its folder of results.
    state, step, why : str
        See `Outcome`.
    work_s : float
        How long its jobs took together, in seconds.
    cameras, files, recorded_bytes : int
        Of the recording.
    seconds : float
        How long it is.
    width, height : int
        Of its pictures, in pixels.
    rate : float
        Frames a second.
    shots, switches, movements, poses, perspectives, overrides : int or None
        How many.
    overridden_s : float or None
        How long the programme is the editor's.
    overrides_without_picture : int or None
        Overrides that name a camera which is weak or has no picture for some of their time.
    weak_cameras : int or None
        Cameras that are not tied to the others in some pose.
    weak_share : float or None
        Of all cameras' time, 0..1.
    visible, visible_best : float or None
        Mean visible share of the field in the cameras shown, and in the best ones, 0..1.
    field_unknown_share : float or None
        Of the time, in which nothing shows where the field lies.
    clock_confidence : float or None
        Of the least sure clock, 0..1.
    unsure_clocks : int or None
        Clocks less sure than 0.5.
    gap_share : float or None
        Of all cameras' time without a picture, damage and late starts together, 0..1.
    movement_s, longest_movement_s : float or None
        How long the lamp moves: in all, and the longest.
    residual_px : float or None
        The worst camera's in the worst pose.
    itf_db, av_speed_px, switches_itf_db, switches_av_speed_px : float or None
        As delivered; see `Steadiness`.
    """

    operation: str
    results: str
    state: str
    step: str
    why: str
    work_s: float
    cameras: int
    files: int
    recorded_bytes: int
    seconds: float
    width: int
    height: int
    rate: float
    shots: int | None = None
    switches: int | None = None
    movements: int | None = None
    poses: int | None = None
    perspectives: int | None = None
    overrides: int | None = None
    overridden_s: float | None = None
    overrides_without_picture: int | None = None
    weak_cameras: int | None = None
    weak_share: float | None = None
    visible: float | None = None
    visible_best: float | None = None
    field_unknown_share: float | None = None
    clock_confidence: float | None = None
    unsure_clocks: int | None = None
    gap_share: float | None = None
    movement_s: float | None = None
    longest_movement_s: float | None = None
    residual_px: float | None = None
    itf_db: float | None = None
    av_speed_px: float | None = None
    switches_itf_db: float | None = None
    switches_av_speed_px: float | None = None


def figures_of(operation: str, folder: Path, job: Job, outcome: Outcome) -> Figures:
    """The figures of an operation whose results lie in ``folder``; what is not there yet is None."""
    facts, known = job.facts, _kept(folder)
    return Figures(
        operation=operation,
        results=folder.name,
        state=outcome.state,
        step=outcome.step,
        why=outcome.why,
        work_s=round(outcome.seconds, 1),
        cameras=facts.cameras,
        files=facts.files,
        recorded_bytes=facts.bytes,
        seconds=round(facts.seconds, 3),
        width=facts.size[0],
        height=facts.size[1],
        rate=round(facts.rate, 5),
        **known,
    )


def _kept(folder: Path) -> dict[str, Any]:
    """What is read from the EDL, its scores and its evaluation; kept until one of them changes."""
    read = [path for name in ("edl.json", "edl.scores.npz", "figures.json") if (path := folder / name).is_file()]
    if not read:
        return {}
    key = [_FORM, *([path.name, path.stat().st_size, path.stat().st_mtime_ns] for path in read)]
    path = folder / "row.json"
    try:
        value = json.loads(path.read_text("utf-8"))
        if value["of"] == key:
            return value["figures"]
    except (OSError, ValueError, LookupError, TypeError):
        pass
    figures = _measured(folder)
    write_atomic(path, canonical_json({"of": key, "figures": figures}).encode())
    return figures


def _measured(folder: Path) -> dict[str, Any]:
    try:
        edl = edls.read(folder / "edl.json")
    except McslError:  # its outcome tells
        return {}
    try:
        scores = None if edl.scores is None else load_measurements(folder / edl.scores).scores
    except McslError:
        scores = None
    shown, best = visible_field(edl, scores)
    return {**_decided(edl), **_found(edl), "visible": shown, "visible_best": best, **_steady(folder / "figures.json")}


def _decided(edl: Edl) -> dict[str, Any]:
    pieces = resolve(edl)
    cameras = [decision.camera for _, decision in pieces]
    lacking = sum(_lacks_picture(edl, index) for index in range(len(edl.overrides)))
    return {
        "shots": len(edl.shots),
        "switches": sum(a != b for a, b in zip(cameras, cameras[1:], strict=False)),
        "overrides": len(edl.overrides),
        "overridden_s": float(sum(len(piece) for piece, decision in pieces if decision.overridden) / edl.rate),
        "overrides_without_picture": lacking,
    }


def _lacks_picture(edl: Edl, index: int) -> bool:
    override = edl.overrides[index]
    if override.camera is None:
        return False
    weak = [pose.range for pose in edl.poses if any(w.camera == override.camera for w in pose.weak)]
    return any(override.range.intersection(piece) for piece in (*weak, *edl.camera(override.camera).gaps))


def _found(edl: Edl) -> dict[str, Any]:
    time = edl.frames * len(edl.cameras)
    moving = [len(movement.range) for movement in edl.movements]
    weak = [(w.camera, len(pose.range)) for pose in edl.poses for w in pose.weak]
    clocks = [camera.clock.confidence for camera in edl.cameras if camera.name != edl.reference]
    unknown = sum(len(stretch.range) for stretch in edl.fields if stretch.by == MIDDLE)
    return {
        "movements": len(edl.movements),
        "movement_s": float(sum(moving) / edl.rate),
        "longest_movement_s": float(max(moving, default=0) / edl.rate),
        "poses": len(edl.poses),
        "perspectives": len({pose.perspective for pose in edl.poses}),
        "weak_cameras": len({camera for camera, _ in weak}),
        "weak_share": sum(length for _, length in weak) / time,
        "field_unknown_share": unknown / edl.frames,
        "clock_confidence": min(clocks, default=1.0),
        "unsure_clocks": sum(confidence < SURE for confidence in clocks),
        "gap_share": sum(len(gap) for camera in edl.cameras for gap in camera.gaps) / time,
        "residual_px": max((px for pose in edl.poses for px in pose.residual_px.values()), default=None),
    }


def _steady(path: Path) -> dict[str, Any]:
    try:
        delivered = load_evaluation(path).measured[-1]
    except (McslError, LookupError):
        return {}
    whole, switches = delivered.whole, delivered.switches
    return {
        "itf_db": whole.itf_db if whole else None,
        "av_speed_px": whole.av_speed_px if whole else None,
        "switches_itf_db": switches.itf_db,
        "switches_av_speed_px": switches.av_speed_px,
    }


COLUMNS = tuple(attribute.name for attribute in attrs.fields(Figures))
