"""An evaluation as the page tells it."""

from __future__ import annotations

from collections.abc import Mapping

from attrs import frozen

from ..figures import Evaluation, Measured


@frozen
class SteadyRow:
    """A variant's figures as written; "-" where there is none."""

    label: str
    cells: tuple[str, ...]


@frozen
class SteadyFacts:
    """The figures for the page. heads: of the columns, under "whole" where measured and "switches"."""

    whole: bool
    rows: tuple[SteadyRow, ...]
    told: str
    conditions: tuple[str, ...]


def steady_facts(evaluation: Evaluation) -> SteadyFacts:
    """An evaluation as the page tells it."""
    conditions = evaluation.conditions
    whole = any(row.whole is not None for row in evaluation.measured)
    width, height = conditions.size
    pairs = f"{len(evaluation.switches)} of {conditions.switches}" if conditions.switches else "no"
    return SteadyFacts(
        whole,
        tuple(SteadyRow(row.label, _cells(row, whole)) for row in evaluation.measured),
        _steady_words({row.name: row for row in evaluation.measured}),
        (
            f"Measured on pictures of {width}x{height}, {conditions.picture}; {pairs} switches"
            + (f"; within shots one pair of frames in {conditions.every}" if conditions.every > 1 else "")
            + ".",
            f"Points within shots: {conditions.within_camera}. At switches: {conditions.at_switches}.",
        ),
    )


def _cells(row: Measured, whole: bool) -> tuple[str, ...]:
    cells = []
    for means in (row.whole, row.switches) if whole else (row.switches,):
        for name in ("itf_db", "itf_valid_db", "av_speed_px"):
            value = None if means is None else getattr(means, name)
            cells.append("-" if value is None else f"{value:.1f}")
    return tuple(cells)


def _steady_words(rows: Mapping[str, Measured]) -> str:
    """What the alignment changed at the switches, in one sentence."""
    speeds = [rows[n].switches.av_speed_px if n in rows else None for n in ("no", "auto")]
    no, auto = speeds
    if no is None or auto is None or no <= 0:
        return ""
    return f"At a switch the picture jumps by {auto:.1f} pixels on average; without alignment it would by {no:.0f}."
