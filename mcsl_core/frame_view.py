"""One programme frame as a filler sees it; looks at other cameras cost something only when they are asked for."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import cv2
import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from .colour import apply
from .eye import Eye, Offset
from .filling import Rect
from .images import U8, Planes, black, blurred
from .placement import elsewhere
from .timing import FrameRange

_GRID = 4.0  # while the centering moves, footprints are worked out anew every so many pixels


@frozen(eq=False)
class FrameView:
    """See `filling.View`."""

    eye: Eye
    frame: int
    camera: str
    number: int
    offset: Offset
    colour: bool
    steady: bool  # the centering stands still
    previous: Planes | None = field(default=None)
    _front: list[Planes] = field(factory=list, init=False)

    @property
    def front(self) -> Planes:
        if not self._front:
            planes = self.look(self.camera, Rect(0, 0, *self.size))
            self._front.append(black(self.size) if planes is None else planes)
        return self._front[0]

    @property
    def rate(self) -> float:
        return float(self.eye.edl.rate)

    @property
    def size(self) -> tuple[int, int]:
        return self.eye.edl.size

    @property
    def others(self) -> Sequence[str]:
        return self.eye.others(self.number, self.camera)

    @property
    def still(self) -> FrameRange:
        return self.eye.still[self.number]

    @property
    def elsewhere(self) -> Sequence[FrameRange]:
        return [self.eye.still[i] for i in elsewhere(self.eye.edl, self.number)]

    @property
    def geometry(self) -> Hashable:
        return self.eye.geometry, self.number, self.camera, self.steady, *self._about()

    def _about(self) -> Offset:
        if self.steady:
            return self.offset
        dx, dy = (round(v / _GRID) * _GRID for v in self.offset)
        return dx, dy

    def change(self, camera: str, moments: Sequence[int]) -> NDArray[np.float32]:
        return self.eye.change(self.number, camera, self.offset, self.frame, tuple(moments))

    def _is_front(self, number: int, camera: str) -> bool:
        return (number, camera) == (self.number, self.camera)

    def footprint(self, camera: str, frame: int | None = None, *, without_parallax: bool = False) -> U8:
        number = self.number if frame is None else self.eye.pose_number(frame)
        edge = self._is_front(number, camera)
        mask = self.eye.footprint(number, camera, self._about(), without_parallax=without_parallax, edge=edge)
        if not self.steady:  # shared by offsets up to half the grid away: seen by all of them
            mask = cv2.erode(mask, np.ones((3, 3), np.uint8), borderType=cv2.BORDER_REPLICATE)
        return mask  # pyright: ignore[reportReturnType]

    def look(
        self,
        camera: str,
        rect: Rect,
        moments: Sequence[int] = (),
        blur_px: float = 0.0,
        *,
        without_parallax: bool = False,
    ) -> Planes | None:
        if not moments:
            planes = self.eye.picture(camera, self.frame)
            return self._look(camera, rect, planes, self.number, blur_px, without_parallax)

        def make() -> Planes | None:
            number = self.eye.pose_number(moments[0])
            planes = self.eye.median(camera, moments) if self.eye.knows(number, camera) else None
            return self._look(camera, rect, planes, number, blur_px, without_parallax)

        if not self.steady:
            return make()
        key = camera, rect, tuple(moments), blur_px, without_parallax, self.offset, self.colour
        return self.eye.patches.of(key, make, lambda planes: planes.y.size * 3 // 2)

    def _look(
        self, camera: str, rect: Rect, planes: Planes | None, number: int, blur_px: float, without_parallax: bool
    ) -> Planes | None:
        if planes is None:
            return None
        edge = self._is_front(number, camera)
        border = 2 * round(1.5 * blur_px)
        wide = rect.grown(border)
        if without_parallax:
            planes = self.eye.straightened(planes, number, camera, self.offset, wide, edge=edge, again=self.steady)
        else:
            planes = self.eye.warped(planes, number, camera, self.offset, wide)
        match = self.eye.edl.poses[number].colour.get(camera) if self.colour else None
        planes = planes if match is None else apply(planes, match)
        return Rect(border, border, rect.width, rect.height).of(blurred(planes, blur_px)) if blur_px else planes
