"""What the caller of an analysis may choose."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import isfinite
from os import PathLike
from pathlib import Path
from typing import Any

from attrs import field, frozen

from mcsl_core.alignment.settings import SolveSettings
from mcsl_core.errors import UsageError
from mcsl_core.timing import parse_rate

_LONGEST_S = 3600.0
MOVEMENT_VIEWS = ("follow", "hold")


def _rate(value: Any) -> Fraction | None:
    if isinstance(value, float) and isfinite(value):
        near = Fraction(value).limit_denominator(1001)
        value = near if near.denominator == 1001 else value  # 30000 / 1001
    try:
        return None if value is None else parse_rate(str(value))
    except ValueError as error:
        raise UsageError(f"rate: {error}", remedy='Give it as "30000/1001", 25 or 29.97') from None


def _paths(value: Any) -> tuple[Path, ...]:
    try:
        return (Path(value),) if isinstance(value, str | PathLike) else tuple(Path(each) for each in value)
    except TypeError:
        raise UsageError(f"gaze is files, got {value!r}", remedy='Give it as ["a.csv", "b.csv"]') from None


def _step(_: Any, __: Any, value: Any) -> None:
    if not (isinstance(value, int | float) and 0 < value <= _LONGEST_S):
        raise UsageError(f"sample_s is seconds from picture to picture, got {value!r}", remedy="Give it as 1.0")


def _movement_view(_: Any, __: Any, value: Any) -> None:
    if value not in MOVEMENT_VIEWS:
        what = f"movement_view is {' or '.join(MOVEMENT_VIEWS)}, got {value!r}"
        raise UsageError(what, remedy=f'Give it as "{MOVEMENT_VIEWS[0]}"')


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
    movement_view : {"follow", "hold"}
        While the lamp moves the programme stands still where the lamp can be followed, or holds its camera and glides.
    cache : bool
        Whether results of stages are kept beside the EDL, and those that are there used again.
    """

    reference: str | None = None
    rate: Fraction | None = field(default=None, converter=_rate)
    sync: str = "auto"
    stages: Mapping[str, str] = field(factory=dict)
    sample_s: float = field(default=1.0, validator=_step)
    solve: SolveSettings = field(factory=SolveSettings)
    gaze: tuple[Path, ...] = field(default=(), converter=_paths)
    movement_view: str = field(default="follow", validator=_movement_view)
    cache: bool = True
