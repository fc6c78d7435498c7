"""A detector for tests of what is made of scores."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs

from mcsl_core.alignment.aligned_views import AlignedPose, AlignedView


@attrs.frozen
class Brightness:
    """A detector of occlusion: the field is visible as far as the picture is bright."""

    name = "brightness"

    def scorer(self, aligned: AlignedPose, samples: Sequence[Sequence[AlignedView]]) -> Brightness:
        return self

    def score(self, views: Sequence[AlignedView]) -> Mapping[str, float]:
        return {v.camera: float(v.aligned.mean()) / 255 for v in views}
