# SPDX-License-Identifier: GPL-3.0-or-later
"""What is removed from the delivery, as marks in a timeline say it. No bpy.

A mark lies over what is removed; an editor lays, moves, trims and deletes marks as he does any strip. They are read
against what the EDL had removed when they were laid: what others removed or brought back since stays so.
"""

from __future__ import annotations

import json
from collections.abc import Iterable

from attrs import frozen

from mcsl_core.edl import Edl
from mcsl_core.errors import InputError
from mcsl_core.timing import FrameRange, joined, ranges_of_spans, without

from . import shot_list


@frozen
class FoundRemoval:
    """The marks as found.

    Attributes
    ----------
    marks
        The programme frames that marks cover; they may reach outside the programme.
    upon
        What the EDL had removed when the timeline was last brought in line with it.
    """

    marks: tuple[FrameRange, ...] = ()
    upon: tuple[FrameRange, ...] = ()


NO_MARKS = FoundRemoval()


def take_removal(edl: Edl, found: FoundRemoval) -> tuple[FrameRange, ...]:
    """What is removed: as the EDL has it, less the marks that went, and the marks that came.

    Raises
    ------
    InputError
        Nothing of the programme would be left.
    """
    whole = FrameRange(0, edl.frames)
    removed = tuple(both for piece in merged(edl.removed, found) if (both := piece.intersection(whole)) is not None)
    if removed == (whole,):
        raise InputError(
            "the whole programme is marked as removed: nothing is left to deliver",
            where="channel Removed",
            remedy="Delete or trim a mark",
        )
    return removed


def chosen(
    edl: Edl, frame: int, preview: tuple[int, int] | None, selected: Iterable[tuple[int, int]]
) -> tuple[FrameRange, ...]:
    """What an editor means to remove or bring back, in programme frames, joined; () where that is nothing.

    Parameters
    ----------
    edl
        The programme, the timeline's decisions already in it.
    frame
        The playhead.
    preview
        The preview range, which goes before all else; None where there is none.
    selected
        The shots that are selected; without any it is the one at the playhead. They may reach outside the programme.
    """
    spans = list(selected) if preview is None else [preview]
    if not spans:
        rows = shot_list.rows_of(edl)
        index = shot_list.row_at(rows, frame)
        spans = [(rows[index].range.start, rows[index].range.stop)] if index >= 0 else []
    return ranges_of_spans((start, min(stop, edl.frames)) for start, stop in spans)


def merged(removed: Iterable[FrameRange], found: FoundRemoval) -> tuple[FrameRange, ...]:
    """``removed`` less the marks that went, and the marks that came."""
    stays = without(removed, without(found.upon, found.marks))
    return tuple(joined([*stays, *without(found.marks, found.upon)]))


def to_text(pieces: Iterable[FrameRange]) -> str:
    """Ranges as the scene keeps them: [[start, stop], ...]."""
    return json.dumps([[piece.start, piece.stop] for piece in pieces])


def from_text(text: str) -> tuple[FrameRange, ...]:
    """The inverse of `to_text`.

    Raises
    ------
    ValueError, TypeError
        The text is not of its making.
    """
    return tuple(joined(FrameRange(int(start), int(stop)) for start, stop in json.loads(text)))
