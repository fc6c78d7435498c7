"""Simulating a recording: one video file a camera, and the truth about them."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import NDArray

from mcsl_core.errors import InputError, McslError
from mcsl_core.outputs import locks
from mcsl_core.outputs.claim import claim, claim_folder
from mcsl_core.outputs.manifest import Manifest
from mcsl_core.progress import Progress
from mcsl_core.temporary import temporary_beside

from .clocks import Clock, clocks, frame_counts
from .filming import Film
from .ground import Ground
from .ideal import FIELD, FILM, FOLDER, film_ideal
from .recorder import Recorder
from .rig import PinholeCamera
from .scenario import Scenario
from .scene import Scene
from .schedule import movement_frames
from .truth import (
    ARRAYS,
    MovementTruth,
    PoseTruth,
    Truth,
    fit_homography,
    own_frame,
    rms_distance,
    save_truth,
    transfer,
)

_FILM = re.compile(r"cam\d+(_\d+)?\.\w+")  # of this many cameras or of more


def simulate(
    scenario: Scenario,
    out: Path,
    progress: Progress,
    recorder: Recorder | None = None,
    *,
    force: bool = False,
    ideal: bool = False,
) -> Truth:
    """Simulates a recording and the truth about it.

    Parameters
    ----------
    scenario
        What is to be filmed.
    out
        The folder for cam1.mp4, cam2.mp4, ... and truth.json with truth.npz; made if need be. An earlier simulation
        there is replaced when this one is whole, all of it; other files are not.
    progress
        Told of the frames.
    recorder
        How the files are written; the kindest way without. The truth is the same.
    force
        Replace files of those names that were not simulated, or changed since.
    ideal
        Film the ideal programme as well, into the folder "ideal" in ``out``: ideal.mp4, what a camera would show that
        hung still where the reference camera stands in the first pose, with hands and instruments, without heads, arms
        and noise; field.png, where the field lies in it. No analysis takes it for a camera. And the truth has
        ``in_movements``.

    Returns
    -------
    Truth
        As `load_truth` reads it from ``out``.

    Raises
    ------
    UsageError, InputError
        Where the recorder cannot write such a scenario; where ``out`` cannot be written to, or holds such files.

    Notes
    -----
    The same scenario makes the same files. Nothing half-written is left when it fails or is stopped.

    Examples
    --------
    >>> truth = simulate(Scenario(seed=1, duration_s=60), Path("recording"), Silent())  # doctest: +SKIP
    """
    out, recorder = Path(out), recorder or Recorder()
    recorder.check(scenario)
    claim_folder(out)
    with _told(out):
        out.mkdir(parents=True, exist_ok=True)
    with locks.alone(out / "truth.json", "simulation"):
        _check(scenario, out, force, ideal)
        with _part_of(out) as part:
            truth = _filmed(scenario, part, recorder, progress, ideal)
            with _told(out):
                _put(part, out)
    return truth


@contextmanager
def _part_of(out: Path) -> Iterator[Path]:
    """A hidden folder in ``out`` for files that are not whole yet, gone afterwards."""
    part = temporary_beside(out / "truth.json")
    try:
        with _told(out):
            part.mkdir()
        yield part
    except McslError as error:  # names the files as they would have been called
        error.where = error.where.replace(str(part), str(out))
        raise
    finally:
        shutil.rmtree(part, ignore_errors=True)


@contextmanager
def _told(out: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        remedy = "Choose another folder"
        raise InputError(f"cannot be written to ({error.strerror})", where=str(out), remedy=remedy) from error


def _check(scenario: Scenario, out: Path, force: bool, ideal: bool) -> None:
    """InputError where one of the files to be written into ``out`` is there and was not simulated."""
    films = [path for name in scenario.camera_names for path in (*out.glob(f"{name}.*"), *out.glob(f"{name}_*"))]
    for path in (*films, out / "truth.json", out / ARRAYS):
        claim(path, manifest=Manifest.inside(out), force=force)
    for name in (FILM, FIELD) if ideal else ():
        claim(out / FOLDER / name, manifest=Manifest.inside(out / FOLDER), force=force)


def _filmed(scenario: Scenario, out: Path, recorder: Recorder, progress: Progress, ideal: bool) -> Truth:
    """All files of a recording, into an empty folder."""
    progress.stage("scene")
    scene = Scene.of(scenario)
    ground = Ground.of(scenario, scene.surface, scene.rig)
    counts, times = frame_counts(scenario), clocks(scenario)
    progress.stage("film", sum(counts), "frames")
    visible = Film(scene, ground, recorder, out).run(progress)
    truth = _truth(scene, recorder, times, counts, visible)
    if ideal:
        truth = attrs.evolve(truth, in_movements=_in_movements(scene, truth))
        (out / FOLDER).mkdir()
        film_ideal(scene, ground, truth, out / FOLDER, progress)
    save_truth(truth, out / "truth.json", out / ARRAYS)
    return truth


def _put(part: Path, out: Path) -> None:
    """The files of a recording take their places, and those of an earlier one there go: never a mixture of both.

    The truth goes first and comes last: where it is, all else is.
    """
    (out / "truth.json").unlink(missing_ok=True)
    new = sorted(path.relative_to(part) for path in part.rglob("*") if path.is_file())
    new.sort(key=lambda name: name.name == "truth.json")
    earlier = [path for path in (*out.glob("cam*"), *(out / FOLDER).glob("*")) if _is_earlier(path)]
    for name in new:
        target, manifest = out / name, Manifest.inside((out / name).parent)
        target.parent.mkdir(exist_ok=True)
        manifest.expect(target, part / name)
        (part / name).replace(target)
    for path in set(earlier) - {out / name for name in new}:
        path.unlink()
    for folder in (out / FOLDER, out):
        if folder.is_dir():
            Manifest.inside(folder).record(*(out / name for name in new if (out / name).parent == folder))
    _leave(out / FOLDER)


def _is_earlier(path: Path) -> bool:
    """Whether a file is an earlier simulation's, and as that left it."""
    known = path.name in (FILM, FIELD) if path.parent.name == FOLDER else _FILM.fullmatch(path.name)
    return bool(known) and Manifest.inside(path.parent).knows(path)


def _leave(folder: Path) -> None:
    """Takes away the folder of an ideal programme that is gone, if nothing but its list is left in it."""
    listed = Manifest.inside(folder)
    if listed.exists and [path.name for path in folder.iterdir()] == [listed.path.name]:
        listed.path.unlink()
        folder.rmdir()


def _truth(
    scene: Scene, recorder: Recorder, times: tuple[Clock, ...], counts: tuple[int, ...], visible: list[NDArray]
) -> Truth:
    scenario = scene.scenario
    names = scenario.camera_names
    shown = np.zeros((2, scenario.frames, len(names)))
    for c, clock in enumerate(times):
        own = np.array([own_frame(clock, scenario.rate, n) for n in range(scenario.frames)])
        there = (own >= 0) & (own < counts[c])
        shown[:, there, c] = visible[c][own[there]].T
    movements = movement_frames(scenario)
    edges = [0, *(edge for movement in movements for edge in movement), scenario.frames]
    points = scene.surface.field_points_mm
    poses, errors = [], []
    for n, pose in enumerate(scene.path.poses):
        pinholes = [scene.rig.camera(c, pose) for c in range(len(names))]
        px = np.stack([pinhole.project(points) for pinhole in pinholes])
        poses.append(
            PoseTruth(
                range=(edges[2 * n], edges[2 * n + 1]),
                K=np.stack([v.K for v in pinholes]),
                R=np.stack([v.R for v in pinholes]),
                t=np.stack([v.t for v in pinholes]),
                field_points_px=px,
                k1=np.array([v.k1 for v in pinholes]),
            )
        )
        errors.append(
            {
                name: rms_distance(transfer(fit_homography(px[c], px[0]), px[c]), px[0])
                for c, name in enumerate(names)
                if c
            }
        )
    return Truth(
        scenario=scenario,
        rate=scenario.rate,
        frames=scenario.frames,
        size=scenario.size,
        cameras=names,
        files=tuple(recorder.file_name(name) for name in names),
        reference=names[0],
        camera_frames=counts,
        clocks=times,
        movements=movements,
        poses=tuple(poses),
        field_points_mm=points,
        visible_field=shown[0],
        visible_field_without_hands=shown[1],
        best_plane_error_px=tuple(errors),
    )


def _in_movements(scene: Scene, truth: Truth) -> tuple[MovementTruth, ...]:
    """Every third frame of each movement."""
    return tuple(_movement(scene, truth, np.arange(start, stop, 3)) for start, stop in truth.movements)


def _movement(scene: Scene, truth: Truth, frames: NDArray) -> MovementTruth:
    rate = float(truth.rate)

    def shown(camera: int, frame: int) -> PinholeCamera:
        clock = truth.clocks[camera]
        own = own_frame(clock, truth.rate, frame)
        return scene.rig.camera(camera, scene.path.pose(clock.programme(own / rate))[0])

    cameras = range(len(truth.cameras))
    pinholes = [[shown(camera, int(frame)) for camera in cameras] for frame in frames]
    return MovementTruth(
        frames=frames,
        K=np.stack([[p.K for p in row] for row in pinholes]),
        R=np.stack([[p.R for p in row] for row in pinholes]),
        t=np.stack([[p.t for p in row] for row in pinholes]),
        field_points_px=np.stack([[p.project(truth.field_points_mm) for p in row] for row in pinholes]),
        k1=np.array([p.k1 for p in pinholes[0]]),
    )
