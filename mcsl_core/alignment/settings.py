"""What a pose is solved by: sizes, weights and thresholds, each with the measurement it was chosen by."""

from __future__ import annotations

from attrs import field, frozen

from .clear_frames import ClearFrames
from .dense_matching import DenseSettings
from .joint import AlignmentSettings


@frozen
class SolveSettings:
    """scene_width: columns of a scene. dense_width: of the scene in which spots are compared; typical_width: of the
    typical picture. dense_moments, typical_moments: how many moments each looks at.

    drape_weight: how much a match outside the field counts against one inside: the drapes' area is ten times the
    field's and lies centimetres below it. With 0.1 the error over the field was 1.10 to 1.43 times the best plane's on
    a tuning recording, with 0.01 it was 1.05 to 1.29; with none a field without texture would not be tied at all.
    least_shown: share of the new field that an old perspective must show to be kept.
    """

    scene_width: int = field(default=480)
    dense_width: int = field(default=640)
    typical_width: int = field(default=240)
    dense_moments: int = field(default=24)
    typical_moments: int = field(default=40)
    drape_weight: float = field(default=0.01)
    least_shown: float = field(default=0.5)
    clear: ClearFrames = field(factory=ClearFrames)
    dense: DenseSettings = field(factory=DenseSettings)
    alignment: AlignmentSettings = field(factory=AlignmentSettings)
