"""What an occlusion detector is given and gives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from mcsl_core.alignment.aligned_views import AlignedPose, AlignedView


class OcclusionScorer(Protocol):
    """Scores the views of one scoring segment, in any order."""

    def score(self, views: Sequence[AlignedView]) -> Mapping[str, float]:
        """Scores the views of one frame.

        Parameters
        ----------
        views : sequence of AlignedView
            What the cameras show at one frame of the segment; not all of them need be there.

        Returns
        -------
        mapping of str to float
            Camera -> visible share of the surgical field, 0 (hidden) to 1 (clear), for every view handed in.
        """
        ...


class OcclusionDetector(Protocol):
    """Says how much of the surgical field each camera sees."""

    @property
    def name(self) -> str: ...

    def scorer(self, aligned: AlignedPose, samples: Sequence[Sequence[AlignedView]]) -> OcclusionScorer:
        """Makes a scorer for a segment of a pose, a few minutes at most.

        Parameters
        ----------
        aligned : AlignedPose
            The pose, and where its surgical field lies.
        samples : sequence of sequence of AlignedView
            The views of the segment's samples in order of time, about one a second; each access reads them anew. May
            be empty.

        Returns
        -------
        OcclusionScorer
            It is asked about these samples, and about other frames of the segment with only some of the cameras.
        """
        ...
