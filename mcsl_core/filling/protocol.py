"""What a filler gets of one programme frame, and what it must be able to do."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mcsl_core.imaging.planes import U8, Planes
from mcsl_core.imaging.rect import Rect
from mcsl_core.timing import FrameRange

CELL = 16  # programme pixels: of the grid on which it is looked for who moves


class FillContext(Protocol):
    """One programme frame before filling, and the means to look at every camera at any moment through the same eye."""

    @property
    def frame(self) -> int: ...

    @property
    def rate(self) -> float:
        """Programme frames per second."""
        ...

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) of the programme."""
        ...

    @property
    def camera(self) -> str:
        """The chosen camera."""
        ...

    @property
    def front(self) -> Planes:
        """The chosen camera's picture, warped and coloured; black where it does not reach."""
        ...

    @property
    def others(self) -> Sequence[str]:
        """Cameras that may stand in; the reference camera leads, then by closeness of viewpoint to the chosen one."""
        ...

    @property
    def still(self) -> FrameRange:
        """The stretch of this frame's pose in which the lamp stands still: a look at its median_of lies right."""
        ...

    @property
    def elsewhere(self) -> Sequence[FrameRange]:
        """The same of the other poses of this perspective: earlier ones, the latest first, then later ones."""
        ...

    @property
    def geometry(self) -> Hashable:
        """Equal values mean equal footprints: what is worked out from them may be kept."""
        ...

    @property
    def previous(self) -> Planes | None:
        """The finished programme frame before this one, where the filler asked for a memory."""
        ...

    def footprint(self, camera: str, frame: int | None = None, *, parallax_corrected: bool = False) -> U8:
        """(height / 2, width / 2): 255 where that camera sees the programme, less at its very edge.

        On the grid of the chroma samples. frame: in the pose of that frame, in place of this one's; nothing where the
        camera's place is not known. parallax_corrected: where `look` shows it so.
        """
        ...

    def change(self, camera: str, median_of: Sequence[int]) -> NDArray[np.float32]:
        """(ceil(height / 16), ceil(width / 16)): by how many codes what that camera has now is not the median of
        ``median_of``, where each cell of `CELL` x `CELL` programme pixels lies; 0 where it does not look.

        Whoever moves there, and what they cast their shadow on.
        """
        ...

    def picture(
        self,
        camera: str,
        rect: Rect,
        median_of: Sequence[int] = (),
        blur_px: float = 0.0,
        *,
        parallax_corrected: bool = False,
    ) -> Planes | None:
        """What that camera has in ``rect``, warped and coloured; None where it has no picture or no known place.

        median_of: the median of its pictures at these frames of one pose, in place of its picture now. Each costs a
        seek and a decode when it is first asked for, so keep to few: those of a fixed grid, so that a frame comes out
        the same in whatever stretch it is made. blur_px: sigma of a Gaussian over it. parallax_corrected: so that what
        does not lie on the plane of the field is where the perspective's first picture has it, not only warped; the
        chosen camera's only towards its edge, so that its picture goes over into the others'.
        """
        ...


class Filler(Protocol):
    """Fills what the chosen camera leaves empty. May keep what depends on geometry alone, nothing else."""

    @property
    def name(self) -> str: ...

    @property
    def version(self) -> int:
        """Rises when the same frames come out differently: conformed chunks are then made again."""
        ...

    @property
    def remembers(self) -> bool:
        """Whether `View.previous` is wanted; it begins anew every ten seconds, from 1, 2, 4, 8 ... frames before."""
        ...

    def fill(self, context: FillContext) -> Planes:
        """The finished frame; ``context.front`` itself where there is nothing to fill."""
        ...
