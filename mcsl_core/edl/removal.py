"""What is removed from a programme, and what is then delivered of it."""

from __future__ import annotations

import attrs

from mcsl_core.timing import FrameRange, joined, without

from .schema import Edl


def remove(edl: Edl, piece: FrameRange) -> Edl:
    """``edl`` with the frames of ``piece`` left out of what is delivered.

    Raises
    ------
    Fault
        Where nothing would be left, or the piece ends after the programme.
    """
    return attrs.evolve(edl, removed=tuple(joined((*edl.removed, piece))))


def bring_back(edl: Edl, piece: FrameRange | None = None) -> Edl:
    """``edl`` with what was removed of ``piece`` (of everything, without) delivered again."""
    piece = piece or FrameRange(0, edl.frames)
    return attrs.evolve(edl, removed=without(edl.removed, [piece]))


def delivered(edl: Edl, piece: FrameRange | None = None) -> tuple[FrameRange, ...]:
    """The programme's frames (those of ``piece``) that are not removed: as few ranges as can be, in order."""
    return without([piece or FrameRange(0, edl.frames)], edl.removed)


def delivered_frames(edl: Edl) -> int:
    """How many frames the delivered programme has."""
    return sum(map(len, delivered(edl)))
