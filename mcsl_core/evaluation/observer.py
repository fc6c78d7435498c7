"""Watching the variants of a programme frame by frame: the same tracks for all, each through its own matrices."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator

import attrs
import cv2
import numpy as np
from attrs import frozen

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.compositing.coverage import Coverage, has_picture
from mcsl_core.compositing.placement import programme_matrix, surface_of
from mcsl_core.compositing.proxy import ProxyFootage, proxy_edl, proxy_filler
from mcsl_core.edl import Edl, Look, Pose
from mcsl_core.edl.placement import placement_matrix
from mcsl_core.edl.resolve import Decision, offset_at, resolve, shift_at
from mcsl_core.imaging.planes import U8, Planes
from mcsl_core.imaging.relief import Placement
from mcsl_core.imaging.warp import WarpField
from mcsl_core.timing import FrameRange

from .metrics import NO_TRACKS, Lay, Points, Tracker, Tracks, carried, fidelity_db, grey, speed_px
from .results import FIELD, Pair


@frozen(eq=False)
class ShownFrame:
    """What a programme frame shows.

    Attributes
    ----------
    frame : int
        The programme frame.
    camera : str
        Its camera: the reference where the chosen one has no picture.
    picture : (H, W) uint8 or None
        The camera's own picture in grey, if there is one.
    """

    frame: int
    camera: str
    picture: U8 | None


class TrackFollower:
    """The tracks between two neighbouring frames, the same for all variants.

    They are found in the cameras' own pictures, so every variant is judged by the same points, whatever its pictures
    have become; a variant's matrices carry them into its programme, as they carry the pictures.

    Parameters
    ----------
    edl : Edl
        The programme, as a proxy.
    footage : ProxyFootage
        Its pictures.

    Attributes
    ----------
    now : ShownFrame
        The frame that was reached last.
    tracks, in_field : Tracks
        Between the frame before and this one: all, and those that begin about the field. Empty after a jump.
    """

    def __init__(self, edl: Edl, footage: ProxyFootage) -> None:
        self._edl, self._footage, self._tracker = edl, footage, Tracker()
        self._decisions = _by_frame(edl)
        self._before = self.now = ShownFrame(-2, edl.reference, None)
        self.tracks = self.in_field = NO_TRACKS

    def advance(self, frame: int) -> None:
        """Go on to programme frame ``frame``."""
        self._before, self.now, self.tracks, self.in_field = self.now, self._shown(frame), NO_TRACKS, NO_TRACKS
        a, b = self._before, self.now
        if a.frame == frame - 1 and a.picture is not None and b.picture is not None:
            find = self._tracker.follow if a.camera == b.camera else self._tracker.match
            self.tracks = find(a.picture, b.picture)
            self.in_field = self._in_field()

    def field_at(self, frame: int) -> tuple[float, float] | None:
        """Where the EDL has the field's middle in the programme before centering: centering moves it to the middle."""
        if not self._edl.centering:
            return None
        (width, height), (dx, dy) = self._edl.size, offset_at(self._edl.centering, frame)
        return (width - 1) / 2 - dx, (height - 1) / 2 - dy

    def _shown(self, frame: int) -> ShownFrame:
        for camera in (self._decisions[frame].camera, self._edl.reference):
            planes = self._footage.player(camera).at(frame)
            if planes is not None:
                return ShownFrame(frame, camera, grey(planes))
        return ShownFrame(frame, self._edl.reference, None)

    def _in_field(self) -> Tracks:
        """The tracks that begin about the field, as the EDL's own alignment lays them: again the same for all."""
        frame, camera = self._before.frame, self._before.camera
        pose, middle = self._edl.pose_at(frame), self.field_at(frame)
        if middle is None or placement_matrix(self._edl, pose, camera) is None:
            return NO_TRACKS
        start = carried(programme_matrix(self._edl, pose, camera), self.tracks.before)
        near = np.linalg.norm(start - middle, axis=1) < FIELD * self._edl.size[0]
        return Tracks(self.tracks.before[near], self.tracks.after[near])


@frozen(eq=False)
class _Observed:
    """One frame of a variant: its grey picture, which of its pixels are covered, and how its camera's picture lies."""

    picture: U8
    covered: U8
    lay: Lay


class VariantObserver:
    """Measures one variant of a programme, frame by frame.

    Parameters
    ----------
    edl : Edl
        The variant's EDL, at its full size.
    look : Look or None
        In place of its look.
    footage : ProxyFootage
        The pictures, shared by all observers.
    size : (int, int)
        Width and height of the pictures measured.
    """

    def __init__(self, edl: Edl, look: Look | None, footage: ProxyFootage, size: tuple[int, int]) -> None:
        self._edl, self._look, self._footage = proxy_edl(edl, size), look, footage.footage
        self._decisions = _by_frame(self._edl)
        self._compositor = Compositor(self._edl, footage, filler=proxy_filler(edl, size), look=look)
        self._coverage = Coverage(self._edl, self._footage, filler=proxy_filler(edl, size), look=look)
        self._kept_coverage: tuple[Hashable, U8] | None = None
        self._frames: Iterator[Planes] = iter(())
        self._before: _Observed | None = None
        self._surfaces: dict[tuple[FrameRange, str], WarpField | None] = {}

    def begin(self, run: FrameRange) -> None:
        """The next frames asked for are those of ``run``, in order."""
        self._frames, self._before = self._compositor.frames(run), None

    def step(self, frame: int, follower: TrackFollower) -> Pair | None:
        """Measure the frame before and this one.

        Parameters
        ----------
        frame : int
            The next programme frame of the run.
        follower : TrackFollower
            Has reached the same frame.

        Returns
        -------
        Pair or None
            None at a run's first frame.
        """
        decision = self._decisions[frame]
        if self._look is not None:
            decision = attrs.evolve(decision, **attrs.asdict(self._look))
        camera, pose = follower.now.camera, self._edl.pose_at(frame)
        offset = shift_at(self._edl, decision, frame)
        now = _Observed(
            grey(next(self._frames)),
            self._covered(frame, (pose.range, camera, offset, decision.fill)),
            self._lay(pose, camera, offset, decision.surface),
        )
        before, self._before = self._before, now
        if before is None:
            return None
        both: U8 = np.asarray(cv2.bitwise_and(before.covered, now.covered), np.uint8)
        in_field = self._about_field(both, follower.field_at(frame), offset)
        return Pair(
            fidelity_db(before.picture, now.picture),
            _known(fidelity_db(before.picture, now.picture, both)),
            _known(fidelity_db(before.picture, now.picture, in_field)),
            _known(speed_px(follower.tracks, before.lay, now.lay, self._edl.size)),
            _known(speed_px(follower.in_field, before.lay, now.lay, self._edl.size)),
        )

    def _lay(self, pose: Pose, camera: str, offset: tuple[float, float], surface: bool) -> Lay:
        """Camera pixels to programme pixels, by the very map that carries the picture."""
        placement = Placement(programme_matrix(self._edl, pose, camera), offset=offset)
        if surface and pose.relief is not None:
            key = pose.range, camera
            if key not in self._surfaces:
                self._surfaces[key] = surface_of(self._edl, pose, camera)
            placement = attrs.evolve(placement, field=self._surfaces[key])

        def lay(points: Points) -> Points:
            found = carried(placement.matrix, points)  # knows what has no place
            known = np.isfinite(found).all(axis=1)
            found[known] = placement.to_programme(points[known])
            return found

        return lay

    def _covered(self, frame: int, geometry: tuple[Hashable, ...]) -> U8:
        """The covered pixels, worked out again only where they may have changed."""
        present = tuple(has_picture(self._footage, c.name, frame) for c in self._edl.cameras)
        if self._kept_coverage is None or self._kept_coverage[0] != (geometry, present):
            self._kept_coverage = (geometry, present), self._coverage.covered(frame)
        return self._kept_coverage[1]

    def _about_field(self, mask: U8, field: tuple[float, float] | None, offset: tuple[float, float]) -> U8:
        """``mask`` within a circle about the field's middle, which this variant's centering shifts by ``offset``."""
        circle = np.zeros_like(mask)
        if field is not None:
            at = (round(field[0] + offset[0]), round(field[1] + offset[1]))
            cv2.circle(circle, at, round(FIELD * self._edl.size[0]), 255, cv2.FILLED)
        return np.asarray(cv2.bitwise_and(circle, mask), np.uint8)


def _by_frame(edl: Edl) -> list[Decision]:
    return [decision for piece, decision in resolve(edl) for _ in piece]


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value
