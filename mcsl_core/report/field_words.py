"""What the page says of the surgical field: where it was found or drawn, and where no share of it may be claimed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mcsl_core.edl import Edl
from mcsl_core.edl.field import HAND, MIDDLE, PICTURES, awaits_analysis, fields_now
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.timing import FrameRange, merge_equal

FIELD, THE_MIDDLE = "surgical field", "middle of the picture"
_WORDS = {
    HAND: "drawn by hand",
    PICTURES: "found in the pictures",
    MIDDLE: "nothing shows where it lies: the middle of the picture was taken, and no share of it is claimed",
}


def of_a_field(edl: Edl, scores: ScoreTable) -> NDArray[np.bool_]:
    """(S,): which samples' scores are shares of a surgical field, not of the middle of the picture."""
    known = np.ones(len(scores.frames), bool)
    for stretch in edl.fields:
        if stretch.by == MIDDLE:
            known &= (scores.frames < stretch.range.start) | (scores.frames >= stretch.range.stop)
    return known


def scored(edl: Edl, scores: ScoreTable) -> tuple[NDArray[np.bool_], str]:
    """(S,): the samples whose scores are told, and what they are shares of: the field's, where any are."""
    known = of_a_field(edl, scores)
    return (known, FIELD) if known.any() or not len(known) else (~known, THE_MIDDLE)


def seen_of(edl: Edl) -> str:
    """What cameras' shares are shares of, in words."""
    unknown = [stretch.by == MIDDLE for stretch in edl.fields]
    if not any(unknown):
        return FIELD
    return f"{THE_MIDDLE} (nothing shows where the {FIELD} lies)" if all(unknown) else f"{FIELD}, where it is known"


def field_lines(edl: Edl, span: Callable[[FrameRange], str]) -> tuple[str, ...]:
    """Where the field lies when, in a line each; what is the same in neighbouring poses in one."""
    lines = merge_equal([(stretch.range, stretch.by) for stretch in fields_now(edl)])
    told = [f"{span(piece)}: {_WORDS[by]}" for piece, by in lines]
    if awaits_analysis(edl):
        told.append("It was drawn after the analysis: shares, shots and centering are of before.")
    return tuple(told)
