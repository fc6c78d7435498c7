"""The provenance of each pixel: pictures are tinted before they are blended, so that borders show as they are."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.imaging.planes import U8, Planes, bgr_to_planes
from mcsl_core.imaging.rect import Rect
from mcsl_core.timing import FrameRange

from .protocol import FillContext, Filler

# (Cb, Cr) far from grey and from each other; a sixth camera begins again.
TINTS = ((90, 170), (170, 95), (75, 95), (185, 165), (128, 200), (60, 128))
_SHARE = 0.6  # of the tint in the chroma
_DIMMED = 0.7  # of the luma, of medians


class ShowProvenance:
    """A filler's work with each camera's pixels tinted, medians and other poses darker, and a legend.

    Parameters
    ----------
    filler : Filler
        Whose work is shown.
    cameras : sequence of str
        The EDL's cameras in order: the n-th has the n-th of `TINTS`.
    """

    def __init__(self, filler: Filler, cameras: Sequence[str]) -> None:
        self.filler, self.cameras = filler, tuple(cameras)
        self.name, self.version, self.remembers = f"{filler.name}-origin", filler.version, filler.remembers
        self._legend: Planes | None = None

    def fill(self, context: FillContext) -> Planes:
        """Fill one programme frame, tinted, with the legend; see `Filler`."""
        return self.with_legend(self.filler.fill(self.tinted(context)))

    def unfilled(self, context: FillContext) -> Planes:
        """The chosen camera's picture alone, tinted, with the legend: of a frame that is not filled."""
        return self.with_legend(self.tinted(context).front)

    def tinted(self, context: FillContext) -> FillContext:
        """The same frame, each camera's pictures tinted."""
        return _TintedContext(context, self.cameras)

    def with_legend(self, planes: Planes) -> Planes:
        """A finished frame with the legend over it."""
        if self._legend is None:
            self._legend = _legend(self.cameras, planes.size)
        out = Planes(*(plane.copy() for plane in planes))
        width, height = self._legend.size
        if width <= out.size[0] and height <= out.size[1]:
            for plane, legend in zip(Rect(0, 0, width, height).of(out), self._legend, strict=True):
                plane[:] = legend
        return out


@frozen(eq=False)
class _TintedContext:
    """A context whose pictures are tinted by camera."""

    context: FillContext
    cameras: tuple[str, ...]

    @property
    def front(self) -> Planes:
        return self._tint(self.context.camera, self.context.front)

    def picture(
        self,
        camera: str,
        rect: Rect,
        median_of: Sequence[int] = (),
        blur_px: float = 0.0,
        *,
        parallax_corrected: bool = False,
    ) -> Planes | None:
        planes = self.context.picture(camera, rect, median_of, blur_px, parallax_corrected=parallax_corrected)
        return None if planes is None else self._tint(camera, planes, bool(median_of))

    def footprint(self, camera: str, frame: int | None = None, *, parallax_corrected: bool = False) -> U8:
        return self.context.footprint(camera, frame, parallax_corrected=parallax_corrected)

    def change(self, camera: str, median_of: Sequence[int]) -> NDArray[np.float32]:
        return self.context.change(camera, median_of)

    def _tint(self, camera: str, planes: Planes, darker: bool = False) -> Planes:
        half = planes.u.shape[::-1]
        luma = cv2.resize(planes.y, half, interpolation=cv2.INTER_AREA).astype(np.float32)
        share = _SHARE * np.clip((luma - 16) / 16, 0, 1)  # what is black comes from no camera
        tint = TINTS[self.cameras.index(camera) % len(TINTS)]
        y = planes.y
        if darker:
            y = np.asarray(cv2.addWeighted(y, _DIMMED, y, 0, 16 * (1 - _DIMMED)), np.uint8)
        return Planes(y, _towards(planes.u, tint[0], share), _towards(planes.v, tint[1], share))

    @property
    def frame(self) -> int:
        return self.context.frame

    @property
    def rate(self) -> float:
        return self.context.rate

    @property
    def size(self) -> tuple[int, int]:
        return self.context.size

    @property
    def camera(self) -> str:
        return self.context.camera

    @property
    def others(self) -> Sequence[str]:
        return self.context.others

    @property
    def followed(self) -> bool:
        return self.context.followed

    @property
    def still(self) -> FrameRange:
        return self.context.still

    @property
    def elsewhere(self) -> Sequence[FrameRange]:
        return self.context.elsewhere

    @property
    def geometry(self) -> Hashable:
        return self.context.geometry

    @property
    def previous(self) -> Planes | None:
        return self.context.previous


def _towards(plane: U8, tint: int, share: NDArray[np.floating]) -> U8:
    return np.round(plane + share * (tint - plane.astype(np.float32))).astype(np.uint8)


def _legend(cameras: Sequence[str], size: tuple[int, int]) -> Planes:
    """A line for each camera in its tint; OpenCV writes ASCII, other letters become question marks."""
    scale = max(size[1] / 1080, 0.4)
    line, width = round(44 * scale / 2) * 2, round(300 * scale / 2) * 2
    picture = np.zeros((line * (len(cameras) + 1), width, 3), np.uint8)
    names = [*cameras, "darker: not now"]
    for index, name in enumerate(names):
        text = name.encode("ascii", "replace").decode()
        base = (round(52 * scale), round(line * (index + 0.7)))
        cv2.putText(
            picture, text, base, cv2.FONT_HERSHEY_SIMPLEX, scale, (235, 235, 235), max(1, round(2 * scale)), cv2.LINE_AA
        )
    planes = bgr_to_planes(picture)
    for index in range(len(cameras)):
        rows = slice(index * line + line // 4 // 2 * 2, (index + 1) * line - line // 4 // 2 * 2)
        columns = slice(0, round(40 * scale / 2) * 2)
        half = (slice(rows.start // 2, rows.stop // 2), slice(0, columns.stop // 2))
        planes.y[rows, columns] = 140
        for plane, tint in zip((planes.u, planes.v), TINTS[index % len(TINTS)], strict=True):
            plane[half] = tint
    return planes
