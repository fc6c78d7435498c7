"""Where the surgical field lies: as the analysis took it, as somebody drew it, and which of the two holds when.

Outlines are in programme pixels before centering: under the first perspective those are the reference camera's.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import hypot
from typing import TYPE_CHECKING, Any, TypeVar

import attrs
from attrs import field, frozen

from mcsl_core.documents import NotEmpty, doc
from mcsl_core.timing import FrameRange, cut_points, merge_equal

from .checks import NUMBERS, require

if TYPE_CHECKING:
    from .schema import Edl

Polygon = tuple[tuple[float, float], ...]
Polygons = tuple[Polygon, ...]
MOST_POLYGONS, MOST_POINTS = 100, 10_000
HAND, PICTURES, MIDDLE = "hand", "pictures", "middle"


def _outlines(_: Any, attribute: attrs.Attribute[Any], value: Polygons) -> None:
    """Validator: polygons that have an area."""
    at = f".{attribute.name}"
    NotEmpty(MOST_POLYGONS)(_, attribute, value)
    NUMBERS.check(value, at)
    for index, polygon in enumerate(value):
        where = f"{at}[{index}]"
        require(
            3 <= len(polygon) <= MOST_POINTS, f"has {len(polygon)} points where 3 to {MOST_POINTS} are taken", where
        )
        require(has_area(polygon), "has no area: its points lie on a line", where)


def has_area(polygon: Polygon) -> bool:
    """Whether some point lies a pixel off the line through the first and the one farthest from it."""
    (x0, y0), *rest = polygon
    x1, y1 = max(rest, key=lambda point: hypot(point[0] - x0, point[1] - y0))
    length = hypot(x1 - x0, y1 - y0)
    return length > 0 and any(abs((x - x0) * (y1 - y0) - (y - y0) * (x1 - x0)) > length for x, y in rest)


@frozen
class FieldStretch:
    """Where the analysis took the surgical field to lie over a stretch, and what that rests on."""

    range: FrameRange = field(metadata=doc("where it holds"))
    by: str = field(
        metadata=doc(
            "pictures: found in them; hand: drawn; middle: nothing in the pictures shows a field and the middle of "
            "the picture was taken, so that scores are not shares of any field"
        )
    )
    polygons: Polygons = field(
        validator=_outlines, metadata=doc("its outlines [x, y], ... in programme pixels before centering")
    )

    def __attrs_post_init__(self) -> None:
        known = (HAND, PICTURES, MIDDLE)
        require(self.by in known, f"expected one of {', '.join(known)}, got {self.by!r}", ".by")


@frozen
class DrawnField:
    """The surgical field as somebody drew it, over a stretch."""

    range: FrameRange = field(metadata=doc("where it holds"))
    polygons: Polygons = field(
        validator=_outlines, metadata=doc("its outlines [x, y], ... in programme pixels before centering")
    )
    note: str = field(default="", metadata=doc("the editor's remark", optional=True))


Stretch = TypeVar("Stretch", FieldStretch, DrawnField)


def drawn_over(drawn: Sequence[DrawnField], piece: FrameRange) -> list[tuple[FrameRange, Polygons | None]]:
    """What is drawn over ``piece``: ranges that tile it, each with its outlines, None where nothing is drawn."""
    points = cut_points(piece.stop, [piece, *(each.range for each in drawn)])
    pieces: list[tuple[FrameRange, Polygons | None]] = []
    for start, stop in pairwise(point for point in points if point >= piece.start):
        holds = next((each.polygons for each in reversed(drawn) if start in each.range), None)
        pieces.append((FrameRange(start, stop), holds))
    return merge_equal(pieces)


def fields_now(edl: Edl) -> list[FieldStretch]:
    """Where the field lies by what is known now: as drawn, else as the analysis took it; nothing where it took none."""
    found = []
    for piece, polygons in drawn_over(edl.drawn_fields, FrameRange(0, edl.frames)):
        if polygons is not None:
            found.append(FieldStretch(piece, HAND, polygons))
            continue
        for stretch in edl.fields:
            part = stretch.range.intersection(piece)
            if part is not None and stretch.by != HAND:
                found.append(attrs.evolve(stretch, range=part))
    return found


def field_at(edl: Edl, frame: int) -> FieldStretch | None:
    """Where the field lies at a frame; None where nobody knows."""
    return next((stretch for stretch in fields_now(edl) if frame in stretch.range), None)


def at_size(stretches: Sequence[Stretch], x: float, y: float) -> tuple[Stretch, ...]:
    """The stretches with their outlines ``x`` and ``y`` times as large; without those that are nothing then."""
    made = []
    for stretch in stretches:
        polygons = (tuple((px * x, py * y) for px, py in polygon) for polygon in stretch.polygons)
        if kept := tuple(filter(has_area, polygons)):
            made.append(attrs.evolve(stretch, polygons=kept))
    return tuple(made)


def awaits_analysis(edl: Edl) -> bool:
    """Whether the field is drawn otherwise than the analysis had it: scores and centering are of before."""
    by_hand = [DrawnField(stretch.range, stretch.polygons) for stretch in edl.fields if stretch.by == HAND]
    whole = FrameRange(0, edl.frames)
    return drawn_over(by_hand, whole) != drawn_over(edl.drawn_fields, whole)
