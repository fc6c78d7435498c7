# SPDX-License-Identifier: GPL-3.0-or-later
"""The surgical field drawn in the preview -> the EDL's drawn fields. No bpy.

Corners are clicked on the picture as it is shown, which centering has shifted; the EDL has them before that.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from itertools import pairwise

import attrs
from attrs import frozen

from mcsl_core.edl import DrawnField, Edl
from mcsl_core.edl.edits import clear_field, draw_field
from mcsl_core.edl.field import Polygon
from mcsl_core.edl.resolve import resolve, shift_at
from mcsl_core.timing import FrameRange, cut_points, merge_equal


@frozen
class FoundDrawing:
    """The surgical field as the scene keeps it, drawn since the EDL was written last.

    Attributes
    ----------
    fields
        What is drawn, over the whole programme.
    upon
        What the EDL had when it was drawn; None in a file of an older mcsl, which did not keep it.
    """

    fields: tuple[DrawnField, ...]
    upon: tuple[DrawnField, ...] | None = None


@frozen
class TakenDrawing:
    """What the EDL gets of a drawing.

    Attributes
    ----------
    fields
        The EDL's drawn fields with it.
    refused
        Where it is not taken, since the EDL was given another field meanwhile.
    replaced
        Where it takes the place of another, of which nobody can say which is newer.
    past_end
        Whether some of it lies past the programme's end.
    """

    fields: tuple[DrawnField, ...]
    refused: tuple[FrameRange, ...] = ()
    replaced: tuple[FrameRange, ...] = ()
    past_end: bool = False


def take_drawing(edl: Edl, found: FoundDrawing | None) -> TakenDrawing:
    """``found`` brought into ``edl``, frame by frame: what was changed on one side only holds, else the EDL's."""
    if found is None:
        return TakenDrawing(edl.drawn_fields)
    whole = FrameRange(0, edl.frames)
    mine = tuple(attrs.evolve(f, range=part) for f in found.fields if (part := f.range.intersection(whole)))
    past_end = any(f.range.stop > edl.frames for f in found.fields)
    if found.upon == edl.drawn_fields:
        return TakenDrawing(mine, past_end=past_end)
    if found.upon is None:
        there = drawn_parts(edl.drawn_fields, whole, among=mine)
        others = [(p, f is not None and not _same(f, _at(mine, p.start))) for p, f in there]
        return TakenDrawing(mine, replaced=_true_over(others), past_end=past_end)
    held, clashes = [], []
    for piece, theirs in drawn_parts(edl.drawn_fields, whole, among=(*mine, *found.upon)):
        drawn, before = _at(mine, piece.start), _at(found.upon, piece.start)
        changed = not _same(drawn, before)
        clash = changed and not _same(theirs, before) and not _same(theirs, drawn)
        clashes.append((piece, clash))
        value = drawn if changed and not clash else theirs
        held.append((piece, None if value is None else (value.polygons, value.note)))
    fields = tuple(DrawnField(piece, *value) for piece, value in merge_equal(held) if value is not None)
    same = drawn_parts(fields, whole) == drawn_parts(edl.drawn_fields, whole)
    return TakenDrawing(edl.drawn_fields if same else fields, _true_over(clashes), past_end=past_end)


def _true_over(pieces: Sequence[tuple[FrameRange, bool]]) -> tuple[FrameRange, ...]:
    return tuple(piece for piece, holds in merge_equal(pieces) if holds)


def remarks_on_drawing(edl: Edl, found: FoundDrawing | None) -> tuple[str, ...]:
    """What a person should know of a drawing that the EDL does not get as it is, or that takes another's place."""
    taken = take_drawing(edl, found)
    notes = [
        f"programme {_frames(piece)}: the field drawn in this timeline is not taken, since the EDL's was changed "
        "meanwhile: draw it again here if yours shall hold"
        for piece in taken.refused
    ]
    notes += [
        f"programme {_frames(piece)}: the field drawn in the EDL gives way to what this timeline has"
        for piece in taken.replaced
    ]
    if taken.past_end:
        notes.append(f"what is drawn past the programme's {edl.frames} frames is not taken")
    return tuple(notes)


def _frames(piece: FrameRange) -> str:
    return f"frames {piece.start + 1} to {piece.stop}"


def drawn_parts(
    fields: Sequence[DrawnField], piece: FrameRange, *, among: Sequence[DrawnField] = ()
) -> list[tuple[FrameRange, DrawnField | None]]:
    """Ranges that tile ``piece``, each with the field drawn there (its range cut to it), None where none is.

    among: cut at the ends of these as well.
    """
    points = cut_points(piece.stop, [piece, *(each.range for each in (*fields, *among))])
    parts = [(FrameRange(a, b), _at(fields, a)) for a, b in pairwise(p for p in points if p >= piece.start)]
    said = [(part, None if f is None else (f.polygons, f.note)) for part, f in parts]
    ranges = [part for part, _ in (said if among else merge_equal(said))]
    return [(part, f and attrs.evolve(f, range=part)) for part in ranges for f in (_at(fields, part.start),)]


def _at(fields: Sequence[DrawnField], frame: int) -> DrawnField | None:
    """The field that holds at a frame: of several the last."""
    return next((f for f in reversed(fields) if frame in f.range), None)


def _same(one: DrawnField | None, other: DrawnField | None) -> bool:
    """Whether both say the same, over whatever frames."""
    if one is None or other is None:
        return one is other
    return (one.polygons, one.note) == (other.polygons, other.note)


def stretch_at(edl: Edl, frame: int) -> FrameRange:
    """The frames about ``frame`` over which the programme keeps one perspective: there the same corners hold."""
    at = next((i for i, pose in enumerate(edl.poses) if frame in pose.range), len(edl.poses) - 1)
    first = last = at
    while first and edl.poses[first - 1].perspective == edl.poses[at].perspective:
        first -= 1
    while last + 1 < len(edl.poses) and edl.poses[last + 1].perspective == edl.poses[at].perspective:
        last += 1
    return FrameRange(edl.poses[first].range.start, edl.poses[last].range.stop)


def with_field(edl: Edl, frame: int, corners: Sequence[tuple[float, float]], *, more: bool = False) -> Edl:
    """``edl`` with the field drawn about ``frame``, by corners clicked in the picture as it is shown there.

    It holds as far as one perspective does; where other fields are drawn for parts of that, as far as the part.
    more: beside all that is drawn in this perspective already, whose notes stay.

    Raises Fault where the corners are no polygon of the picture.
    """
    decision = next((d for piece, d in resolve(edl) if frame in piece), None)
    dx, dy = (0.0, 0.0) if decision is None else shift_at(edl, decision, frame)
    polygon = tuple((round(x - dx, 1), round(y - dy, 1)) for x, y in corners)
    piece, there = part_at(edl, frame)
    if not more or there is None:
        return draw_field(edl, (polygon,), piece)
    for part, drawn in drawn_parts(edl.drawn_fields, stretch_at(edl, frame)):
        if drawn is not None:
            edl = draw_field(edl, (*drawn.polygons, polygon), part, drawn.note)
    return edl


def without_field(edl: Edl, frame: int) -> Edl:
    """``edl`` with nothing drawn about ``frame``: what is drawn for other frames stays."""
    return clear_field(edl, part_at(edl, frame)[0])


def part_at(edl: Edl, frame: int) -> tuple[FrameRange, DrawnField | None]:
    """The frames about ``frame`` of one perspective and one field drawn, or none, and that field."""
    parts = drawn_parts(edl.drawn_fields, stretch_at(edl, frame))
    return next(((part, drawn) for part, drawn in parts if frame in part), parts[-1])


def to_text(fields: Iterable[DrawnField]) -> str:
    """Drawn fields as a scene keeps them."""
    return json.dumps([[f.range.start, f.range.stop, f.polygons, f.note] for f in fields])


def from_text(text: str) -> tuple[DrawnField, ...]:
    """What `to_text` made; ValueError or TypeError where it is something else."""
    fields = []
    for start, stop, polygons, note in json.loads(text):
        corners: tuple[Polygon, ...] = tuple(tuple((float(x), float(y)) for x, y in polygon) for polygon in polygons)
        if not isinstance(start, int) or not isinstance(stop, int) or not isinstance(note, str):
            raise TypeError(text)
        fields.append(DrawnField(FrameRange(start, stop), corners, note))
    return tuple(fields)
