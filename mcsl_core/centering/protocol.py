"""What a centerer is given and gives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from attrs import frozen

from mcsl_core.edl import CenteringKey
from mcsl_core.timing import FrameRange


@frozen(eq=False)
class FieldPosition:
    """Where the field lies over a range of the programme, a pose as a rule.

    Attributes
    ----------
    range : FrameRange
        Programme frames.
    middle : (float, float) or None
        (x, y) of its middle in programme pixels without centering; None where it is not known.
    """

    range: FrameRange
    middle: tuple[float, float] | None


class Centerer(Protocol):
    """Shifts the programme so that what matters is in the middle."""

    @property
    def name(self) -> str: ...

    def centre(
        self, positions: Sequence[FieldPosition], *, size: tuple[int, int], rate: float
    ) -> Sequence[CenteringKey]:
        """Chooses the keys of the shift.

        Parameters
        ----------
        positions : sequence of FieldPosition
            Where the field lies; their ranges tile the programme.
        size : (int, int)
            Width and height of the programme.
        rate : float
            Programme frames per second.

        Returns
        -------
        sequence of (int, float, float)
            (frame, dx, dy) with rising frames of the programme, in programme pixels; linear between keys. A pixel that
            lies at p without centering is shown at p + (dx, dy). Empty where nothing is to be shifted.
        """
        ...
