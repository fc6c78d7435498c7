# SPDX-License-Identifier: GPL-3.0-or-later
"""What a press of a camera's key does, and which strips bear the colour of an override. No bpy.

The shot at the playhead is the topmost unmuted Multicam strip there, whether or not it is selected: the one that
decides. So a key works while the programme plays, as Blender's own multicam keys do with the active strip.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Container, Iterable, Mapping, Sequence

import attrs
from attrs import frozen

from mcsl_core.edl.resolve import Decisions
from mcsl_core.errors import InputError
from mcsl_core.timing import FrameRange, ranges_of_spans, without

from .corrections import FoundCamera
from .read_overrides import FoundStrip, SequencerState, in_order


@frozen
class Switch:
    """Show channel ``source`` in the strip ``name``: the part from ``split`` on, or all of it (None)."""

    name: str
    source: int
    split: int | None


def deciding(strips: Iterable[FoundStrip], frame: int) -> FoundStrip | None:
    """The strip that decides at a programme frame, or None where the automatic choice holds."""
    there = [s for s in strips if not s.muted and s.start <= frame < s.stop]
    return max(there, key=lambda s: s.channel, default=None)


def muted_over(strips: Sequence[FoundStrip], pieces: Iterable[FrameRange]) -> tuple[tuple[FrameRange, str], ...]:
    """Where in ``pieces`` no shot shows because the one that lies there is muted, and the name of that strip."""
    muted = sorted((s for s in strips if s.muted), key=lambda s: s.channel, reverse=True)
    if not muted:
        return ()
    bare = without(pieces, ranges_of_spans((s.start, s.stop) for s in strips if not s.muted))
    found = []
    for strip in muted:
        rest = without(bare, ranges_of_spans([(strip.start, strip.stop)]))
        found += [(piece, strip.name) for piece in without(bare, rest)]
        bare = rest
    return tuple(sorted(found))


def switch(state: SequencerState, frame: int, camera: str, *, whole: bool = False) -> Switch | None:
    """What to do for a camera to be shown from a frame on.

    Parameters
    ----------
    state
        The sequencer as it is.
    frame
        The playhead, in programme frames.
    camera
        The camera to show, from ``frame`` to the end of the shot there.
    whole
        From the beginning of the shot instead.

    Returns
    -------
    Switch or None
        None where the camera is shown already.

    Raises
    ------
    InputError
        There is no shot at ``frame``, or the camera has no strip that the shot can show.
    """
    strip = deciding(state.strips, frame)
    if strip is None:
        raise InputError(
            "no shot at the playhead", remedy="Add a Multicam strip there, or build the Programme anew from the EDL"
        )
    source = _channel_of(state, camera, frame)
    if source >= strip.channel:
        raise InputError(
            f"{camera} lies on channel {source}, above the shot's own {strip.channel}",
            where=f"strip {strip.name!r}",
            remedy="Move the cameras below the Programme channel",
        )
    if strip.source == source:
        return None
    return Switch(strip.name, source, None if whole or frame == strip.start else frame)


def _channel_of(state: SequencerState, camera: str, frame: int) -> int:
    """The channel of the camera's strip at ``frame``, else of its nearest: a camera may pause."""
    own = [c for c in state.cameras if c.camera == camera]
    if not own:
        raise InputError(f"{camera} has no strip in this timeline", remedy="Build the timeline again")
    return _nearest(own, frame).channel


def _nearest(strips: Sequence[FoundCamera], frame: int) -> FoundCamera:
    return min(strips, key=lambda c: max(c.start - frame, frame - c.stop + 1, 0))


def through_edits(strips: Iterable[FoundStrip], touched: Container[str] = ()) -> tuple[tuple[str, ...], ...]:
    """The names of strips that show and say the same one after another, in order: cuts that nobody sees.

    touched: strips that bear an editor's work; it would be lost, or reach further.
    """
    groups: list[list[FoundStrip]] = []
    for strip in sorted(strips, key=lambda s: (s.channel, s.start)):
        if strip.muted or strip.name in touched:
            continue
        if groups and groups[-1][-1].stop == strip.start and _says_the_same(groups[-1][-1], strip):
            groups[-1].append(strip)
        else:
            groups.append([strip])
    return tuple(tuple(strip.name for strip in group) for group in groups if len(group) > 1)


def _says_the_same(one: FoundStrip, other: FoundStrip) -> bool:
    return attrs.evolve(one, name="", id="", start=0, stop=0) == attrs.evolve(other, name="", id="", start=0, stop=0)


def overridden(decisions: Decisions, strips: Iterable[FoundStrip]) -> frozenset[str]:
    """The names of the strips over which an override holds: ``decisions`` are those that the timeline makes now."""
    starts = [piece.start for piece, _ in decisions]
    names = []
    for strip in strips:
        first = max(bisect_right(starts, strip.start) - 1, 0)
        last = bisect_right(starts, strip.stop - 1)
        if not strip.muted and any(decision.overridden for _, decision in decisions[first:last]):
            names.append(strip.name)
    return frozenset(names)


def replaced(state: SequencerState, was: FoundStrip, parts: Sequence[FoundStrip]) -> SequencerState | None:
    """``state`` with ``parts`` in place of the strip ``was``; None where there is no such strip in it."""
    at = next((index for index, strip in enumerate(state.strips) if strip.name == was.name), None)
    if at is None or state.strips[at] != was:
        return None
    return attrs.evolve(state, strips=in_order((*state.strips[:at], *parts, *state.strips[at + 1 :])))


def with_names(state: SequencerState, renamed: Mapping[str, str]) -> SequencerState:
    """``state`` after strips were given other names: old -> new."""
    if not renamed:
        return state
    strips = (attrs.evolve(s, name=renamed[s.name]) if s.name in renamed else s for s in state.strips)
    return attrs.evolve(state, strips=tuple(strips))


def shown_cameras(state: SequencerState) -> dict[str, str]:
    """What each strip shows where it begins, by the strips' names; those that show no camera are left out."""
    on: dict[int, list[FoundCamera]] = {}
    for camera in state.cameras:
        on.setdefault(camera.channel, []).append(camera)
    alone = {channel: cameras[0].camera for channel, cameras in on.items() if len({c.camera for c in cameras}) == 1}
    return {
        s.name: alone.get(s.source) or _nearest(on[s.source], s.start).camera for s in state.strips if s.source in on
    }
