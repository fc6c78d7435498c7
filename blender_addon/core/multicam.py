# SPDX-License-Identifier: GPL-3.0-or-later
"""What a press of a camera's key does, and which strips bear the colour of an override. No bpy.

The shot at the playhead is the topmost unmuted Multicam strip there, whether or not it is selected: the one that
decides. So a key works while the programme plays, as Blender's own multicam keys do with the active strip.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Sequence

from attrs import frozen

from mcsl_core.edl import Edl
from mcsl_core.edl.resolve import resolve
from mcsl_core.errors import InputError

from .corrections import FoundCamera
from .read_overrides import FoundStrip, SequencerState


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


def switch(state: SequencerState, frame: int, camera: str, *, whole: bool = False) -> Switch | None:
    """What to do for ``camera`` to be shown from ``frame`` to the end of the shot there, or in ``whole`` of it.

    None where it is shown already. InputError where there is no shot, or the camera has no strip to be shown from.
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


def overridden(edl: Edl, strips: Iterable[FoundStrip]) -> frozenset[str]:
    """The names of the strips over which an override of ``edl`` holds: the EDL as the timeline decides it now."""
    decisions = resolve(edl)
    starts = [piece.start for piece, _ in decisions]
    names = []
    for strip in strips:
        first = max(bisect_right(starts, strip.start) - 1, 0)
        last = bisect_right(starts, strip.stop - 1)
        if not strip.muted and any(decision.overridden for _, decision in decisions[first:last]):
            names.append(strip.name)
    return frozenset(names)


def shown_cameras(state: SequencerState) -> dict[str, str]:
    """What each strip shows where it begins, by the strips' names; those that show no camera are left out."""
    on: dict[int, list[FoundCamera]] = {}
    for camera in state.cameras:
        on.setdefault(camera.channel, []).append(camera)
    return {s.name: _nearest(on[s.source], s.start).camera for s in state.strips if s.source in on}
