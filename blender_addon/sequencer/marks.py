# SPDX-License-Identifier: GPL-3.0-or-later
"""Marks over what is removed from the delivery: strips that darken what lies below, on a channel of their own on top.

They are the editor's to lay, move, trim and delete; core/removal.py says what they mean.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count
from typing import Any

from mcsl_core.errors import InputError
from mcsl_core.timing import FrameRange, ranges_of_spans, without

from ..core.removal import FoundRemoval, from_text, merged, to_text
from .compat import ends, new_effect, set_ends
from .edit import HIGHEST_CHANNEL, split_strip
from .scene_properties import MARK, REMOVED_UPON, odd, role_of, text_of

_DARK = 0.35  # what is left of the light: still to be told what it was
_COLOUR = "COLOR_01"  # red


def marks_of(scene: Any) -> list[Any]:
    """The strips that say what is removed; a muted one says nothing, and stays where it is."""
    return [strip for strip in scene.sequence_editor.strips if role_of(strip) == "removed" and not strip.mute]


def read_marks(scene: Any) -> FoundRemoval:
    """The marks, and what they were laid upon. InputError where that cannot be read."""
    text = text_of(scene, REMOVED_UPON, "the scene", "[]")
    try:
        upon = from_text(text)
    except (ValueError, TypeError) as error:
        raise odd(REMOVED_UPON, text, "ranges of frames", "the scene") from error
    return FoundRemoval(ranges_of_spans(ends(strip) for strip in marks_of(scene)), upon)


def keep_marks(scene: Any, removed: Sequence[FrameRange]) -> None:
    """Marks follow what the EDL has removed now, by whomever."""
    found = read_marks(scene)
    if found.upon != tuple(removed) or found.marks != merged(removed, found):
        lay_marks(scene, removed)


def check_room(scene: Any, removed: Sequence[FrameRange], highest: int) -> None:
    """InputError where `lay_marks` will need a mark and finds no channel; highest: of all other strips by then."""
    if highest >= HIGHEST_CHANNEL and _to_lay(scene, removed)[1]:
        raise _no_channel()


def lay_marks(scene: Any, removed: Sequence[FrameRange]) -> None:
    """Marks over what the EDL has removed, and over what the editor marked and the EDL has not yet.

    Marks that lie right stay the strips they are. InputError, before anything is changed, where there is no channel
    left.
    """
    check_room(scene, removed, _channel(scene) - 1)
    gone, pieces = _to_lay(scene, removed)
    for strip in gone:
        scene.sequence_editor.strips.remove(strip)
    for piece in pieces:
        mark(scene, piece)
    scene[REMOVED_UPON] = to_text(removed)  # from now on marks are read against that


def _to_lay(scene: Any, removed: Sequence[FrameRange]) -> tuple[list[Any], tuple[FrameRange, ...]]:
    """The marks that lie wrong, and the stretches that have none once those are gone."""
    wanted, marks = merged(removed, read_marks(scene)), marks_of(scene)
    gone = [strip for strip in marks if (span := _span(strip)) is not None and without([span], wanted)]
    return gone, without(wanted, ranges_of_spans(ends(strip) for strip in marks if strip not in gone))


def mark(scene: Any, piece: FrameRange) -> None:
    """A mark over programme frames. InputError where there is no channel left for it."""
    taken = {s.channel for s in marks_of(scene) if (span := _span(s)) is not None and span.intersection(piece)}
    channel = next(number for number in count(_channel(scene)) if number not in taken)
    if channel > HIGHEST_CHANNEL:
        raise _no_channel()
    strip = new_effect(scene, "Removed", "ADJUSTMENT", channel, piece.start, piece.stop)
    strip[MARK] = "removed"
    strip.color_multiply, strip.color_tag = _DARK, _COLOUR
    strip.select = False  # the next key would move it
    scene.sequence_editor.channels[strip.channel].name = "Removed"


def unmark(scene: Any, piece: FrameRange) -> bool:
    """Takes the marks away from programme frames; whether any lay there."""
    found = False
    for strip in marks_of(scene):
        start, stop = ends(strip)
        part = span.intersection(piece) if (span := _span(strip)) is not None else None
        if part is None:
            continue
        found = True
        if part.start > start and part.stop < stop:
            split_strip(strip, part.stop)
        if part.start > start:
            set_ends(strip, start, part.start)
        elif part.stop < stop:
            set_ends(strip, part.stop, stop)
        else:
            scene.sequence_editor.strips.remove(strip)
    return found


def _span(strip: Any) -> FrameRange | None:
    """The frames of a mark from the programme's beginning on; None where it lies before that."""
    start, stop = ends(strip)
    return FrameRange(max(start, 0), stop) if stop > max(start, 0) else None


def _channel(scene: Any) -> int:
    """The first above all strips and Conformed, so that a mark lies over whatever is shown."""
    ours = {strip.name for strip in marks_of(scene)}
    others = [strip for strip in scene.sequence_editor.strips if strip.name not in ours]
    return max((strip.channel + (role_of(strip) == "centering") for strip in others), default=0) + 1


def _no_channel() -> InputError:
    return InputError(
        "has no channel left above all strips for the marks over what is removed",
        where="the sequencer",
        remedy="Move your highest strips down",
    )
