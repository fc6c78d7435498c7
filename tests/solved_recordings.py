"""Simulated recordings whose poses alone are solved, held against the truth."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

import numpy as np

from mcsl_core.alignment.observations import SolvedPose
from mcsl_core.alignment.pose_solver import PoseSolver
from mcsl_core.alignment.poses import solve_poses
from mcsl_core.alignment.relief.protocol import PlaneRelief
from mcsl_core.alignment.settings import SolveSettings
from mcsl_core.edl import Camera, Media, Movement
from mcsl_core.hooks.registry import discover
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.simulation import Scenario, Truth, alignment_error, best_plane_error


def solved(
    folder: Path, scenario: Scenario, frames: int, movements: Sequence[Movement] = (), *, relief: bool = False
) -> list[SolvedPose]:
    """The poses of a scenario's films in ``folder``, its cameras' clocks alike; without a relief unless asked for."""
    cameras = [
        Camera(name, (Media(f"{name}.mp4", frames),), scenario.size, scenario.rate) for name in scenario.camera_names
    ]
    offers = discover()
    solver = PoseSolver(
        dict.fromkeys(scenario.camera_names, scenario.size),
        scenario.camera_names[0],
        offers.choose("matcher", None).checked,
        offers.choose("aligner", None).checked,
        SolveSettings(),
        offers.choose("relief", None).checked if relief else PlaneRelief(),
    )
    footage = Footage(cameras, rate=scenario.rate, frames=frames, base=folder)
    with closing(SampleStore.record(footage, folder / "samples", Silent())) as samples:
        return solve_poses(solver, samples, movements, frames, Silent())


def ratios(truth: Truth, pose: SolvedPose, number: int) -> dict[str, float]:
    """Each camera's error over the field, in its best plane's."""
    planes = {name: np.array(h) for name, h in pose.pose.homographies.items() if name != truth.reference}
    return {n: alignment_error(truth, number, n, h) / best_plane_error(truth, number, n) for n, h in planes.items()}
