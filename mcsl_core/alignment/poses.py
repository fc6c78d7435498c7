"""The poses of a recording: between the lamp's movements, solved one after another, each tied to those before."""

from __future__ import annotations

from collections.abc import Sequence

from mcsl_core.edl import Movement
from mcsl_core.progress import Progress
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.timing import FrameRange

from .anchoring import anchor
from .observations import SolvedPose
from .pose_solver import PoseSolver


def pose_ranges(movements: Sequence[Movement], frames: int) -> list[FrameRange]:
    """The frames between the middles of the movements; they tile [0, frames)."""
    middles = [(m.range.start + m.range.stop) // 2 for m in movements]
    cuts = [0, *(m for m in middles if 0 < m < frames), frames]
    return [FrameRange(a, b) for a, b in zip(cuts, cuts[1:], strict=False)]


def solve_poses(
    solver: PoseSolver, samples: SampleStore, movements: Sequence[Movement], frames: int, progress: Progress
) -> list[SolvedPose]:
    """Every pose of a recording of so many ``frames`` in order, each anchored to those before."""
    solved: list[SolvedPose] = []
    ranges = pose_ranges(movements, frames)
    progress.stage("Aligning the views", len(ranges), "poses")
    for within in ranges:
        standing = samples.standing(within, movements) or samples.within(within)
        pose = solver.solve(within, standing, samples, progress)
        solved.append(
            anchor(pose, solved, samples, matcher=solver.matcher, settings=solver.settings, progress=progress)
        )
        progress.advance(len(solved))
    return solved
