"""One programme frame as a filler gets it; other cameras' pictures cost something only when they are asked for."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from functools import cached_property

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.alignment.colour_match import apply_colour, colour_at
from mcsl_core.edl.placement import other_poses
from mcsl_core.imaging.planes import U8, Planes, black, blurred
from mcsl_core.imaging.rect import Rect
from mcsl_core.timing import FrameRange

from .camera_warper import CameraWarper, Laid, Offset

_GRID = 4.0  # while the centering moves, footprints are worked out anew every so many pixels


@frozen(eq=False)
class FrameContext:
    """The compositor's `FillContext`; what its members mean stands there.

    Attributes
    ----------
    warper : CameraWarper
        Warps the cameras' pictures.
    frame : int
        The programme frame.
    camera : str
        The chosen camera.
    pose_index : int
        Index of the pose in the EDL whose range the frame lies in.
    offset : (float, float)
        The centering's, in programme pixels.
    colour : bool
        Whether the cameras' colours are matched.
    surface : bool
        Whether they are laid by the pose's relief, where it has one.
    steady : bool
        Whether the centering stands still, so that the same warp will be asked for again.
    previous : Planes, optional
        The finished programme frame before.
    """

    warper: CameraWarper
    frame: int
    camera: str
    pose_index: int
    offset: Offset
    colour: bool
    surface: bool
    steady: bool
    previous: Planes | None = None

    @property
    def front(self) -> Planes:
        return self._front

    @cached_property
    def _front(self) -> Planes:
        planes = self.picture(self.camera, Rect(0, 0, *self.size))
        return black(self.size) if planes is None else planes

    @property
    def rate(self) -> float:
        return float(self.warper.edl.rate)

    @property
    def size(self) -> tuple[int, int]:
        return self.warper.edl.size

    @property
    def laid_by(self) -> int:
        """Index of the pose that lays this frame's pictures: while the lamp is followed another in every frame."""
        return self.warper.pose_at(self.frame)

    @property
    def others(self) -> Sequence[str]:
        return self.warper.others(self.laid_by, self.camera)

    @property
    def followed(self) -> bool:
        return self.laid_by != self.pose_index

    @property
    def still(self) -> FrameRange:
        return self.warper.still[self.pose_index]

    @property
    def elsewhere(self) -> Sequence[FrameRange]:
        others = other_poses(self.warper.edl, self.pose_index)
        return [self.warper.still[i] for i in ((self.pose_index, *others) if self.followed else others)]

    @property
    def geometry(self) -> Hashable:
        return self.warper.geometry, self.laid_by, self.camera, self.surface, self.steady, *self._footprint_offset()

    def change(self, camera: str, median_of: Sequence[int]) -> NDArray[np.float32]:
        laid = self._laid(self.laid_by, camera, False)
        return self.warper.change(self.laid_by, camera, self.offset, self.frame, tuple(median_of), laid=laid)

    def footprint(self, camera: str, frame: int | None = None, *, parallax_corrected: bool = False) -> U8:
        pose_index = self.laid_by if frame is None else self.warper.standing_at(frame)
        laid = self._laid(pose_index, camera, parallax_corrected)
        mask = self.warper.footprint(pose_index, camera, self._footprint_offset(), laid)
        if not self.steady:  # shared by offsets up to half the grid away: inside for all of them
            mask = cv2.erode(mask, np.ones((3, 3), np.uint8), borderType=cv2.BORDER_REPLICATE)
        return mask  # pyright: ignore[reportReturnType]

    def picture(
        self,
        camera: str,
        rect: Rect,
        median_of: Sequence[int] = (),
        blur_px: float = 0.0,
        *,
        parallax_corrected: bool = False,
    ) -> Planes | None:
        if not median_of:
            planes = self.warper.own_picture(camera, self.frame)
            return self._warped(camera, rect, planes, (self.frame,), blur_px, parallax_corrected)

        def make() -> Planes | None:
            pose_index = self.warper.standing_at(median_of[0])  # what is still, though the lamp is followed near it
            planes = self.warper.median(camera, median_of) if self.warper.is_placed(pose_index, camera) else None
            return self._warped(camera, rect, planes, median_of, blur_px, parallax_corrected)

        if not self.steady:
            return make()
        key = camera, rect, tuple(median_of), blur_px, parallax_corrected, self.offset, self.colour, self.surface
        return self.warper.patches.get(key, make)

    def _footprint_offset(self) -> Offset:
        if self.steady:
            return self.offset
        return round(self.offset[0] / _GRID) * _GRID, round(self.offset[1] / _GRID) * _GRID

    def _laid(self, pose_index: int, camera: str, parallax_corrected: bool) -> Laid:
        """By the relief, which is the parallax; else the chosen camera's is taken out towards its edge alone."""
        if self.surface and self.warper.has_relief(pose_index, camera):
            return "surface"
        if not parallax_corrected:
            return "plane"
        return "edge" if (pose_index, camera) == (self.laid_by, self.camera) else "parallax"

    def _warped(
        self,
        camera: str,
        rect: Rect,
        planes: Planes | None,
        frames: Sequence[int],
        blur_px: float,
        parallax_corrected: bool,
    ) -> Planes | None:
        """``planes``, of one frame or the median of several of one pose, warped and coloured."""
        if planes is None:
            return None
        live = len(frames) == 1 and frames[0] == self.frame
        pose_index = self.laid_by if live else self.warper.standing_at(frames[0])
        border = 2 * round(1.5 * blur_px)
        wide = rect.grown(border)
        laid = self._laid(pose_index, camera, parallax_corrected)
        planes = self.warper.warped(planes, pose_index, camera, self.offset, wide, laid=laid, again=self.steady)
        match = colour_at(self.warper.pose(pose_index), camera, frames) if self.colour else None
        planes = planes if match is None else apply_colour(planes, match)
        return Rect(border, border, rect.width, rect.height).of(blurred(planes, blur_px)) if blur_px else planes
