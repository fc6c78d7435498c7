"""Where the surgical field lies in a programme, and drawn by hand: the part of `Programme` that is about it."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mcsl_core.edl.edits import clear_field, draw_field
from mcsl_core.edl.field import Polygon, field_at
from mcsl_core.errors import Fault, UsageError
from mcsl_core.imaging.masks import polygon_mask
from mcsl_core.timing import FrameRange

from .views import Document


class Fields:
    """What a `Programme` says and decides about the surgical field."""

    def set_field(
        self: Document,
        polygons: ArrayLike | Iterable[ArrayLike],
        frames: FrameRange | tuple[int, int] | None = None,
        note: str = "",
    ) -> None:
        """Draws the surgical field by hand, in place of what was found or drawn there. `save` writes it.

        Parameters
        ----------
        polygons : (N, 2) array-like, or several of them
            Corners (x, y) in programme pixels before centering; in the first perspective those are the reference
            camera's own. What lies in any of several is the field.
        frames : FrameRange or (int, int), optional
            First frame, and the first one after it; the whole programme without.
        note : str
            A remark.

        Raises
        ------
        UsageError
            Where one is no polygon or lies outside of the picture, or the range is not inside the programme.

        Notes
        -----
        The next `analyse` into the same EDL aligns, scores and centres by it, and keeps it.

        Examples
        --------
        >>> p.set_field([[412, 310], [900, 290], [880, 720]])
        >>> p.save()
        """
        piece = None if frames is None else self._views.piece_of(frames)
        try:
            self.edl = draw_field(self.edl, _polygons(polygons), piece, note)
        except (Fault, TypeError, ValueError) as error:
            remedy = "Give corners as [[x, y], [x, y], [x, y]], or a list of such"
            raise UsageError(f"this is no field: {error}"[:300], where=self._views.where, remedy=remedy) from None

    def clear_field(self: Document, frames: FrameRange | tuple[int, int] | None = None) -> None:
        """Takes away what is drawn over a range, or everywhere: the next `analyse` finds the field itself again."""
        self.edl = clear_field(self.edl, None if frames is None else self._views.piece_of(frames))

    def field_mask(self: Document, frame: int) -> NDArray[np.bool_] | None:
        """Where the surgical field lies at a frame: (height, width) bool in programme pixels before centering.

        Drawn by hand, else as the analysis took it; None where the EDL does not tell. ``edl.fields`` says where nothing
        showed it and the middle of the picture was taken.
        """
        at = self._views.check_frame(frame)
        stretch = field_at(self.edl, at)
        return None if stretch is None else polygon_mask([np.array(p) for p in stretch.polygons], self.edl.size)


def _polygons(given: ArrayLike | Iterable[ArrayLike]) -> tuple[Polygon, ...]:
    """One polygon or several, as the EDL has them."""
    listed = list(given)  # pyright: ignore[reportArgumentType]
    several = bool(listed) and np.ndim(listed[0]) == 2
    arrays = [np.asarray(each, np.float64) for each in (listed if several else [listed])]
    for array in arrays:
        if array.ndim != 2 or array.shape[1] != 2:
            raise ValueError(f"a polygon is (N, 2), got an array of shape {array.shape}")
    return tuple(tuple((float(x), float(y)) for x, y in array) for array in arrays)
