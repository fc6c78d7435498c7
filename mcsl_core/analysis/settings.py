"""What the caller of an analysis may choose."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path

from attrs import field, frozen

from mcsl_core.alignment.settings import SolveSettings


@frozen
class AnalysisSettings:
    """What the caller may choose. reference: a camera name (the first without). rate: programme frames per second
    (the reference's without). stages: stage -> name of the plugin. sample_s: seconds between looks. gaze: files of
    where viewers looked (see `gaze`), which is centred in place of the field. cache: keep results of stages in a folder
    beside the EDL, and use those that are there."""

    reference: str | None = None
    rate: Fraction | None = None
    sync: str = "auto"
    stages: Mapping[str, str] = field(factory=dict)
    sample_s: float = 1.0
    solve: SolveSettings = field(factory=SolveSettings)
    gaze: tuple[Path, ...] = ()
    cache: bool = True
