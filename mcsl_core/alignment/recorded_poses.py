"""The poses of a recording as the solver gets them: each one's frames, the samples in which the lamp stands still.

Where the reference camera has no picture a pose is solved in another camera's view, and laid in the reference's by how
that camera lay in the pose before.
"""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np
from attrs import frozen

from mcsl_core.edl import Movement
from mcsl_core.imaging.geometry import scaling, size_at_columns, to_edl_matrix
from mcsl_core.imaging.masks import Mask, warp_mask
from mcsl_core.progress import Progress
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.timing import FrameRange

from .aligned_views import AlignedPose
from .observations import SolvedPose
from .pose_solver import PoseSolver
from .relief.rig import Rig

_ENOUGH = 3  # samples with the reference camera's picture from which a pose is solved in its view


def pose_ranges(movements: Sequence[Movement], frames: int) -> list[FrameRange]:
    """The frames between the middles of the movements; they tile [0, frames).

    A movement in which the recording begins or ends has no pose on its other side: nothing there stands still.
    """
    middles = [m.middle for m in movements if m.range.start > 0 and m.range.stop < frames]
    cuts = [0, *(m for m in middles if 0 < m < frames), frames]
    return [FrameRange(a, b) for a, b in zip(cuts, cuts[1:], strict=False)]


@frozen(eq=False)
class RecordedPoses:
    """What every pose of a recording is solved by and from.

    Attributes
    ----------
    solver : PoseSolver
        What solves one.
    samples : SampleStore
        The recording's.
    ranges : sequence of FrameRange
        Each pose's frames.
    standing : sequence of sequence of int
        Each pose's samples: those in which the lamp stands still, all of it where there are none.
    """

    solver: PoseSolver
    samples: SampleStore
    ranges: Sequence[FrameRange]
    standing: Sequence[Sequence[int]]

    @classmethod
    def of(cls, solver: PoseSolver, samples: SampleStore, movements: Sequence[Movement], frames: int) -> RecordedPoses:
        """Those of a recording of so many ``frames``, between its movements."""
        ranges = pose_ranges(movements, frames)
        standing = [samples.standing(within, movements) or samples.within(within) for within in ranges]
        return cls(solver, samples, ranges, standing)

    def __len__(self) -> int:
        return len(self.ranges)

    def shown(self, at: int) -> set[str]:
        """The cameras that have pictures in a pose; none where the reference's are too few to solve it in its view."""
        if not self._with_reference(at):
            return set()
        return {n for n in self.solver.sizes if any(self.samples.shows(i, n) for i in self.standing[at])}

    def solve(
        self,
        at: int,
        earlier: Sequence[SolvedPose],
        rigs: Sequence[Rig],
        progress: Progress,
        known: Mask | None = None,
    ) -> SolvedPose:
        """Solves a pose in its own perspective.

        Parameters
        ----------
        at : int
            Which.
        earlier : sequence of SolvedPose
            The poses before it; the last says how cameras lay, where the reference camera has no picture now.
        rigs, progress, known
            As `PoseSolver.solve` has them.
        """
        solver, samples, within, standing = self.solver, self.samples, self.ranges[at], self.standing[at]
        with_reference = self._with_reference(at)
        if with_reference:
            return solver.solve(within, with_reference, samples, progress, known=known, rigs=rigs)
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

    def _with_reference(self, at: int) -> list[int]:
        """The samples in which the reference camera has a picture, if they are enough to solve the pose in its view."""
        standing = self.standing[at]
        shown = [position for position in standing if self.samples.shows(position, self.solver.reference)]
        return shown if len(shown) >= min(_ENOUGH, len(standing)) else []


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
    field = warp_mask(pose.aligned.field, warp, size)
    aligned = AlignedPose(size, reference, homographies, sizes, field)
    colour = {} if before is None else {n: c for n, c in before.pose.colour.items() if n in homographies}
    weak = tuple(w for w in pose.pose.weak if w.camera != reference)
    matrices = {name: to_edl_matrix(h) for name, h in homographies.items()}
    made = attrs.evolve(pose.pose, homographies=matrices, colour=colour, weak=weak)
    return attrs.evolve(pose, pose=made, aligned=aligned, scene=None, rig=None)
