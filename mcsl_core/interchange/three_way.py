"""What an editor changed, carried over to an EDL that was decided on as well since the document was exported."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
from attrs import frozen

from mcsl_core.edl import Edl
from mcsl_core.timing import FrameRange, merge_equal, without

from .changes import Changes, Layout, find_changes
from .found import FoundCut
from .model import Sequence as Cut
from .model import Shot
from .origin import automatic_of, exported, pairs, shots_of
from .painting import beside, paint

Stretches = tuple[tuple[FrameRange, str], ...]


@frozen
class Merged:
    """What is to be decided anew, and what became of the decisions that the document does not know.

    Attributes
    ----------
    changes
        As found; its cameras are those that the EDL does not show already.
    kept
        Where the EDL shows a camera that was decided since the export, or may have been; it stays.
    overruled
        Where the EDL showed such a camera, and the editor chose a third one.
    """

    changes: Changes
    kept: Stretches
    overruled: Stretches


def compared(cut: Cut, edl: Edl, found: FoundCut, layout: Layout) -> Merged:
    """What an editor changed of ``edl``, whose cut as it is now is ``cut``, since the document was exported."""
    was = exported(found.origin, edl)
    if was is None:
        return merged(_without_what_came_back(find_changes(_as_long_as(found, cut), found, layout)), edl, None)
    before = attrs.evolve(cut, shots=was.shots, removed=was.removed)
    return merged(find_changes(before, found, layout), edl, was.shots)


def _as_long_as(found: FoundCut, cut: Cut) -> Cut:
    """``cut`` closed up where the document is as long as that, else whole: older exports held what was removed."""
    length = max((clip.range.stop for clip in found.clips), default=0)
    return cut if length == cut.length else attrs.evolve(cut, removed=())


def _without_what_came_back(changes: Changes) -> Changes:
    """That something removed is there may mean that its removal is younger than the document: it is named alone."""
    notes = [
        f"frames {piece} are there, which are removed: bring them back with mcsl remove"
        for piece in changes.brought_back
    ]
    return attrs.evolve(changes, brought_back=(), notes=(*changes.notes, *notes))


def merged(changes: Changes, edl: Edl, shown: Sequence[Shot] | None) -> Merged:
    """Which of the changes hold beside the decisions of ``edl``.

    Parameters
    ----------
    changes
        Between what was exported, or the EDL as it is where that is not known, and what came back.
    edl
        As it is now.
    shown
        What was shown when the document was exported; None where it does not say so. Then no decision is taken back:
        that the automatic choice came back may mean that the decision is younger than the document.
    """
    current, automatic = pairs(shots_of(edl)), pairs(automatic_of(edl))
    before = pairs(shown) if shown is not None else automatic
    cameras: list[tuple[FrameRange, str]] = []
    kept: list[tuple[FrameRange, str]] = []
    overruled: list[tuple[FrameRange, str]] = []
    found = [(piece, camera or "") for piece, camera in paint(edl.frames, changes.cameras)]
    for piece, (now, was, there) in beside(edl.frames, found, before, current):
        decided = there != was
        if decided and now == (was if shown is None else ""):
            kept.append((piece, there))
        elif now not in ("", there):
            cameras.append((piece, now))
            if decided:
                overruled.append((piece, there))
    gone = without(changes.removed, edl.removed)
    return Merged(
        changes=attrs.evolve(changes, cameras=tuple(merge_equal(cameras)), removed=tuple(gone)),
        kept=tuple(merge_equal(kept)),
        overruled=tuple(merge_equal(overruled)),
    )
