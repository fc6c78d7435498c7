"""Settings of an analysis as people give them in a notebook: taken as meant, or refused before any work."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest

from mcsl_core.analysis.settings import AnalysisSettings
from mcsl_core.errors import UsageError


@pytest.mark.parametrize(
    ("given", "rate"),
    [
        (None, None),
        (25, 25),
        ("25", 25),
        (29.97, Fraction(30000, 1001)),
        (30000 / 1001, Fraction(30000, 1001)),
        (Fraction(25, 2), Fraction(25, 2)),
        (25.0, 25),
    ],
)
def test_rates_of_any_kind_are_exact(given, rate) -> None:
    assert AnalysisSettings(rate=given).rate == rate


@pytest.mark.parametrize("given", ["a.csv", Path("a.csv"), ["a.csv"], (Path("a.csv"),)])
def test_one_file_of_gaze_is_no_row_of_letters(given) -> None:
    assert AnalysisSettings(gaze=given).gaze == (Path("a.csv"),)


@pytest.mark.parametrize(
    "settings",
    [
        *({"rate": rate} for rate in (0, -25, "fast", float("nan"), float("inf"), 1e9, "1e999999999", [25])),
        *({"sample_s": step} for step in (0, -1.0, float("nan"), float("inf"), "1", None)),
        *({"gaze": gaze} for gaze in (3, [3], None)),
    ],
    ids=str,
)
def test_what_cannot_be_meant_is_refused_at_once(settings) -> None:
    """A step of -1 never came to an end; the others were tracebacks."""
    with pytest.raises(UsageError, match=r"rate|sample_s|gaze"):
        AnalysisSettings(**settings)
