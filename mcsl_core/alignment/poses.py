"""The poses of a recording: between the lamp's movements, solved one after another, each tied to those before."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import cv2
import numpy as np

from mcsl_core.edl import Movement
from mcsl_core.imaging.geometry import scaling, size_at_columns, to_edl_matrix
from mcsl_core.progress import Progress
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.timing import FrameRange

from .aligned_views import AlignedPose
from .anchoring import anchor
from .observations import SolvedPose
from .pose_solver import PoseSolver

_ENOUGH = 3  # samples with the reference camera's picture from which a pose is solved in its view


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
        pose = _solved(solver, within, standing, samples, solved, progress)
        solved.append(
            anchor(pose, solved, samples, matcher=solver.matcher, settings=solver.settings, progress=progress)
        )
        solved = with_needed_points(solved)
        progress.advance(len(solved))
    return solved


def with_needed_points(solved: Sequence[SolvedPose]) -> list[SolvedPose]:
    """``solved`` whose poses keep their points where a later one may be anchored by them: in three hours of small
    pictures with a movement every ten minutes the points of all poses took 110 MB."""
    last = solved[-1]
    began = next(pose for pose in solved if pose.pose.perspective == last.pose.perspective)
    return [pose if pose is last or pose is began else attrs.evolve(pose, observations={}) for pose in solved]


def _solved(
    solver: PoseSolver,
    within: FrameRange,
    standing: Sequence[int],
    samples: SampleStore,
    earlier: Sequence[SolvedPose],
    progress: Progress,
) -> SolvedPose:
    """One pose, from the samples in which the reference camera has a picture; without any, from another's view."""
    shown = [position for position in standing if samples.shows(position, solver.reference)]
    if len(shown) >= min(_ENOUGH, len(standing)):
        return solver.solve(within, shown, samples, progress)
    seen = {name: sum(samples.shows(position, name) for position in standing) for name in solver.sizes}
    tied = earlier[-1].aligned.homographies if earlier else {}
    stand_in = max(seen, key=lambda name: (2 * seen[name] >= len(standing), name in tied, seen[name]))
    if stand_in == solver.reference:
        return solver.solve(within, standing, samples, progress)
    progress.note(
        f"frames {within}: {solver.reference}, the reference camera, has no picture; the others lie by {stand_in}"
    )
    pose = attrs.evolve(solver, reference=stand_in).solve(within, standing, samples, progress)
    return _laid_by(pose, solver, earlier[-1] if stand_in in tied else None)


def _laid_by(pose: SolvedPose, solver: PoseSolver, before: SolvedPose | None) -> SolvedPose:
    """A pose solved in another camera's view, in the reference camera's: by how that camera lay in the pose before.

    The lamp holds its cameras, so it lies much the same still; what differs the anchor takes up.
    """
    stand_in, sizes, reference = pose.aligned.reference, solver.sizes, solver.reference
    to_reference = (
        scaling(sizes[stand_in], sizes[reference]) if before is None else before.aligned.homographies[stand_in]
    )
    homographies = {name: to_reference @ h for name, h in pose.aligned.homographies.items()}
    homographies[reference] = np.eye(3)
    size = size_at_columns(sizes[reference], pose.aligned.size[0])
    warp = scaling(sizes[reference], size) @ to_reference @ scaling(pose.aligned.size, sizes[stand_in])
    field = cv2.warpPerspective(pose.aligned.field.astype(np.uint8), warp, size, flags=cv2.INTER_NEAREST) > 0
    aligned = AlignedPose(size, reference, homographies, sizes, field)
    colour = {} if before is None else {n: c for n, c in before.pose.colour.items() if n in homographies}
    weak = tuple(w for w in pose.pose.weak if w.camera != reference)
    matrices = {name: to_edl_matrix(h) for name, h in homographies.items()}
    made = attrs.evolve(pose.pose, homographies=matrices, colour=colour, weak=weak)
    return attrs.evolve(pose, pose=made, aligned=aligned)
