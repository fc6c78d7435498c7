# SPDX-License-Identifier: GPL-3.0-or-later
"""What an editor did to our strips lives on when files, shots or poses change: it holds over the same frames. No bpy.

A strip that bears work of the editor (muted, graded, lowered, cut off...) is never made anew. It is cut where the new
files or shots begin and end, and each part is given what stands there now. What no such strip covers is built fresh.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import PurePosixPath
from typing import Any

from attrs import frozen

from mcsl_core.timing import FrameRange, ranges_of_spans, without

from .strip_plan import StripPlan

CONFORMED_SOUND = ("sound-", ".wav")  # how `mcsl conform` names its sound


@frozen
class Place:
    """What stands over a stretch of the programme.

    Attributes
    ----------
    range
        The stretch.
    path, start
        A file, and the programme frame of its first picture or sample; '' where no file is shown.
    value
        What else is to be set there, such as a shot or a transform.
    """

    range: FrameRange
    path: str = ""
    start: int = 0
    value: Any = None


@frozen
class Part:
    """Programme frames [start, stop) of an editor's strip, which may reach outside, and what stands there now."""

    start: int
    stop: int
    place: Place | None


def parts_of(start: int, stop: int, places: Iterable[Place], slip: int = 0) -> tuple[Part, ...]:
    """A strip over [start, stop) cut where ``places`` begin and end: its parts in order, tiling it.

    Parameters
    ----------
    start, stop
        The strip's programme frames.
    places
        What stands there now; where none does, a part has none.
    slip
        By how many frames the editor moved the strip's content: what he moved stays moved.
    """
    near = [p for p in places if p.range.start + slip < stop and p.range.stop + slip > start]
    points = {start, stop}
    for place in near:
        points |= {p for p in (place.range.start + slip, place.range.stop + slip) if start < p < stop}
    cuts = sorted(points)
    parts: list[Part] = []
    for a, b in zip(cuts, cuts[1:], strict=False):
        place = next((p for p in near if p.range.start + slip <= a < p.range.stop + slip), None)
        if parts and parts[-1].place == place:
            parts[-1] = Part(parts[-1].start, b, place)
        else:
            parts.append(Part(a, b, place))
    return tuple(parts)


def main_part(start: int, stop: int, places: Iterable[Place]) -> tuple[Part, ...]:
    """A strip that must stay whole: all of it is given what stands over most of it."""
    parts = parts_of(start, stop, places)
    most = max(parts, key=lambda part: (part.place is not None, part.stop - part.start))
    return (Part(start, stop, most.place),)


def uncovered(places: Iterable[Place], kept: Iterable[tuple[int, int]]) -> tuple[tuple[FrameRange, Place], ...]:
    """What is to be built fresh: the stretches of ``places`` that no strip in ``kept`` covers, in order."""
    holes = ranges_of_spans(kept)
    return tuple((piece, place) for place in places for piece in without([place.range], holes))


# ------------------------------------------------------------------------------------------------------------- sound


def sound_places(plan: StripPlan) -> tuple[Place, ...]:
    """Which file is heard when: the conformed sound throughout, or each file of the chosen camera in its time."""
    lengths = {(file.path, file.start): file.frames for track in plan.cameras for file in track.files}
    places = []
    for index, piece in enumerate(plan.sound):
        stop = piece.start + lengths.get((piece.path, piece.start), plan.frames)
        if index + 1 < len(plan.sound):
            stop = min(stop, plan.sound[index + 1].start)
        start, stop = max(piece.start, 0), min(stop, plan.frames)
        if start < stop:
            places.append(Place(FrameRange(start, stop), piece.path, piece.start))
    return tuple(places)


def is_ours(name: str, plan: StripPlan) -> bool:
    """Whether a sound file of that name is one that mcsl lays into a timeline; others are the editor's."""
    first, last = CONFORMED_SOUND
    media = {PurePosixPath(file.path).name for track in plan.cameras for file in track.files}
    return name in media or (name.startswith(first) and name.endswith(last))


def expected_start(name: str, plan: StripPlan) -> int | None:
    """Where the sound of a file of that name was laid, for a timeline that does not say so itself."""
    first, last = CONFORMED_SOUND
    if name.startswith(first) and name.endswith(last):
        return 0
    return next((f.start for f in plan.cameras[-1].files if PurePosixPath(f.path).name == name), None)


def silent_now(plan: StripPlan, kept: Iterable[tuple[int, int]]) -> tuple[FrameRange, ...]:
    """The frames that have sound in the recording and none in the timeline, because the editor took it out."""
    heard = ((file.start, min(file.start + file.frames, plan.frames)) for file in plan.cameras[-1].files)
    return without(ranges_of_spans(heard), ranges_of_spans(kept))
