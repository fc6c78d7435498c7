"""A camera that a pose does not see lies as the rig of another pose has it, one before or one after."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from attrs import define, evolve, field, frozen

from mcsl_core.progress import HeldNotes, Progress

from .observations import SolvedPose
from .relief.rig import Rig

_AHEAD = 2  # poses that are solved before their turn for one that lacks a camera: so many are held at once


class Poses(Protocol):
    """What `RigSharing` asks of the poses of a recording; see `RecordedPoses`."""

    def __len__(self) -> int: ...

    def shown(self, at: int, /) -> set[str]: ...

    def solve(
        self, at: int, earlier: Sequence[SolvedPose], rigs: Sequence[Rig], progress: Progress, /
    ) -> SolvedPose: ...


@frozen(eq=False)
class Attempt:
    """A pose as it was solved once.

    Attributes
    ----------
    pose : SolvedPose
        In its own perspective.
    notes : HeldNotes
        What was told meanwhile, to be told on if this is the pose that counts.
    rigs : tuple of Rig
        Those of other poses that it is solved by.
    """

    pose: SolvedPose
    notes: HeldNotes
    rigs: tuple[Rig, ...]


@define(eq=False)
class RigSharing:
    """Solves the poses of a recording in order, each by the rigs of others.

    It keeps the poses that it had to solve before their turn, for one before them that lacked a camera.

    Attributes
    ----------
    poses : Poses
        The recording's.
    progress : Progress
        Told of stages at once; of notes by whoever keeps an attempt.
    """

    poses: Poses
    progress: Progress
    _ahead: dict[int, Attempt] = field(init=False, factory=dict)

    def attempt(self, at: int, earlier: Sequence[SolvedPose]) -> Attempt:
        """Solves a pose by the rigs of those ``earlier``; where it lacks a camera by that of one after it as well.

        A head may hide the field from a camera through all of the first pose: left out, or 2 to 9 times its best
        plane's error off, it was at 1.0 to 1.4 as the second pose has it.
        """
        rigs = tuple(pose.rig for pose in earlier if pose.rig is not None)
        found = self._solved_ahead(at, rigs) or self._attempt(at, earlier, rigs)
        lacking = self._lacking(at, found.pose, rigs)
        for later in range(at + 1, min(at + 1 + _AHEAD, len(self.poses))):
            if not lacking:
                break
            if not self.poses.shown(later):
                continue
            if later not in self._ahead:
                own = () if found.pose.rig is None else (found.pose.rig,)
                self._ahead[later] = self._attempt(later, earlier, (*rigs, *own))
            rig = self._ahead[later].pose.rig
            if rig is not None and rig.sure() & lacking:
                return self._attempt(at, earlier, (*rigs, rig))
        return found

    def _solved_ahead(self, at: int, rigs: tuple[Rig, ...]) -> Attempt | None:
        """What was found before its turn, unless a rig that is known since helps with a camera it lacks."""
        found = self._ahead.pop(at, None)
        if found is None or any(rig.sure() & self._lacking(at, found.pose, ()) for rig in rigs):
            return None
        return evolve(found, rigs=rigs)

    def _attempt(self, at: int, earlier: Sequence[SolvedPose], rigs: tuple[Rig, ...]) -> Attempt:
        notes = HeldNotes(self.progress)
        return Attempt(self.poses.solve(at, earlier, rigs, notes), notes, rigs)

    def _lacking(self, at: int, pose: SolvedPose, rigs: Sequence[Rig]) -> set[str]:
        """Cameras with pictures that neither the pose nor a rig ties well; none where the reference camera has none."""
        known = set().union(*(rig.sure() for rig in rigs))
        own = pose.rig
        tied = set() if own is None else own.sure() | own.transferred() | (known & own.projections.keys())
        return self.poses.shown(at) - tied
