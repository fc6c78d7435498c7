"""What is left out of what is delivered: the part of `Programme` that is about it."""

from __future__ import annotations

from mcsl_core.edl import removal
from mcsl_core.errors import Fault, UsageError
from mcsl_core.timing import FrameRange

from .views import Document


class Removal:
    """What a `Programme` says and decides about frames that are left out."""

    def remove(self: Document, frames: FrameRange | tuple[int, int]) -> None:
        """Leaves a range out of renders. `save` writes it.

        Parameters
        ----------
        frames : FrameRange or (int, int)
            First frame, and the first one after it, of the whole programme.

        Raises
        ------
        UsageError
            Where nothing would be left, or the range is not inside the programme.

        Examples
        --------
        >>> p.remove((900, 1100))
        >>> p.save()
        """
        piece = self._views.piece_of(frames)
        try:
            self.edl = removal.remove(self.edl, piece)
        except Fault as fault:
            raise UsageError(fault.what, where=self._views.where, remedy="Leave some of the programme") from None

    def bring_back(self: Document, frames: FrameRange | tuple[int, int] | None = None) -> None:
        """Delivers what was removed of a range, or everything, again."""
        self.edl = removal.bring_back(self.edl, None if frames is None else self._views.piece_of(frames))

    @property
    def delivered(self: Document) -> tuple[FrameRange, ...]:
        """The ranges of frames that a render has, in order."""
        return removal.delivered(self.edl)
