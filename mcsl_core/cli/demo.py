"""The whole way once, on a simulated recording, so that a newcomer sees what comes out before bringing a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from attrs import frozen
from rich.cells import cell_len

from mcsl_core.analysis.pipeline import analyse
from mcsl_core.analysis.settings import AnalysisSettings
from mcsl_core.analysis.summary import describe, summary
from mcsl_core.blender import installation as blenders
from mcsl_core.blender import render as rendering
from mcsl_core.blender.timeline import build_timeline
from mcsl_core.cli.language import word
from mcsl_core.edl import Edl
from mcsl_core.edl.placement import still_range
from mcsl_core.errors import InputError
from mcsl_core.hooks.registry import discover
from mcsl_core.outputs.claim import claim, claim_folder
from mcsl_core.outputs.inputs import inputs_of
from mcsl_core.outputs.manifest import Manifest
from mcsl_core.progress import Progress
from mcsl_core.report.contact_sheet import contact_sheet, head_sheet, movement_sheet, save_picture
from mcsl_core.simulation import Recorder, Scenario, Truth, alignment_error, best_plane_error, simulate

DURATION_S = 30.0
FREE, COVERED = 0.9, (0.1, 0.7)  # shares of the field that others see, and who has a head before it


@frozen
class Demo:
    """What the demo made: ``values`` for programs, ``text`` for people."""

    values: dict[str, Any]
    text: str


def run_demo(folder: Path, *, seed: int, blender: str | None, force: bool = False, progress: Progress) -> Demo:
    """Simulates, analyses, builds the timeline and renders into ``folder``; says where everything lies.

    Raises InputError when ``folder`` holds something that is not a demo, or a demo that somebody worked in, so that
    nothing of yours is overwritten but with ``force``.
    """
    claim_folder(folder)
    if not (folder / "recording" / "truth.json").exists() and not _is_free(folder):
        raise InputError("is not empty", where=str(folder), remedy="Name a new folder: mcsl demo FOLDER")
    desk, plugins = blenders.find(blender), discover()  # what is broken is said before the long work
    recording, edl_path = folder / "recording", folder / "edl.json"
    blend, video, sheet = folder / "edit.blend", folder / "programme.mp4", folder / "contact-sheet.png"
    moving, covered = folder / "movement-sheet.png", folder / "head-sheet.png"
    for file in (blend, video, sheet, moving, covered):
        claim(file, manifest=Manifest.beside(edl_path), force=force)
    scenario = Scenario(seed=seed, duration_s=DURATION_S, movements=1)
    recorder = Recorder(quick_coding=True)
    truth = simulate(scenario, recording, progress, recorder, force=force)
    made = analyse([recording], edl_path, settings=AnalysisSettings(), plugins=plugins, force=force, progress=progress)
    build_timeline(edl_path, blend, blender=desk, force=force, progress=progress)
    rendering.render(blend, video, preset="h264", engine="blender", blender=desk, force=force, progress=progress)
    middles = [(p.range.start + p.range.stop) // 2 for p in made.poses]
    pictures = {sheet: contact_sheet(made, folder, middles[:3])}
    if made.movements:
        pictures[moving] = movement_sheet(made, folder, made.movements[0])
    if heads := covered_moments(truth, made):
        pictures[covered] = head_sheet(made, folder, heads)
    moving.unlink(missing_ok=True)
    covered.unlink(missing_ok=True)
    for file, picture in pictures.items():
        out = claim(file, inputs=inputs_of(made, edl_path), manifest=Manifest.beside(edl_path), force=force)
        with out.writing() as part:
            save_picture(picture, part)
    errors = alignment_errors(truth, made)
    places = {
        "recording": recording,
        "edl": edl_path,
        "timeline": blend,
        "video": video,
        "contact_sheet": sheet,
    }
    places |= {name: at for name, at in (("movement_sheet", moving), ("head_sheet", covered)) if at in pictures}
    values = {k: str(v) for k, v in places.items()} | summary(made) | {"alignment": errors}
    return Demo(values, _text(places, made, truth, errors))


def _is_free(folder: Path) -> bool:
    """Whether nothing lies there but what a demo leaves that was stopped while it simulated: an empty recording."""
    inside = list(folder.iterdir()) if folder.exists() else []
    return all(p.name == "recording" and p.is_dir() and all(q.name[0] == "." for q in p.iterdir()) for p in inside)


def covered_moments(truth: Truth, made: Edl, most: int = 3) -> list[tuple[int, str]]:
    """Programme frames and cameras with a head before the field that two others see, by the truth; one a camera.

    The most covered first; not where the lamp moves, nor where a camera sees nothing of the field.
    """
    seen = truth.visible_field_without_hands[: made.frames]
    found: dict[str, tuple[float, int]] = {}
    for pose in made.poses:
        still = still_range(made, pose)
        for frame in range(still.start, min(still.stop, len(seen)), max(1, round(made.rate / 2))):
            for camera in pose.relief.projections if pose.relief else ():
                share = float(seen[frame, truth.camera_index(camera)])
                if (seen[frame] > FREE).sum() >= 2 and COVERED[0] < share < COVERED[1]:
                    found[camera] = min(found.get(camera, (1.0, 0)), (share, frame))
    return [(frame, camera) for camera, (_, frame) in sorted(found.items(), key=lambda each: each[1])[:most]]


def alignment_errors(truth: Truth, made: Edl) -> list[dict[str, Any]]:
    """Per pose of the truth and camera: rms error over the field in px, and the best single plane's.

    The pose of the EDL is the one that holds the middle of the true pose.
    """
    rows = []
    for index, still in enumerate(truth.poses):
        pose = made.pose_at(sum(still.range) // 2)
        for camera in truth.cameras:
            if camera != made.reference and camera in pose.homographies:
                error = alignment_error(truth, index, camera, np.array(pose.homographies[camera]))
                best = best_plane_error(truth, index, camera)
                rows.append(
                    {"pose": index, "camera": camera, "error_px": round(error, 2), "best_plane_px": round(best, 2)}
                )
    return rows


def _text(places: dict[str, Path], made: Edl, truth: Truth, errors: list[dict[str, Any]]) -> str:
    labels = {word(name.replace("_", " ")): path for name, path in places.items()}
    wide = max(map(cell_len, labels))
    lines = [f"{label}{' ' * (wide - cell_len(label))}  {path}" for label, path in labels.items()]
    lines += ["", describe(made)]
    if errors:
        mean = sum(e["error_px"] for e in errors) / len(errors)
        best = sum(e["best_plane_px"] for e in errors) / len(errors)
        lines.append(
            f"alignment error over the field: {mean:.1f} px; the best single plane's for this relief: {best:.1f} px"
        )
    true = ", ".join(
        f"{start / float(truth.rate):.1f}-{stop / float(truth.rate):.1f} s" for start, stop in truth.movements
    )
    lines.append(f"true movements: {true or 'none'}")
    return "\n".join(lines)
