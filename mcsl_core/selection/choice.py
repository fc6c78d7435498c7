"""A recording's programme by any table of its scores: what a selector chooses, told of merits and gaps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.edl import Camera, Shot
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.timing import FrameRange

from .gaps import with_ragged_edges, without_gaps
from .merits import with_merits
from .protocol import Selector


@frozen(eq=False)
class Choice:
    """Who chooses, and what is known beside scores.

    Attributes
    ----------
    selector : Selector
        Who chooses.
    poses : sequence of FrameRange
        They tile the programme.
    merits : mapping of str to (P, C) array
        Of them; see `pose_merits`.
    cameras : sequence of Camera
        With their gaps.
    spans : mapping of str to (float, float)
        See `with_ragged_edges`.
    frames : int
        Length of the programme.
    rate : Fraction
        Programme frames per second.
    """

    selector: Selector
    poses: Sequence[FrameRange]
    merits: Mapping[str, NDArray]
    cameras: Sequence[Camera]
    spans: Mapping[str, tuple[float, float]]
    frames: int
    rate: Fraction

    def measured(self, table: ScoreTable) -> ScoreTable:
        """The table with the merits, and without gaps."""
        return without_gaps(with_merits(table, self.poses, self.merits), self.cameras, self.frames)

    def shots(self, table: ScoreTable) -> Sequence[Shot]:
        """What the selector chooses by a table of scores alone."""
        told = with_ragged_edges(self.measured(table), self.spans, self.frames, self.rate)
        return self.selector.select(told, frames=self.frames, rate=self.rate)
