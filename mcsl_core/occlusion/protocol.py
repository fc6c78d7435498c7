"""What an occlusion detector is given and gives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from mcsl_core.alignment.aligned_views import AlignedPose, AlignedView


class OcclusionScorer(Protocol):
    """Scores the moments of one stretch, in any order."""

    def score(self, views: Sequence[AlignedView]) -> Mapping[str, float]:
        """camera -> visible share of the surgical field, 0 (hidden) to 1 (clear), for every view handed in."""
        ...


class OcclusionDetector(Protocol):
    """Says how much of the surgical field each camera sees."""

    @property
    def name(self) -> str: ...

    def scorer(self, scene: AlignedPose, moments: Sequence[Sequence[AlignedView]]) -> OcclusionScorer:
        """A scorer for a stretch of a pose, a few minutes at most.

        moments: the views of its samples in order of time, about one a second; each access reads them anew. The scorer
        is then asked about these moments, and about others of the stretch with only some of the cameras.
        """
        ...
