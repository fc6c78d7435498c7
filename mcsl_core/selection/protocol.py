"""What a selector is given and gives, and the minimum shot length that selection and refinement share."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import ceil
from typing import Protocol

from mcsl_core.edl import Shot
from mcsl_core.occlusion.score_table import ScoreTable

MIN_SHOT_S = 2.0  # of `ShortestPath`, and what the refinement keeps for a selector that promises nothing


class Selector(Protocol):
    """Chooses the camera that the programme shows at every frame.

    Notes
    -----
    It is asked again with more samples where it was looked closer at what it chose; see `look_closer`. Equal tables
    must give equal shots.

    A selector may promise a minimum shot length by an attribute ``min_shot_s``: seconds, a float of 0 or more, known
    once `select` has been called. When the switches are moved to the very frame afterwards, no shot becomes shorter
    than that, or than the selector made it where that is less. Without the attribute the same holds for 2 seconds.
    """

    @property
    def name(self) -> str: ...

    def select(self, table: ScoreTable, *, frames: int, rate: Fraction) -> Sequence[Shot]:
        """Chooses the shots of a programme.

        Parameters
        ----------
        table : ScoreTable
            The visible field of every camera at every sample, and which cameras may be used there.
        frames : int
            Length of the programme.
        rate : Fraction
            Programme frames per second.

        Returns
        -------
        sequence of Shot
            Shots that tile [0, ``frames``) without gap or overlap, of cameras of ``table``.
        """
        ...


def least_frames(min_shot_s: float, rate: Fraction) -> int:
    """The fewest whole frames that last so long.

    Parameters
    ----------
    min_shot_s : float
        Minimum shot length in seconds, 0 or more.
    rate : Fraction
        Frames per second.

    Returns
    -------
    int
        1 or more. A length that is a whole number of frames but for rounding (a billionth) is that number.
    """
    return max(1, ceil(min_shot_s * float(rate) - 1e-9))
