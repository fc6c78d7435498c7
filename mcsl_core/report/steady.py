"""An evaluation as the page tells it."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from attrs import frozen

from mcsl_core.evaluation.results import MEASURES, Evaluation, Measured, SeenThrough, Steadiness

from .charts import short_time


@frozen
class SteadyRow:
    """A variant's results as written; "-" where there is none."""

    label: str
    cells: tuple[str, ...]


@frozen
class SteadyFacts:
    """The results for the page.

    Attributes
    ----------
    switches, whole : tuple of SteadyRow
        At the switches, and over the whole programme where that was measured.
    told : str
        What the alignment changed, in a sentence; empty where that is not known.
    conditions : tuple of str
        How it was measured.
    seen_through : tuple of str
        When heads are seen through, and how much of the field that is; no camera is named.
    """

    switches: tuple[SteadyRow, ...]
    whole: tuple[SteadyRow, ...]
    told: str
    conditions: tuple[str, ...]
    seen_through: tuple[str, ...]


def steady_facts(evaluation: Evaluation, rate: Fraction) -> SteadyFacts:
    """An evaluation as the page tells it."""
    conditions = evaluation.conditions
    width, height = conditions.size
    pairs = f"{len(evaluation.switches)} of {conditions.switches}" if conditions.switches else "no"
    sampled = f"; within shots one pair of frames in {conditions.every}" if conditions.every > 1 else ""
    return SteadyFacts(
        tuple(SteadyRow(row.label, _cells(row.switches)) for row in evaluation.measured if evaluation.switches),
        tuple(SteadyRow(row.label, _cells(row.whole)) for row in evaluation.measured if row.whole is not None),
        _steady_words({row.name: row for row in evaluation.measured}, width),
        (
            f"About the field: within {conditions.field:.0%} of the width of its middle.",
            f"Measured on pictures of {width}x{height}, {conditions.picture}; {pairs} switches{sampled}.",
            f"Points within shots: {conditions.within_camera}. At switches: {conditions.at_switches}.",
        ),
        tuple(_seen_words(stretch, rate) for stretch in evaluation.seen_through),
    )


def _seen_words(stretch: SeenThrough, rate: Fraction) -> str:
    start, stop = (short_time(float(frame / rate)) for frame in (stretch.range.start, stretch.range.stop))
    return f"{start} to {stop}: {stretch.share:.0%} of it in the mean, {stretch.most:.0%} at most"


def _cells(means: Steadiness) -> tuple[str, ...]:
    values = [getattr(means, name) for name in MEASURES]
    return tuple("-" if value is None else f"{value:.1f}" for value in values)


def _steady_words(rows: Mapping[str, Measured], width: int) -> str:
    """What the alignment changed at the switches, in one sentence: of the field where it is known, else of all."""
    if not {"no", "auto"} <= rows.keys():
        return ""
    for what, name in (("field", "av_speed_field_px"), ("picture", "av_speed_px")):
        no, auto = getattr(rows["no"].switches, name), getattr(rows["auto"].switches, name)
        if no is not None and auto is not None:
            return (
                f"At a switch the {what} jumps by {auto:.1f} pixels of {width} on average; "
                f"without alignment it would jump by {no:.0f}."
            )
    return ""
