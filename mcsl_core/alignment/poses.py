"""The poses of a recording: between the lamp's movements, solved one after another, each tied to those before."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from attrs import frozen

from mcsl_core.edl import Movement
from mcsl_core.progress import Progress
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.timing import FrameRange

from .anchoring import anchor
from .observations import SolvedPose
from .pose_solver import solve_pose
from .protocol import Aligner, Matcher
from .settings import SolveSettings


def pose_ranges(movements: Sequence[Movement], frames: int) -> list[FrameRange]:
    """Stretches between the middles of the movements; they tile [0, frames)."""
    middles = [(m.range.start + m.range.stop) // 2 for m in movements]
    cuts = [0, *(m for m in middles if 0 < m < frames), frames]
    return [FrameRange(a, b) for a, b in zip(cuts, cuts[1:], strict=False)]


@frozen(eq=False)
class PoseSolver:
    """Solves every pose of a recording.

    Parameters
    ----------
    sizes
        Every camera's full (width, height).
    reference
        The camera whose view is the perspective.
    matcher, aligner
        Who finds the same places in two views, and who ties the views together.
    settings
        How a pose is solved.
    """

    sizes: Mapping[str, tuple[int, int]]
    reference: str
    matcher: Matcher
    aligner: Aligner
    settings: SolveSettings

    def solve(
        self, samples: SampleStore, movements: Sequence[Movement], frames: int, progress: Progress
    ) -> list[SolvedPose]:
        """Every pose of the ``frames`` in order, each anchored to those before."""
        solved: list[SolvedPose] = []
        pieces = pose_ranges(movements, frames)
        progress.stage("Aligning the views", len(pieces), "poses")
        for piece in pieces:
            pose = solve_pose(
                piece,
                samples.standing(piece, movements) or samples.within(piece),
                samples,
                self.sizes,
                reference=self.reference,
                matcher=self.matcher,
                aligner=self.aligner,
                settings=self.settings,
                progress=progress,
            )
            solved.append(
                anchor(pose, solved, samples, matcher=self.matcher, settings=self.settings, progress=progress)
            )
            progress.advance(len(solved))
        return solved
