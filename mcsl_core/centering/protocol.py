"""What a centerer is given and gives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from attrs import frozen

from mcsl_core.edl import CenteringKey
from mcsl_core.timing import FrameRange


@frozen(eq=False)
class FieldPlace:
    """Where the field lies over a stretch, a pose as a rule: (x, y) of its middle in programme pixels, or None."""

    range: FrameRange
    middle: tuple[float, float] | None


class Centerer(Protocol):
    """Shifts the programme so that what matters is in the middle."""

    @property
    def name(self) -> str: ...

    def centre(self, places: Sequence[FieldPlace], *, size: tuple[int, int], rate: float) -> Sequence[CenteringKey]:
        """(frame, dx, dy) with rising frames, in programme pixels; ``size`` is the programme's (width, height)."""
        ...
