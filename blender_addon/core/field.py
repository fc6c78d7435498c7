# SPDX-License-Identifier: GPL-3.0-or-later
"""The surgical field drawn in the preview -> the EDL's drawn fields. No bpy.

Corners are clicked on the picture as it is shown, which centering has shifted; the EDL has them before that.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence

from mcsl_core.edl import DrawnField, Edl
from mcsl_core.edl.edits import clear_field, draw_field
from mcsl_core.edl.field import Polygon, drawn_over
from mcsl_core.edl.resolve import resolve, shift_at
from mcsl_core.timing import FrameRange


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

    more: beside what is drawn there already. Raises Fault where the corners are no polygon of the picture.
    """
    decision = next((d for piece, d in resolve(edl) if frame in piece), None)
    dx, dy = (0.0, 0.0) if decision is None else shift_at(edl, decision, frame)
    polygon = tuple((round(x - dx, 1), round(y - dy, 1)) for x, y in corners)
    piece = stretch_at(edl, frame)
    beside = next((polygons for part, polygons in drawn_over(edl.drawn_fields, piece) if frame in part), None)
    return draw_field(edl, (*(beside or ()), polygon) if more else (polygon,), piece)


def without_field(edl: Edl, frame: int) -> Edl:
    """``edl`` with nothing drawn about ``frame``."""
    return clear_field(edl, stretch_at(edl, frame))


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
