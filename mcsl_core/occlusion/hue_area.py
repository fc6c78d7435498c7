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

    Notes
    -----
    Blind to what has the field's own colour (a bare hand, a face); see `consensus` for the one that is not.

    References
    ----------
    The paper's section "Occlusion-Free Frame Detection": S_t, the area of the surgical field, told by its hue.
    """

    name = "hue-area"

    def scorer(self, aligned: AlignedPose, samples: Sequence[Sequence[AlignedView]]) -> HueScorer:
        """Makes a scorer for a pose; see `OcclusionDetector.scorer`. ``samples`` are not needed."""
        return HueScorer(aligned.field)


@frozen(eq=False)
class HueScorer:
    """Scores the views of one pose.

    Attributes
    ----------
    field : (H, W) bool array
        The surgical field in aligned pixels.
    """

    field: Mask

    def score(self, views: Sequence[AlignedView]) -> Mapping[str, float]:
        """Scores the views of one frame; see `OcclusionScorer.score`."""
        area = max(int(self.field.sum()), 1)
        return {
            view.camera: float(np.count_nonzero((hue_mask(view.aligned) > 0) & self.field & view.inside)) / area
            for view in views
        }
