"""What the cameras show at an instant, gathered for `filling.see_through`: while the lamp stands, and while it moves.

While it stands, a camera's background is made from medians of its pose. While it moves there are none: what the
cameras show where nobody is in their way is then laid into the programme from the poses before the movement and after
it, and from there into each camera as it lies at that instant.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import cv2
import numpy as np
from attrs import frozen

from mcsl_core.alignment.colour_match import colour_at
from mcsl_core.edl import Colour
from mcsl_core.edl.following import followed_movement, poses_beside
from mcsl_core.edl.placement import correction_of
from mcsl_core.filling.median_grid import grid_frames, grid_step
from mcsl_core.filling.see_through import Background, Moment, backgrounds
from mcsl_core.filling.visual_hull import Cells, Rays, grid_size, rays_of, taken
from mcsl_core.imaging.planes import Planes
from mcsl_core.imaging.relief import ReliefMap
from mcsl_core.lru_cache import LruCache
from mcsl_core.timing import FrameRange

from .camera_warper import CameraWarper
from .placement import has_relief
from .read_ahead import ReadAhead

_CELLS_BYTES = 60_000_000  # of pictures and medians on cells, 170 kB each
_RAYS_BYTES = 90_000_000  # of poses' rays, 29 MB each with five cameras
_UNSURE = 0.01  # weight of what nobody verifies, beside what is
_OWN = 4.0  # weight of what the camera itself shows of a place, beside what another does: gloss is a viewpoint's own


class Moments:
    """Makes `Moment`s for one compositor.

    Parameters
    ----------
    warper : CameraWarper
        Of the compositor.
    pictures : ReadAhead
        What the warper's pictures come from.

    Attributes
    ----------
    stretches : tuple of FrameRange
        In which what is above the field can be told: the lamp stands or is followed, by a relief of one perspective.
    """

    def __init__(self, warper: CameraWarper, pictures: ReadAhead) -> None:
        self._warper, self._pictures = warper, pictures
        self.stretches = tuple(_joined(self._pieces()))
        self.forget()

    def forget(self) -> None:
        """Let go of what was kept."""
        self._cells: LruCache[Cells | None] = LruCache(_CELLS_BYTES)
        self._known_rays: LruCache[Mapping[str, Rays]] = LruCache(_RAYS_BYTES)
        self._backgrounds: LruCache[Mapping[str, Background]] = LruCache(_CELLS_BYTES)

    def at(self, frame: int, now: int) -> Moment | None:
        """What is known of a frame.

        Parameters
        ----------
        frame : int
            A programme frame of one of `stretches`.
        now : int
            The one that is being made.

        Returns
        -------
        Moment or None
            None where no camera has a picture, or nothing tells which way is up.
        """
        laid_by = self._warper.pose_at(frame)
        moves = laid_by >= len(self._warper.edl.poses)
        rays = self._rays(laid_by) if moves else self._rays_of_pose(laid_by)
        found = {name: self._live(laid_by, name, frame, now) for name in rays}
        live = {name: cells for name, cells in found.items() if cells is not None}
        behind = self._behind_moving(frame, live, rays) if moves else self._behind(laid_by, frame)
        live = {name: cells for name, cells in live.items() if name in behind}
        return Moment.of(live, behind, rays) if live else None

    def _pieces(self) -> Iterator[tuple[FrameRange, int]]:
        """Stretches and their perspectives, in order."""
        edl = self._warper.edl
        followed = [
            (FrameRange(m.views[0].frame, m.views[-1].frame + 1), poses_beside(edl, m)[0].perspective)
            for m in edl.movements
            if m.views
        ]
        for still, pose in zip(self._warper.still, edl.poses, strict=True):
            if pose.relief is None:
                continue
            mine = [(both, p) for span, p in followed if (both := span.intersection(pose.range)) is not None]
            at = still.start
            for span, perspective in mine:
                if at < min(span.start, still.stop):
                    yield FrameRange(at, min(span.start, still.stop)), pose.perspective
                yield span, perspective
                at = max(at, span.stop)
            if at < still.stop:
                yield FrameRange(at, still.stop), pose.perspective

    def _rays_of_pose(self, pose_index: int) -> Mapping[str, Rays]:
        return self._known_rays.get(pose_index, lambda: self._rays(pose_index))

    def _rays(self, laid_by: int) -> Mapping[str, Rays]:
        """Of the cameras that the relief lays; empty where it does not tell which way is up."""
        edl, pose = self._warper.edl, self._warper.pose(laid_by)
        if pose.relief is None:
            return {}
        projections = {}
        for name, projection in pose.relief.projections.items():
            if has_relief(edl, pose, name):
                correction = correction_of(edl, pose, name)
                back = np.eye(4)
                if correction is not None:
                    back[np.ix_([0, 1, 2], [0, 1, 2])] = np.linalg.inv(np.array(correction))
                projections[name] = np.array(projection, np.float64) @ back
        sizes = {name: edl.camera(name).size for name in projections}
        relief = ReliefMap.of(pose.relief, edl.size)
        found = {name: rays_of(name, projections, sizes, relief) for name in projections}
        return {name: rays for name, rays in found.items() if rays is not None}

    def _live(self, laid_by: int, camera: str, frame: int, now: int) -> Cells | None:
        def make() -> Cells | None:
            self._warper.own_picture(camera, now)  # opens it, and lets go of what was shown
            planes = self._pictures.look(camera, frame)
            return None if planes is None else self._in_cells(laid_by, camera, planes, (frame,))

        return self._cells.get((camera, frame), make)

    def _behind(self, pose_index: int, frame: int) -> Mapping[str, Background]:
        """The backgrounds of a pose about a frame, which lies in it or beside it."""
        still = self._warper.still[pose_index]
        step = grid_step(still, float(self._warper.edl.rate))
        frames = grid_frames(still, step, frame // step)
        return self._backgrounds.get((pose_index, frames), lambda: self._make_backgrounds(pose_index, frames))

    def _make_backgrounds(self, pose_index: int, frames: tuple[int, ...]) -> Mapping[str, Background]:
        medians = {}
        for name in self._rays_of_pose(pose_index):
            planes = self._warper.median(name, frames)
            if planes is not None:
                medians[name] = self._in_cells(pose_index, name, planes, frames)
        return backgrounds(medians, self._rays_of_pose(pose_index))

    def _behind_moving(
        self, frame: int, live: Mapping[str, Cells], rays: Mapping[str, Rays]
    ) -> Mapping[str, Background]:
        """The backgrounds of a frame in which the lamp moves, from those of the poses beside the movement."""
        edl = self._warper.edl
        movement = followed_movement(edl, frame)
        assert movement is not None
        perspective = poses_beside(edl, movement)[0].perspective
        beside = {self._warper.standing_at(at) for at in (max(0, movement.middle - 1), movement.middle)}
        laid = []
        for pose_index in sorted(beside):
            pose = edl.poses[pose_index]
            if pose.relief is None or pose.perspective != perspective:
                continue
            for name, background in self._behind(pose_index, frame).items():
                laid.append(_Laid.of(name, background, self._rays_of_pose(pose_index)[name]))
        return {name: _along(name, laid, rays[name], cells) for name, cells in live.items()}

    def _in_cells(self, laid_by: int, camera: str, planes: Planes, frames: tuple[int, ...]) -> Cells:
        """Means by cell, in the reference camera's colours."""
        size = grid_size(planes.size)
        means = [cv2.resize(plane, size, interpolation=cv2.INTER_AREA).astype(np.float32) for plane in planes]
        cells = np.stack(means, axis=-1)
        match = colour_at(self._warper.pose(laid_by), camera, frames)
        return cells if match is None else _matched(cells, match)


def _joined(pieces: Iterator[tuple[FrameRange, int]]) -> Iterator[FrameRange]:
    """Pieces in order, those as one that meet in one perspective."""
    last: tuple[FrameRange, int] | None = None
    for piece, perspective in pieces:
        if last is not None and last[1] == perspective and last[0].stop >= piece.start:
            last = FrameRange(last[0].start, max(last[0].stop, piece.stop)), perspective
            continue
        if last is not None:
            yield last[0]
        last = piece, perspective
    if last is not None:
        yield last[0]


@frozen(eq=False)
class _Laid:
    """A camera's background, by cell of the programme; ``inside`` its picture 1, else 0."""

    camera: str
    inside: Cells
    shown: Cells
    verified: Cells
    bare: Cells

    @classmethod
    def of(cls, camera: str, background: Background, rays: Rays) -> _Laid:
        """As it lies in its pose."""
        inside = np.ones_like(background.verified)
        parts = (inside, background.shown, background.verified, background.bare)
        return cls(camera, *(taken(cells, rays.own) for cells in parts))


def _along(camera: str, laid: Sequence[_Laid], rays: Rays, live: Cells) -> Background:
    """What a camera would show where nobody is in its way, by what all show of it from where the lamp stands.

    Where none has shown anything it is what the camera shows now: nothing tells that somebody is there.
    """
    total, shown = np.full(rays.own.shape, 1e-9, np.float32), np.zeros((*rays.own.shape, 3), np.float32)
    verified, bare = np.zeros_like(total), np.zeros_like(total)
    for each in laid:
        weight = each.inside * (_UNSURE + each.verified**2) * (_OWN if each.camera == camera else 1.0)
        total, shown = total + weight, shown + weight[..., None] * each.shown
        verified, bare = np.maximum(verified, each.verified), np.maximum(bare, each.bare)
    known = taken((total > _UNSURE / 2).astype(np.float32), rays.programme) > 0
    there = taken((shown / total[..., None]).astype(np.float32), rays.programme)
    own = np.where(known[..., None], there, live).astype(np.float32)
    return Background(
        own, taken(verified, rays.programme), taken(bare, rays.programme), np.zeros(own.shape[:2], np.float32), own
    )


def _matched(cells: Cells, colour: Colour) -> Cells:
    matrix = np.array(colour.matrix, np.float32)
    return cells @ matrix[:, :3].T + matrix[:, 3]
