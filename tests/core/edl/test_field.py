"""The surgical field in the document: what is drawn, what the analysis took, and which of the two holds."""

from __future__ import annotations

import attrs
import pytest
from builders import R, small
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import edls, outlines, ranges

from mcsl_core.edl import DrawnField, FieldStretch, dumps, from_json, loads, to_json
from mcsl_core.edl.edits import carry_over, clear_field, draw_field, merged
from mcsl_core.edl.field import awaits_analysis, drawn_over, fields_now
from mcsl_core.errors import DocumentError, Fault

SQUARE = ((10.0, 10.0), (50.0, 10.0), (50.0, 40.0), (10.0, 40.0))
OTHER = ((100.0, 90.0), (140.0, 90.0), (120.0, 130.0))


def test_a_document_of_before_has_no_fields_and_keeps_its_bytes() -> None:
    text = dumps(small())
    assert "fields" not in text
    assert loads(text).fields == loads(text).drawn_fields == ()


@given(edls())
def test_what_is_drawn_tiles_the_programme_and_the_later_wins(edl) -> None:
    pieces = drawn_over(edl.drawn_fields, R(0, edl.frames))
    assert [frame for piece, _ in pieces for frame in piece] == list(range(edl.frames))
    for piece, polygons in pieces:
        for frame in piece:
            held = [drawn.polygons for drawn in edl.drawn_fields if frame in drawn.range]
            assert polygons == (held[-1] if held else None)


@given(edls(), outlines, st.data())
def test_what_is_drawn_anew_replaces_what_was_there_and_nothing_else(edl, polygons, data) -> None:
    piece = data.draw(ranges(edl.frames))
    edl = attrs.evolve(edl, size=(9000, 9000))
    assume(all(max(x) >= 0 and max(y) >= 0 for x, y in (zip(*polygon, strict=True) for polygon in polygons)))
    made = draw_field(edl, polygons, piece)
    before, after = (drawn_over(each.drawn_fields, R(0, edl.frames)) for each in (edl, made))
    for frame in range(edl.frames):
        was, now = (next(p for r, p in pieces if frame in r) for pieces in (before, after))
        assert now == (polygons if frame in piece else was)
    cleared = drawn_over(clear_field(made, piece).drawn_fields, piece)
    assert cleared == [(piece, None)]
    assert clear_field(made).drawn_fields == ()


def test_what_is_drawn_holds_over_what_was_found() -> None:
    found = (FieldStretch(R(0, 60), "pictures", (OTHER,)), FieldStretch(R(60, 100), "middle", (OTHER,)))
    edl = small(fields=found, drawn_fields=(DrawnField(R(40, 80), (SQUARE,)),))
    assert [(f.range, f.by) for f in fields_now(edl)] == [
        (R(0, 40), "pictures"),
        (R(40, 80), "hand"),
        (R(80, 100), "middle"),
    ]
    assert awaits_analysis(edl)
    analysed = (found[0], FieldStretch(R(40, 80), "hand", (SQUARE,)), FieldStretch(R(80, 100), "middle", (OTHER,)))
    analysed = (attrs.evolve(analysed[0], range=R(0, 40)), *analysed[1:])
    assert not awaits_analysis(attrs.evolve(edl, fields=analysed))
    assert awaits_analysis(clear_field(attrs.evolve(edl, fields=analysed))), "it was taken away after the analysis"


@pytest.mark.parametrize(
    ("polygon", "what"),
    [
        (SQUARE[:2], "has 2 points"),
        (((0.0, 0.0), (5.0, 5.0), (9.0, 9.0)), "lie on a line"),
        (((3.0, 3.0),) * 4, "lie on a line"),
        (((0.0, 0.0), (1e9, 5.0), (9.0, 9.0)), "must be"),
        (((0.0, 0.0), (float("nan"), 5.0), (9.0, 9.0)), "must be"),
    ],
)
def test_what_is_no_polygon_is_refused(polygon, what) -> None:
    with pytest.raises(Fault, match=what):
        draw_field(small(), (SQUARE, polygon))


def test_a_polygon_past_the_picture_is_refused_and_one_that_reaches_out_is_not() -> None:
    with pytest.raises(Fault, match="outside of the programme's 320x180"):
        draw_field(small(), (((400.0, 10.0), (500.0, 10.0), (450.0, 90.0)),))
    draw_field(small(), (((300.0, 10.0), (500.0, 10.0), (450.0, 90.0)),))


def test_a_wrong_field_is_refused_with_its_path() -> None:
    document = to_json(small(drawn_fields=(DrawnField(R(0, 9), (SQUARE,)),)))
    document["drawn_fields"][0]["polygons"][0] = document["drawn_fields"][0]["polygons"][0][:2]
    with pytest.raises(DocumentError, match=r"\$\.drawn_fields\[0\]\.polygons\[0\]"):
        from_json(document)
    document = to_json(small(fields=(FieldStretch(R(0, 9), "middle", (SQUARE,)),)))
    document["fields"][0]["by"] = "guess"
    with pytest.raises(DocumentError, match=r"\$\.fields\[0\]\.by.*expected one of hand, pictures, middle"):
        from_json(document)
    with pytest.raises(Fault, match="ends after the programme"):
        small(drawn_fields=(DrawnField(R(0, 900), (SQUARE,)),))


def test_a_new_analysis_keeps_what_is_drawn_but_not_in_another_cameras_perspective() -> None:
    old = draw_field(small(), (SQUARE,), R(60, 90), "the wound")
    assert carry_over(old, small()).drawn_fields == old.drawn_fields
    cameras = {name: ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)) for name in ("cam1", "cam2")}
    other = attrs.evolve(small(), reference="cam2", poses=(attrs.evolve(small().poses[0], homographies=cameras),))
    with pytest.raises(DocumentError, match="drawn in the perspective of 'cam1'"):
        carry_over(old, other)
    with pytest.raises(DocumentError, match=r"drawn_fields\[0\] ends at frame 90"):
        carry_over(old, small(70))


def test_a_field_drawn_here_and_an_override_written_meanwhile_are_both_kept() -> None:
    base = small()
    mine = draw_field(base, (SQUARE,))
    theirs = attrs.evolve(base, look=attrs.evolve(base.look, fill=False))
    both = merged(base, mine, theirs)
    assert both.drawn_fields == mine.drawn_fields
    assert not both.look.fill
