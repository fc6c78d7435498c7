"""What the caller of an analysis may choose."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path

from attrs import field, frozen

from mcsl_core.alignment.settings import SolveSettings


@frozen
class AnalysisSettings:
    """What the caller may choose.

    Attributes
    ----------
    reference : str or None
        Name of the reference camera; the first without.
    rate : Fraction or None
        Programme frames per second; the reference camera's without.
    sync : {"auto", "timecode", "audio", "motion", "none"}
        How the cameras' clocks are brought together; ``auto`` takes the first that is sure.
    stages : mapping of str to str
        Stage -> name of the plugin that does it.
    sample_s : float
        Seconds between the pictures looked at.
    solve : SolveSettings
        Of the alignment.
    gaze : tuple of Path
        Files of where viewers looked, which is centred in place of the field.
    cache : bool
        Whether results of stages are kept beside the EDL, and those that are there used again.
    """

    reference: str | None = None
    rate: Fraction | None = None
    sync: str = "auto"
    stages: Mapping[str, str] = field(factory=dict)
    sample_s: float = 1.0
    solve: SolveSettings = field(factory=SolveSettings)
    gaze: tuple[Path, ...] = ()
    cache: bool = True
