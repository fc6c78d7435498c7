"""What the page claims of the surgical field: shares of it where it is known, and none where nothing shows it."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from builders import small

from mcsl_core.analysis.measurements import Measurements
from mcsl_core.edl import DrawnField, Edl, FieldStretch, Shot
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.report.anonymous import nameless
from mcsl_core.report.facts import gather
from mcsl_core.report.page import Lacking, page
from mcsl_core.timing import FrameRange

SQUARE = ((10.0, 10.0), (50.0, 10.0), (50.0, 40.0))


@pytest.fixture
def edl_of_two() -> Edl:
    return small(shots=(Shot(FrameRange(0, 50), "cam1"), Shot(FrameRange(50, 100), "cam2")))


def measured_of(edl: Edl) -> Measurements:
    """The first camera sees all, the second half."""
    frames = np.arange(0, edl.frames, 10)
    visible = np.repeat([[1.0, 0.5]], len(frames), axis=0)
    return Measurements(ScoreTable(frames, ("cam1", "cam2"), visible, np.ones(visible.shape, bool)))


def test_no_share_of_a_field_is_claimed_where_nothing_shows_one(edl_of_two: Edl) -> None:
    edl = attrs.evolve(edl_of_two, fields=(FieldStretch(FrameRange(0, edl_of_two.frames), "middle", (SQUARE,)),))
    facts = gather(edl, measured_of(edl))
    assert [tile.label for tile in facts.tiles if "visible" in tile.label] == ["of the middle of the picture visible"]
    assert "of the surgical field free" not in facts.verdict
    assert "of the middle of the picture free" in facts.verdict
    assert "Nothing shows where the surgical field lies" in facts.verdict
    assert "nothing shows where it lies" in facts.fields[0]
    text = page(edl, "edl.json", measured_of(edl), [None] * len(edl.poses), None, Lacking())
    assert "visible share of the surgical field" not in text
    assert "visible share of the middle of the picture" in text


def test_shares_are_of_the_field_where_it_is_known_at_some_time(edl_of_two: Edl) -> None:
    kinds = ((0, 50, "pictures"), (50, 100, "middle"))
    stretches = tuple(FieldStretch(FrameRange(start, stop), by, (SQUARE,)) for start, stop, by in kinds)
    facts = gather(attrs.evolve(edl_of_two, fields=stretches), measured_of(edl_of_two))
    tile = next(t for t in facts.tiles if t.label == "of the field visible")
    assert tile.value == "100%", "the second half's camera sees half of something that is no field"
    assert "at times" in facts.verdict
    assert len(facts.fields) == 2


def test_what_was_drawn_after_the_analysis_is_told(edl_of_two: Edl) -> None:
    drawn = attrs.evolve(edl_of_two, drawn_fields=(DrawnField(FrameRange(0, 100), (SQUARE,), "Dr. Kim"),))
    facts = gather(drawn, None)
    assert facts.fields[0].endswith("drawn by hand")
    assert "after the analysis" in facts.fields[-1]
    assert nameless(drawn, None)[0].drawn_fields[0].note == ""
