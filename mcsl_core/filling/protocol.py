"""What a filler gets of one programme frame, and what it must be able to do."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mcsl_core.imaging.planes import U8, Planes
from mcsl_core.imaging.rect import Rect
from mcsl_core.timing import FrameRange

CELL = 16  # programme pixels: of the grid on which motion is measured


class FillContext(Protocol):
    """One programme frame before filling, and the means to read every camera at any frame, warped in the same way."""

    @property
    def frame(self) -> int:
        """The programme frame."""
        ...

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
        """The chosen camera's picture, warped and coloured; black outside it."""
        ...

    @property
    def others(self) -> Sequence[str]:
        """Cameras that may stand in; the reference camera leads, then by nearness of viewpoint to the chosen one."""
        ...

    @property
    def followed(self) -> bool:
        """Whether the lamp moves and is followed: pictures now then lie otherwise than medians, which stand among
        `elsewhere` alone.
        """
        ...

    @property
    def still(self) -> FrameRange:
        """The range of this frame's pose in which the lamp stands still: a picture from it lies right."""
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
        """Which programme pixels lie inside a camera's warped picture.

        Parameters
        ----------
        camera : str
            The camera's name.
        frame : int, optional
            In the pose of that programme frame, in place of this one's.
        parallax_corrected : bool
            Of the picture that `picture` gives with the same argument.

        Returns
        -------
        (height / 2, width / 2) uint8
            255 inside, less at the very edge, on the grid of the chroma samples; 0 all over where the camera's
            position is not known.
        """
        ...

    def change(self, camera: str, median_of: Sequence[int]) -> NDArray[np.float32]:
        """How much a camera's picture now differs from the median of others: who moves there, and their shadows.

        Parameters
        ----------
        camera : str
            The camera's name.
        median_of : sequence of int
            Programme frames of one pose, as in `picture`.

        Returns
        -------
        (ceil(height / 16), ceil(width / 16)) float32
            The difference in 8-bit codes in each cell of `CELL` x `CELL` programme pixels; 0 outside the picture.
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
        """What a camera shows in a rectangle of the programme, warped and coloured.

        Parameters
        ----------
        camera : str
            The camera's name.
        rect : Rect
            In programme pixels.
        median_of : sequence of int
            Programme frames of one pose whose median is taken, in place of the picture now. Each costs a seek and a
            decode when it is first asked for, so keep to few: those of a fixed grid, so that a frame comes out the same
            in whatever range it is made.
        blur_px : float
            Sigma of a Gaussian over the picture, in programme pixels.
        parallax_corrected : bool
            What does not lie on the plane of the field is moved to where the perspective's first picture has it; of
            the chosen camera only towards its edge, so that its picture goes over into the others'.

        Returns
        -------
        Planes or None
            A picture of the rectangle's size, black outside the camera's; None where the camera has no picture or no
            known position.
        """
        ...


class Filler(Protocol):
    """Fills the pixels outside the chosen camera's picture. May keep what depends on geometry alone, nothing else."""

    @property
    def name(self) -> str: ...

    @property
    def version(self) -> int:
        """Rises when the same frames come out differently: conformed chunks are then made again."""
        ...

    @property
    def remembers(self) -> bool:
        """Whether `FillContext.previous` is wanted; it begins anew every 10 s, from 1, 2, 4, 8 ... frames before."""
        ...

    def fill(self, context: FillContext) -> Planes:
        """Fill one programme frame.

        Parameters
        ----------
        context : FillContext
            The frame before filling. Its pictures cannot be written to.

        Returns
        -------
        Planes
            The finished frame, of the programme's size; ``context.front`` itself where there is nothing to fill.
        """
        ...
