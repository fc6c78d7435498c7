"""The paper's kind of occlusion score: the field's area by its hue."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from attrs import frozen

from mcsl_core.alignment.aligned_views import AlignedPose, AlignedView
from mcsl_core.imaging.masks import Mask, hue_mask


@frozen
class HueArea:
    """The paper's kind of score: the share of the field's pixels that have the field's hue in that view.

    Blind to what has the field's own colour (a bare hand, a face); see `consensus` for the one that is not.
    """

    name = "hue-area"

    def scorer(self, scene: AlignedPose, moments: Sequence[Sequence[AlignedView]]) -> HueScorer:
        """A scorer for a pose; ``moments`` are not needed."""
        return HueScorer(scene.field)


@frozen(eq=False)
class HueScorer:
    """Scores the moments of one pose."""

    field: Mask

    def score(self, views: Sequence[AlignedView]) -> Mapping[str, float]:
        """camera -> visible share of the field, 0..1."""
        area = max(int(self.field.sum()), 1)
        return {
            view.camera: float(np.count_nonzero((hue_mask(view.aligned) > 0) & self.field & view.inside)) / area
            for view in views
        }
