"""What a selector is given and gives."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Protocol

from mcsl_core.edl import Shot
from mcsl_core.occlusion.score_table import ScoreTable


class Selector(Protocol):
    """Chooses the camera of every moment."""

    @property
    def name(self) -> str: ...

    def select(self, table: ScoreTable, *, frames: int, rate: Fraction) -> Sequence[Shot]:
        """Shots that tile [0, frames) without gap or overlap; ``rate`` in frames per second."""
        ...
