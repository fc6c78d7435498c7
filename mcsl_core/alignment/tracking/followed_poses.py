"""Poses that their own pictures tie badly, placed by following the lamp there from a pose beside that is well known.

Hands and heads may leave a pose too little in common between its cameras. But the lamp is rigid, and every frame of the
movement that leads there, and of the pose itself, is held against the background of the pose beside.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import attrs
import cv2
import numpy as np
from attrs import frozen

from mcsl_core.edl import Movement
from mcsl_core.imaging.geometry import (
    Array,
    inverse,
    project,
    scaling,
    to_edl_matrix,
)
from mcsl_core.imaging.masks import warp_mask
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore

from ..agreed_colours import agreed_colours
from ..observations import SolvedPose
from ..photo_consistency import Agreement, LaidView, agreement
from ..planes_by_surface import laid_by_surface
from ..relief.pose_relief import relief_document
from ..relief.surface_planes import FEWEST, plane_through
from ..steady import steady_view
from .first_picture import based_on_first
from .following import follow_from
from .lamp import Lamp, LampView
from .protocol import End
from .shared_surface import with_shared_surface
from .standing_poses import StandingPose, calibrated, instants_between
from .templates import Ground

_INTO_S = 1.5  # of the pose that is followed into: hands come and go, the lamp stands
_LEAST = 4  # instants of it at which the lamp is found
_STANDS = 2.0 / 960  # of the width, median: so near to each other they have it
_CONTRADICTS = 6.0 / 960  # of the width: a pose that is rightly tied is not so far from where the lamp shows it
_REACH = 4  # pixels of the reduced programme by which a place of a camera that is held may be off


@frozen(eq=False)
class PosePlacer:
    """Places poses by following the lamp.

    Attributes
    ----------
    samples : SampleStore
        The recording's, for the poses' backgrounds.
    footage : Footage
        Whose frames are decoded.
    movements : sequence of Movement
        In order.
    reference : str
        The reference camera.
    """

    samples: SampleStore
    footage: Footage
    movements: Sequence[Movement]
    reference: str

    def place(self, solved: Sequence[SolvedPose], progress: Progress) -> list[SolvedPose]:
        """The poses, placed from their neighbours where those know more, as far as the lamp can be followed to them.

        A pose is placed that has no relief, or one that lacks cameras and contradicts a whole one beside; cameras that
        its relief lacks lie as the lamp holds them. All share one surface (`with_shared_surface`). Where the first of a
        perspective is placed, all of it is laid anew over what the reference camera shows there.

        Parameters
        ----------
        solved : sequence of SolvedPose
            Tiling the programme, anchored.
        progress : Progress
            Told of the poses that are placed.
        """
        placed = list(solved)
        progress.stage("Placing poses by the lamp", len(solved), "poses")
        for perspective in sorted({pose.pose.perspective for pose in solved}):
            here = [i for i, pose in enumerate(solved) if pose.pose.perspective == perspective]
            if len(here) > 1 and (rig := self._rig(solved, perspective)) is not None:
                self._place_by(*rig, placed, here, progress)
            progress.advance(here[-1] + 1)
        return [_drawn_anew(now, before) for now, before in zip(placed, solved, strict=True)]

    def _rig(self, solved: Sequence[SolvedPose], perspective: int) -> tuple[Lamp, dict[int, StandingPose]] | None:
        """The lamp, and where it stands in the poses that are known; calibrated by those alone."""
        rig = calibrated(solved, perspective, self.reference, self.footage)
        if rig is None or not (wrong := self._contradicted(*rig, solved)):
            return rig
        without = list(solved)
        for i in wrong:
            without[i] = attrs.evolve(solved[i], pose=attrs.evolve(solved[i].pose, relief=None))
        return calibrated(without, perspective, self.reference, self.footage) or rig

    def _place_by(
        self,
        lamp: Lamp,
        known: dict[int, StandingPose],
        placed: list[SolvedPose],
        here: Sequence[int],
        progress: Progress,
    ) -> None:
        """Places what is not known of a perspective's poses, changing ``known`` and ``placed``."""
        by_pictures = {i for i, standing in known.items() if self.reference not in standing.refused}
        for i, standing in known.items():
            if standing.refused and (anew := self._without_refused(standing)) is not None:
                standing = known[i] = anew
                placed[i] = standing.pose
                names = ", ".join(standing.refused)
                progress.note(f"frames {placed[i].pose.range}: {names} placed as the lamp holds them, not as tied")
            if held := self._held(lamp, standing):
                known[i] = self._completed(standing, held)
                placed[i] = known[i].pose
                progress.note(f"frames {placed[i].pose.range}: {', '.join(held)} placed as the lamp holds them")
        for to, by in _ways(here, known):
            if (found := self._followed(lamp, known[by], placed[to])) is not None:
                known[to], placed[to] = found, found.pose
                progress.note(f"frames {placed[to].pose.range}: its views lie as the lamp was followed there")
        known.update(with_shared_surface(known))
        for i in known:
            placed[i] = known[i].pose
        if here[0] in known.keys() - by_pictures:
            based_on_first(placed, known, here)

    def _contradicted(self, lamp: Lamp, known: Mapping[int, StandingPose], poses: Sequence[SolvedPose]) -> list[int]:
        """Poses whose relief lacks cameras and has others elsewhere than the lamp, followed from a whole one, shows."""
        whole = {i for i, standing in known.items() if standing.projections.keys() == lamp.mounts.keys()}
        found = []
        for i in sorted(known.keys() - whole):
            ways = (self._followed(lamp, known[n], poses[i]) for n in (i - 1, i + 1) if n in whole)
            there = next((way for way in ways if way is not None), None)
            if there is not None and _apart(there, known[i]) > _CONTRADICTS:
                found.append(i)
        return found

    def _followed(self, lamp: Lamp, known: StandingPose, pose: SolvedPose) -> StandingPose | None:
        """A pose as the lamp, followed from another beside it, shows it; None where it is lost."""
        later = pose.pose.range.start > known.pose.pose.range.start
        border = pose.pose.range.start if later else pose.pose.range.stop
        at = next(i for i, m in enumerate(self.movements) if m.middle == border)
        movement, into = self.movements[at], round(_INTO_S * float(self.footage.rate))
        if later:
            limit = self.movements[at + 1].range.start if at + 1 < len(self.movements) else self.footage.frames
            first, last = movement.range.start, min(movement.range.stop + into, limit - 1)
        else:
            limit = self.movements[at - 1].range.stop if at else 0
            first, last = max(movement.range.start - into, limit), movement.range.stop - 1
        if last <= first or len(known.field_points()) < FEWEST:
            return None
        instants = instants_between(self.footage, first, last)
        end = known.end(lamp, self.samples, self.movements, movement)
        ordered = instants if later else instants[::-1]
        fits = follow_from(lamp, end, ordered)
        stands = [f.view for f, i in zip(fits, ordered, strict=True) if f and i.frame not in movement.range]
        view = self._common(lamp, stands, known.points)
        return None if view is None else self._standing(lamp, end, view, known, pose)

    def _common(self, lamp: Lamp, views: Sequence[LampView], points: Array) -> LampView | None:
        """The median of views; None where they are few or show it moving."""
        views = views[len(views) // 2 :]  # until it stands, what is found still follows
        if len(views) < _LEAST:
            return None
        median = LampView.of(np.median([view.numbers for view in views], axis=0))
        place, bound = project(lamp.projection(self.reference, median), points), _STANDS * lamp.sizes[self.reference][0]
        off = [np.median(np.hypot(*(project(lamp.projection(self.reference, v), points) - place).T)) for v in views]
        return median if np.median(off) < bound else None

    def _standing(
        self, lamp: Lamp, end: End, view: LampView, known: StandingPose, pose: SolvedPose
    ) -> StandingPose | None:
        """The pose with the lamp standing so, over the known one's relief; None where its field is lost."""
        none = np.eye(3)
        projections = {name: end.bends.get(name, none) @ lamp.projection(name, view) for name in lamp.mounts}
        found = self._over(known, projections, pose)
        return None if found is None else attrs.evolve(found, view=view)

    def _without_refused(self, standing: StandingPose) -> StandingPose | None:
        """The pose laid by its own relief with the refused cameras as the lamp holds them, the reference, too."""
        found = self._over(standing, standing.projections, standing.pose)
        return None if found is None else attrs.evolve(found, view=standing.view, refused=standing.refused)

    def _over(self, known: StandingPose, projections: Mapping[str, Array], pose: SolvedPose) -> StandingPose | None:
        """The pose with its cameras so, over the known one's relief; None where its field is lost."""
        none = np.eye(3)
        points, before = known.field_points(), known.pose.aligned
        full = before.camera_sizes[self.reference]
        anchor = plane_through(project(projections[self.reference], points), points[:, :2])
        if anchor is None:
            return None
        there = inverse(anchor) @ np.array(known.pose.pose.anchor)
        warp = scaling(full, pose.aligned.size) @ there @ scaling(before.size, full)
        field = warp_mask(before.field, warp, pose.aligned.size)
        if not field.any():
            return None
        moved = inverse(anchor) @ np.array(pose.pose.anchor)  # cameras that no relief has stay where they were shown
        homographies = {name: moved @ h for name, h in pose.aligned.homographies.items()} | {self.reference: none}
        aligned = attrs.evolve(pose.aligned, field=field, hands={}, homographies=homographies)
        relief = relief_document(projections, known.gamma, known.confidence)
        made = attrs.evolve(pose.pose, anchor=to_edl_matrix(anchor), relief=relief)
        made = attrs.evolve(pose, pose=made, aligned=aligned, field_by=known.pose.field_by)
        return StandingPose.of(self._laid(made, projections, points))

    def _held(self, lamp: Lamp, standing: StandingPose) -> dict[str, Array]:
        """Camera -> its projection, of those that the pose's relief lacks and that lie better so than by their planes.

        How their pictures agree with the others' decides; a weak camera has no plane, and may but be refuted.
        """
        lacking = sorted(lamp.mounts.keys() - standing.projections.keys())
        if not lacking or len(standing.field_points()) < FEWEST:
            return {}
        ground = Ground.of(lamp.sizes[self.reference], standing.gamma)
        shown = {n: steady_view([self.samples.picture(i, n) for i in standing.pose.samples]) for n in lamp.mounts}
        views = {name: view for name, view in shown.items() if view is not None}

        def laid(name: str, projection: Array) -> LaidView:
            grey = np.asarray(cv2.cvtColor(views[name].picture, cv2.COLOR_BGR2GRAY), np.uint8)
            steady = ground.laid(grey, lamp.sizes[name], projection, views[name].steady) > 0
            return LaidView(ground.laid(grey, lamp.sizes[name], projection), steady)

        known = [laid(name, projection) for name, projection in standing.projections.items() if name in views]
        held = {name: lamp.projection(name, standing.view) for name in lacking}
        for name in views.keys() & held.keys():
            found = sum((agreement(laid(name, held[name]), view, _REACH) for view in known), Agreement())
            if name not in standing.planes:
                refused = found.refutes
            else:
                flat = np.column_stack([standing.planes[name], np.zeros(3)])
                by_plane = sum((agreement(laid(name, flat), view, _REACH) for view in known), Agreement())
                refused = found.over_chance <= by_plane.over_chance
            if refused:
                del held[name]
        return held

    def _completed(self, standing: StandingPose, held: Mapping[str, Array]) -> StandingPose:
        """The pose with cameras that its relief lacks."""
        relief = relief_document({**standing.projections, **held}, standing.gamma, standing.confidence)
        aligned = standing.pose.aligned
        shown = aligned.hands.get(self.reference)
        hands = aligned.hands if shown is None else {**aligned.hands, **dict.fromkeys(held, shown)}
        pose = attrs.evolve(
            standing.pose,
            pose=attrs.evolve(standing.pose.pose, relief=relief),
            aligned=attrs.evolve(aligned, hands=hands),
        )
        completed = StandingPose.of(self._laid(pose, held, standing.field_points()))
        return standing if completed is None else attrs.evolve(completed, view=standing.view)

    def _laid(self, pose: SolvedPose, projections: Mapping[str, Array], points: Array) -> SolvedPose:
        """The pose with these cameras laid by the surface, and no longer weak."""
        laid = laid_by_surface(pose, projections, points)
        colour = agreed_colours(laid.aligned, [self.samples[i].pictures for i in pose.samples])
        weak = tuple(weak for weak in pose.pose.weak if weak.camera not in laid.aligned.homographies)
        return attrs.evolve(laid, pose=attrs.evolve(laid.pose, colour=colour, weak=weak))


def _drawn_anew(now: SolvedPose, before: SolvedPose) -> SolvedPose:
    """The pose with fields drawn by hand where they were drawn in the programme."""
    if not now.drawn or now.pose.anchor == before.pose.anchor:
        return now
    size = now.aligned.size
    reduced = scaling(now.aligned.camera_sizes[now.aligned.reference], size)
    warp = reduced @ inverse(np.array(now.pose.anchor)) @ np.array(before.pose.anchor) @ inverse(reduced)
    moved = [(piece, warp_mask(mask, warp, size)) for piece, mask in now.drawn]
    drawn = tuple((piece, mask) for piece, mask in moved if mask.any())
    aligned = now.aligned
    if sum(len(piece) for piece, _ in drawn) == len(now.pose.range):
        aligned = attrs.evolve(aligned, field=np.logical_or.reduce([mask for _, mask in drawn]))
    return attrs.evolve(now, drawn=drawn, aligned=aligned)


def _apart(one: StandingPose, other: StandingPose) -> float:
    """How far two say that a camera sees the same, median of the worst camera, of its width."""
    sizes = one.pose.aligned.camera_sizes
    both = one.projections.keys() & other.projections.keys()
    off = {n: project(one.projections[n], one.points) - project(other.projections[n], one.points) for n in both}
    return max(float(np.median(np.hypot(*apart.T))) / sizes[n][0] for n, apart in off.items())


def _ways(poses: Sequence[int], known: Mapping[int, StandingPose]) -> Iterator[tuple[int, int]]:
    """(pose that is not known, the one beside it that may be by then), forwards in time and then back."""
    for to, by in (*zip(poses[1:], poses, strict=False), *zip(poses[-2::-1], poses[::-1], strict=False)):
        if to not in known and by in known:
            yield to, by
