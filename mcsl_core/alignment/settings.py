"""What a pose is solved by: sizes, weights and thresholds, each with the measurement it was chosen by."""

from __future__ import annotations

from attrs import field, frozen

from .clear_frames import ClearFrames
from .dense_matching import DenseSettings
from .joint import AlignmentSettings


@frozen
class SolveSettings:
    """How a pose is solved.

    Attributes
    ----------
    scene_width : int
        Columns of the aligned pictures that the detectors get.
    dense_width : int
        Columns of the aligned pictures that are matched densely.
    typical_width : int
        Columns of the modal picture, which shows where the field lies.
    dense_moments : int
        How many samples the steady views are made of, which are matched densely.
    typical_moments : int
        How many samples the modal picture is made of.
    drape_weight : float
        How much a match outside the field counts against one inside, 0..1: the drapes' area is ten times the field's
        and lies centimetres below it. With 0.1 the error over the field was 1.10 to 1.43 times the best plane's on a
        tuning recording, with 0.01 it was 1.05 to 1.29; with none a field without texture would not be tied at all.
    aim : float
        How widely matches count about the middle of the pictures, where all cameras aim: standard deviation in widths.
        Drapes, straps and hands that rest are in the skin's hue too, but farther out.
    least_covered : float
        Share of the field that the dense matches of two cameras cover at least, 0..1; fewer are a head, or chance.
    least_shown : float
        Share of the new field that an old perspective must show to be kept, 0..1.
    clear : ClearFrames
        Which samples points are matched in.
    dense : DenseSettings
        Of dense matching.
    alignment : AlignmentSettings
        Of the fits of camera pairs.

    Notes
    -----
    The EDL keeps all of these under their names: no field is renamed.
    """

    scene_width: int = field(default=480)
    dense_width: int = field(default=640)
    typical_width: int = field(default=240)
    dense_moments: int = field(default=24)
    typical_moments: int = field(default=40)
    drape_weight: float = field(default=0.01)
    aim: float = field(default=0.15)
    least_covered: float = field(default=0.25)
    least_shown: float = field(default=0.5)
    clear: ClearFrames = field(factory=ClearFrames)
    dense: DenseSettings = field(factory=DenseSettings)
    alignment: AlignmentSettings = field(factory=AlignmentSettings)
