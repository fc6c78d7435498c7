"""The poses of a recording: between the lamp's movements, solved one after another, each tied to those before."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np
from attrs import field, frozen

from mcsl_core.edl import DrawnField, Movement
from mcsl_core.edl.field import drawn_over
from mcsl_core.imaging.geometry import scaling, size_at_columns, to_edl_matrix, transform_points
from mcsl_core.imaging.masks import Mask, polygon_mask, resize_mask, warp_mask
from mcsl_core.progress import HeldNotes, Progress
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.timing import FrameRange

from .aligned_views import AlignedPose
from .anchoring import anchor
from .observations import SolvedPose
from .pose_solver import PoseSolver
from .relief.estimation import PoseRelief, estimate_relief, resting_hands_in, surface_pairs
from .relief.rig import Rig

_COVERED = 0.05  # of the field by hands that rest, from which its planes are laid anew
_ENOUGH = 3  # samples with the reference camera's picture from which a pose is solved in its view
_AHEAD = 2  # poses that are solved before their turn for one that lacks a camera: so many are held at once


def pose_ranges(movements: Sequence[Movement], frames: int) -> list[FrameRange]:
    """The frames between the middles of the movements; they tile [0, frames)."""
    middles = [(m.range.start + m.range.stop) // 2 for m in movements]
    cuts = [0, *(m for m in middles if 0 < m < frames), frames]
    return [FrameRange(a, b) for a, b in zip(cuts, cuts[1:], strict=False)]


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
    ranges = pose_ranges(movements, frames)
    standing = [samples.standing(within, movements) or samples.within(within) for within in ranges]
    recording = _Recording(solver, samples, drawn, progress, ranges, standing)
    progress.stage("Aligning the views", len(ranges), "poses")
    for at in range(len(ranges)):
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
    """What every pose of a recording is solved by and from.

    drawn: the field by hand, in programme pixels. ranges, standing: each pose's frames and samples. ahead: poses that
    were solved before their turn, with what was told of them.
    """

    solver: PoseSolver
    samples: SampleStore
    drawn: Sequence[DrawnField]
    progress: Progress
    ranges: Sequence[FrameRange]
    standing: Sequence[Sequence[int]]
    ahead: dict[int, tuple[SolvedPose, HeldNotes]] = field(factory=dict)

    def solved(self, at: int, earlier: Sequence[SolvedPose]) -> SolvedPose:
        """A pose, anchored; once more by the field that is drawn, which is known in its pictures by its anchor."""
        found, held, rigs = self._by_best_rig(at, earlier)  # what is told is told of the pose that counts
        found = self._anchored(found, earlier, held)
        drawn = self._drawn_in(found, held)
        if not drawn:
            held.tell()
            return found
        whole = sum(len(piece) for piece, _ in drawn) == len(self.ranges[at])
        known = np.logical_or.reduce([mask for _, mask in drawn] + ([] if whole else [found.aligned.field]))
        again = self._once(at, earlier, rigs, self.progress, known)
        again = self._anchored(again, earlier, self.progress)
        aligned = attrs.evolve(again.aligned, field=known if whole else found.aligned.field)
        again = attrs.evolve(again, aligned=aligned, field_by=found.field_by)
        return attrs.evolve(again, drawn=self._drawn_in(again, self.progress) or drawn)

    def _by_best_rig(self, at: int, earlier: Sequence[SolvedPose]) -> tuple[SolvedPose, HeldNotes, list[Rig]]:
        """A pose, what is told of it, and the rigs it was solved by; where it lacks a camera by one after it as well.

        A head may hide the field from a camera through all of the first pose: left out, or 2 to 9 times its best
        plane's error off, it was at 1.0 to 1.4 as the second pose has it.
        """
        rigs = [pose.rig for pose in earlier if pose.rig is not None]
        early = self.ahead.pop(at, None)
        if early is not None and any(rig.sure() & self._lacking(at, early[0], []) for rig in rigs):
            early = None  # it was solved before a rig was known that helps
        pose, held = early or self._held(at, earlier, rigs)
        lacking = self._lacking(at, pose, rigs)
        for later in range(at + 1, min(at + 1 + _AHEAD, len(self.ranges))):
            if not lacking:
                break
            if not self._shown(later):
                continue
            if later not in self.ahead:
                self.ahead[later] = self._held(later, earlier, [*rigs, *([pose.rig] if pose.rig else [])])
            rig = self.ahead[later][0].rig
            if rig is not None and rig.sure() & lacking:
                rigs = [*rigs, rig]
                return *self._held(at, earlier, rigs), rigs
        return pose, held, rigs

    def _held(self, at: int, earlier: Sequence[SolvedPose], rigs: Sequence[Rig]) -> tuple[SolvedPose, HeldNotes]:
        held = HeldNotes(self.progress)
        return self._once(at, earlier, rigs, held), held

    def _lacking(self, at: int, pose: SolvedPose, rigs: Sequence[Rig]) -> set[str]:
        """Cameras with pictures that neither the pose nor a rig ties well; none where the reference camera has none."""
        if not self._shown(at):
            return set()
        known = set().union(*(rig.sure() for rig in rigs))
        tied = set() if pose.rig is None else pose.rig.sure() | pose.rig.told() | (known & pose.rig.projections.keys())
        return {n for n in self.solver.sizes if any(self.samples.shows(i, n) for i in self.standing[at])} - tied

    def _shown(self, at: int) -> list[int]:
        """The samples in which the reference camera has a picture, if they are enough to solve the pose in its view."""
        standing = self.standing[at]
        shown = [position for position in standing if self.samples.shows(position, self.solver.reference)]
        return shown if len(shown) >= min(_ENOUGH, len(standing)) else []

    def _once(
        self,
        at: int,
        earlier: Sequence[SolvedPose],
        rigs: Sequence[Rig],
        progress: Progress,
        known: Mask | None = None,
    ) -> SolvedPose:
        """A pose, from the samples in which the reference camera has a picture; without any, from another's view."""
        solver, samples, within, standing = self.solver, self.samples, self.ranges[at], self.standing[at]
        shown = self._shown(at)
        if shown:
            return solver.solve(within, shown, samples, progress, known=known, rigs=rigs)
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

    def _anchored(self, pose: SolvedPose, earlier: Sequence[SolvedPose], progress: Progress) -> SolvedPose:
        solver = self.solver
        tied = anchor(pose, earlier, self.samples, matcher=solver.matcher, settings=solver.settings, progress=progress)
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
        tied = _planes_under_hands(tied, relief, solver)
        aligned = attrs.evolve(tied.aligned, hands=resting_hands_in(relief, tied.aligned))
        tied = attrs.evolve(tied, aligned=aligned)
        return attrs.evolve(tied, pose=attrs.evolve(tied.pose, relief=relief.document()), relief=relief)

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


def _planes_under_hands(pose: SolvedPose, relief: PoseRelief, solver: PoseSolver) -> SolvedPose:
    """The pose by planes that serve the field itself, where hands rest over it: matches took their height for its own.

    Without hands the planes stay: what a limb's sides do where no node is sure the matches' own bend says better.
    """
    aligned, reference = pose.aligned, pose.aligned.reference
    full = aligned.camera_sizes[reference]
    warp = scaling(full, aligned.size) @ np.array(pose.pose.anchor) @ scaling(aligned.size, full)
    field = warp_mask(aligned.field, warp, aligned.size)
    covered = resize_mask(relief.hands, aligned.size) & field
    if reference not in relief.surface.cameras or covered.sum() < _COVERED * max(field.sum(), 1):
        return pose
    pairs = surface_pairs(relief, reference, field)
    if not pairs:
        return pose
    sizes = {name: solver.sizes[name] for name in (reference, *(name for _, name in pairs))}
    found = solver.aligner.align(pairs, sizes, reference)
    if found.weak:
        return pose
    homographies = {**aligned.homographies, **found.homographies}
    made = attrs.evolve(
        pose.pose,
        homographies={name: to_edl_matrix(h) for name, h in homographies.items()},
        residual_px={**pose.pose.residual_px, **{n: round(v, 3) for n, v in found.residual_px.items()}},
        support={**pose.pose.support, **found.support},
    )
    return attrs.evolve(pose, pose=made, aligned=attrs.evolve(aligned, homographies=homographies))


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
