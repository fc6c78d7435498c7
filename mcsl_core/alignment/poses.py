"""The poses of a recording: between the lamp's movements, solved one after another, each tied to those before."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np
from attrs import frozen

from mcsl_core.edl import DrawnField, Movement
from mcsl_core.edl.field import drawn_over
from mcsl_core.imaging.geometry import scaling, transform_points
from mcsl_core.imaging.masks import Mask, polygon_mask
from mcsl_core.progress import Progress
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.timing import FrameRange

from .anchoring import anchor
from .observations import SolvedPose
from .planes_by_surface import with_planes_by_surface
from .plausibility import implausible
from .pose_solver import PoseSolver
from .recorded_poses import RecordedPoses
from .relief.estimation import estimate_relief
from .relief.hand_masks import hand_masks
from .rig_sharing import RigSharing


def solve_poses(
    solver: PoseSolver,
    samples: SampleStore,
    movements: Sequence[Movement],
    frames: int,
    progress: Progress,
    drawn: Sequence[DrawnField] = (),
) -> list[SolvedPose]:
    """Every pose of a recording of so many ``frames`` in order, each anchored to those before; ``drawn``: by hand."""
    solved: list[SolvedPose] = []
    poses = RecordedPoses.of(solver, samples, movements, frames)
    recording = _Recording(poses, RigSharing(poses, progress), drawn, progress)
    progress.stage("Aligning the views", len(poses), "poses")
    for at in range(len(poses)):
        solved.append(recording.solved(at, solved))
        solved = with_needed_points(solved)
        progress.advance(len(solved))
    return solved


def with_needed_points(solved: Sequence[SolvedPose]) -> list[SolvedPose]:
    """``solved`` whose poses keep their points where a later one may be anchored by them: in three hours of small
    pictures with a movement every ten minutes the points of all poses took 110 MB."""
    last = solved[-1]
    began = next(pose for pose in solved if pose.pose.perspective == last.pose.perspective)
    return [pose if pose is last or pose is began else _without_evidence(pose) for pose in solved]


def _without_evidence(pose: SolvedPose) -> SolvedPose:
    return attrs.evolve(pose, observations={}, scene=None, relief=None)


@frozen(eq=False)
class _Recording:
    """What every pose of a recording is solved and anchored by. drawn: the field by hand, in programme pixels."""

    poses: RecordedPoses
    sharing: RigSharing
    drawn: Sequence[DrawnField]
    progress: Progress

    def solved(self, at: int, earlier: Sequence[SolvedPose]) -> SolvedPose:
        """A pose, anchored; once more by the field that is drawn, which is known in its pictures by its anchor."""
        attempt = self.sharing.attempt(at, earlier)
        found = self._anchored(attempt.pose, earlier, attempt.notes)
        drawn = self._drawn_in(found, attempt.notes)
        if not drawn:
            attempt.notes.tell()
            return found
        whole = sum(len(piece) for piece, _ in drawn) == len(self.poses.ranges[at])
        known = np.logical_or.reduce([mask for _, mask in drawn] + ([] if whole else [found.aligned.field]))
        again = self.poses.solve(at, earlier, attempt.rigs, self.progress, known)
        again = self._anchored(again, earlier, self.progress)
        aligned = attrs.evolve(again.aligned, field=known if whole else found.aligned.field)
        again = attrs.evolve(again, aligned=aligned, field_by=found.field_by)
        return attrs.evolve(again, drawn=self._drawn_in(again, self.progress) or drawn)

    def _anchored(self, pose: SolvedPose, earlier: Sequence[SolvedPose], progress: Progress) -> SolvedPose:
        solver, samples = self.poses.solver, self.poses.samples
        tied = anchor(pose, earlier, samples, matcher=solver.matcher, settings=solver.settings, progress=progress)
        if tied.scene is None:
            return tied
        anchored = np.array(tied.pose.anchor)
        planes = {name: anchored @ h for name, h in tied.aligned.homographies.items()}
        shared = (one for one in earlier if one.pose.perspective == tied.pose.perspective)
        before = next((one.relief for one in shared if one.relief is not None), None)
        seen = tied.scene
        relief = estimate_relief(solver.estimator, seen.cameras, seen.views, planes, before, tied.aligned.field)
        if relief is None:
            return tied
        laid = with_planes_by_surface(tied, relief)
        if wrong := implausible(laid.aligned.homographies, solver.sizes, solver.reference):
            # A surface that says so is of something else: heads were matched.
            cameras = ", ".join(sorted(wrong))
            progress.note(
                f"frames {pose.pose.range}: its relief is left out, by which {cameras} would lie as no lamp does"
            )
            return tied
        aligned = attrs.evolve(laid.aligned, hands=hand_masks(relief, laid.aligned))
        made = attrs.evolve(laid.pose, relief=relief.document())
        return attrs.evolve(laid, aligned=aligned, pose=made, relief=relief)

    def _drawn_in(self, pose: SolvedPose, progress: Progress) -> tuple[tuple[FrameRange, Mask], ...]:
        """What is drawn over a pose, as masks of its aligned picture, but for what lies outside of that."""
        aligned = pose.aligned
        full = aligned.camera_sizes[aligned.reference]
        to_aligned = scaling(full, aligned.size) @ np.linalg.inv(np.array(pose.pose.anchor))
        found = []
        for piece, polygons in drawn_over(self.drawn, pose.pose.range):
            if polygons is None:
                continue
            moved = [transform_points(to_aligned, np.array(polygon, np.float64)) for polygon in polygons]
            mask = polygon_mask(moved, aligned.size)
            if mask.any():
                found.append((piece, mask))
            else:
                progress.note(f"frames {piece}: the field that is drawn lies outside of the picture then")
        return tuple(found)
