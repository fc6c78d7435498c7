# SPDX-License-Identifier: GPL-3.0-or-later
"""What stands in the sequencer + EDL -> overrides: the editor's decisions, read by time. No bpy.

At each programme frame the topmost unmuted Multicam strip is what the editor decided; where none lies there is no
decision, and the automatic choice holds. Only where the timeline differs from what the EDL already says does the EDL
change: its overrides lose the frames that no longer agree, new ones take the stretches that differ from the automatic
choice. So an untouched timeline gives the same overrides, to the byte.

The automatic choice to compare with is the one the timeline was built from (it is kept in the scene), so that a
timeline older than the latest analysis does not turn yesterday's automatic cuts into decisions.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from typing import Any, Literal

import attrs
from attrs import frozen

from mcsl_core.edl import Edl, Override
from mcsl_core.edl.checks import NO_SOUND
from mcsl_core.errors import InputError
from mcsl_core.timing import FrameRange

from .corrections import FoundCamera, read_corrections
from .field import FoundDrawing, take_drawing
from .removal import NO_MARKS, FoundRemoval, take_removal
from .strip_plan import automatic_cameras
from .times import FoundFilm, FoundShot, SceneTime, check_times

FIELDS = ("camera", "centering", "fill", "colour", "surface", "see_through", "offset")
READ = ("camera", "centering", "fill", "colour", "surface", "see_through", "offset")  # what a Programme strip can say
AUTOMATIC = "automatic"  # said of a centre: no longer by hand


@frozen
class FoundStrip:
    """A Multicam strip as found.

    Attributes
    ----------
    start, stop
        The programme frames [start, stop) that it covers; they may reach outside the programme.
    source
        The channel it shows.
    centering, fill, colour, surface, see_through
        The editor's switch on this strip; None says nothing.
    offset
        The centre by hand, (dx, dy) in programme pixels, y down; AUTOMATIC takes one back, None says nothing.
    id
        Where it was built; '' for the editor's own.
    """

    name: str
    channel: int
    start: int
    stop: int
    source: int
    muted: bool = False
    centering: bool | None = None
    fill: bool | None = None
    colour: bool | None = None
    surface: bool | None = None
    see_through: bool | None = None
    offset: tuple[float, float] | Literal["automatic"] | None = None
    id: str = ""


@frozen
class SequencerState:
    """All in the sequencer that decides.

    Attributes
    ----------
    strips, cameras
        Multicam strips on every channel, `in_order`, and camera strips.
    automatic
        The automatic choice that the timeline was built from; None where it is not known: then the EDL's holds.
    look
        What was switched for the whole programme: centering, fill, colour, surface or seeing through, and to what.
    drawing
        The surgical field drawn by hand since the EDL was written; None where nothing was.
    removal
        The marks over what is removed from the delivery.
    sound_from
        The camera whose sound was chosen, "none", or "" for the automatic choice; None where nothing was chosen.
    notes
        What was seen and is not read, for a person.
    scene, films, tracks
        What says whether the timeline still runs in the programme's time; see core/times.py.
    """

    strips: tuple[FoundStrip, ...]
    cameras: tuple[FoundCamera, ...]
    automatic: tuple[tuple[FrameRange, str], ...] | None = None
    look: tuple[tuple[str, bool], ...] = ()
    drawing: FoundDrawing | None = None
    removal: FoundRemoval = NO_MARKS
    sound_from: str | None = None
    notes: tuple[str, ...] = ()
    scene: SceneTime | None = None
    films: tuple[FoundFilm, ...] = ()
    tracks: str = ""


def in_order(strips: Iterable[FoundStrip]) -> tuple[FoundStrip, ...]:
    """By time: Blender keeps them in the order in which they came to be."""
    return tuple(sorted(strips, key=lambda strip: (strip.start, strip.channel)))


def read_edl(edl: Edl, state: SequencerState) -> Edl:
    """``edl`` with the editor's decisions as the sequencer shows them; equal to it where nothing was decided anew.

    Raises
    ------
    InputError
        A strip cannot be read, or time was changed; the error names the strip and the frame.
    """
    shots = (FoundShot(s.id, s.name, s.start, s.stop) for s in state.strips if s.id)
    check_times(edl, state.scene, state.films, shots, state.tracks)
    look = attrs.evolve(edl.look, **dict(state.look))
    drawn = take_drawing(edl, state.drawing).fields
    removed, heard = take_removal(edl, state.removal), _sound_from(edl, state.sound_from)
    if (look, drawn, removed, heard) != (edl.look, edl.drawn_fields, edl.removed, edl.audio_from):
        edl = edl.redecided(look=look, drawn_fields=drawn, removed=removed, audio_from=heard)
    overrides, corrections = read_overrides(edl, state), read_corrections(edl, state.cameras)
    if (overrides, corrections) == (edl.overrides, edl.corrections):
        return edl
    return edl.redecided(overrides=overrides, corrections=corrections)


def _sound_from(edl: Edl, chosen: str | None) -> str | None:
    if chosen is None:
        return edl.audio_from
    names = [camera.name for camera in edl.cameras]
    if chosen not in ("", NO_SOUND, *names):
        raise InputError(
            f"the timeline takes the sound of {chosen!r}, which is not a camera of the EDL",
            remedy=f"Choose one of {', '.join(names)} or {NO_SOUND} under Render",
        )
    return chosen or None


def read_overrides(edl: Edl, state: SequencerState) -> tuple[Override, ...]:
    """The EDL's overrides after the editor's work, in the order in which they hold.

    Raises
    ------
    InputError
        A strip cannot be read, or the timeline was built for a programme of another length.
    """
    automatic = state.automatic if state.automatic is not None else automatic_cameras(edl)
    if automatic[-1][0].stop != edl.frames:
        raise InputError(
            f"the timeline was built for {automatic[-1][0].stop} frames, the EDL has {edl.frames}",
            remedy="Build the timeline again with `mcsl timeline`",
        )
    segments = _Segments(edl.frames, _all_ranges(edl, state, automatic))
    top = segments.paint([(s.start, s.stop, s) for s in sorted(state.strips, key=lambda s: s.channel) if not s.muted])
    changes = {"camera": _camera_changes(edl, state, segments, top, automatic)}
    for name in READ[1:]:
        changes[name] = _look_changes(edl, name, segments, top)
    kept = [piece for override in edl.overrides for piece in _less(override, segments, changes)]
    return _with_new(kept, _new_decisions(segments, changes))


class _Segments:
    """The programme cut at every range's ends: within a segment nothing begins or ends."""

    def __init__(self, frames: int, ranges: Iterable[tuple[int, int]]) -> None:
        points = {0, frames}
        for start, stop in ranges:
            points.update(p for p in (start, stop) if 0 < p < frames)
        self.points = sorted(points)
        self.frames = frames
        self.count = len(self.points) - 1

    def within(self, start: int, stop: int) -> range:
        """Indices of the segments in [start, stop), which may reach outside the programme."""
        return range(
            bisect_left(self.points, min(max(start, 0), self.frames)),
            bisect_left(self.points, min(max(stop, 0), self.frames)),
        )

    def paint(self, layers: Iterable[tuple[int, int, Any]], ground: Any = None) -> list[Any]:
        """The value of the last layer over each segment."""
        values = [ground] * self.count
        for start, stop, value in layers:
            for index in self.within(start, stop):
                values[index] = value
        return values

    def runs(
        self, values: Sequence[Any] | Mapping[int, Any], among: range | None = None
    ) -> Iterator[tuple[FrameRange, Any]]:
        """Neighbouring segments of equal value as one range."""
        for value, group in groupby(among or range(self.count), key=lambda index: values[index]):
            indices = list(group)
            yield FrameRange(self.points[indices[0]], self.points[indices[-1] + 1]), value


def _all_ranges(
    edl: Edl, state: SequencerState, automatic: Iterable[tuple[FrameRange, str]]
) -> Iterator[tuple[int, int]]:
    for strip in (*state.strips, *state.cameras):
        yield strip.start, strip.stop
    for piece, _ in automatic:
        yield piece.start, piece.stop
    for override in edl.overrides:
        yield override.range.start, override.range.stop


@frozen
class _Change:
    """At a segment the EDL's decision no longer holds; ``value`` takes its place, None leaves it to the analysis."""

    value: str | bool | None


def _said(edl: Edl, name: str) -> list[tuple[int, int, Any]]:
    """The overrides' layers of one field, in their order."""
    return [(o.range.start, o.range.stop, value) for o in edl.overrides if (value := getattr(o, name)) is not None]


def _camera_changes(
    edl: Edl,
    state: SequencerState,
    segments: _Segments,
    top: Sequence[FoundStrip | None],
    automatic: Iterable[tuple[FrameRange, str]],
) -> list[_Change | None]:
    ground = segments.paint([(piece.start, piece.stop, camera) for piece, camera in automatic])
    said = segments.paint(_said(edl, "camera"))
    known = {camera.name for camera in edl.cameras}
    shown_on = _Sources(state, known)
    changes: list[_Change | None] = [None] * segments.count
    for index, strip in enumerate(top):
        if strip is None:
            changes[index] = _Change(None) if said[index] is not None else None
            continue
        shown = shown_on.camera_of(strip, segments.points[index])
        if shown != (ground[index] if said[index] is None else said[index]):
            changes[index] = _Change(None if shown == ground[index] else shown)
    return changes


class _Sources:
    """Which camera each channel shows."""

    def __init__(self, state: SequencerState, known: set[str]) -> None:
        self._known = known
        self._on: dict[int, list[FoundCamera]] = {}
        for camera in state.cameras:
            self._on.setdefault(camera.channel, []).append(camera)
        names = {channel: {c.camera for c in on} for channel, on in self._on.items()}
        self._alone = {channel: min(own) for channel, own in names.items() if len(own) == 1 and own <= known}

    def camera_of(self, strip: FoundStrip, frame: int) -> str:
        """The camera on the strip's source channel at ``frame``. InputError where that is not one camera of the EDL."""
        return self._alone.get(strip.source) or self._gathered(strip, frame)

    def _gathered(self, strip: FoundStrip, frame: int) -> str:
        """The editor gathered cameras in one channel: what lies there at this frame counts."""
        on_channel = self._on.get(strip.source, [])
        names = {c.camera for c in on_channel}
        if len(names) > 1:
            names = {c.camera for c in on_channel if c.start <= frame < c.stop}
        if len(names) == 1 and names <= self._known:
            return min(names)
        if not on_channel:
            what = f"shows channel {strip.source}, which holds no camera"
        elif len(names) == 1:
            what = f"shows {min(names)!r}, which is not a camera of the EDL ({', '.join(sorted(self._known))})"
        else:
            what = f"shows channel {strip.source}, which holds {'no' if not names else 'more than one'} camera here"
        channels = ", ".join(map(str, sorted(self._on)))
        raise InputError(
            what,
            where=f"strip {strip.name!r}, programme frame {frame} (Blender's frame {frame + 1})",
            remedy=f"Set its channel to one of the cameras' ({channels or 'none is left'})",
        )


def _look_changes(edl: Edl, name: str, segments: _Segments, top: Sequence[FoundStrip | None]) -> list[_Change | None]:
    changes: list[_Change | None] = [None] * segments.count
    if all(strip is None or getattr(strip, name) is None for strip in top):
        return changes
    ground = getattr(edl.look, name, AUTOMATIC)
    holds = segments.paint(_said(edl, name), ground)
    for index, strip in enumerate(top):
        shown = None if strip is None else getattr(strip, name)
        if shown is not None and shown != holds[index]:
            changes[index] = _Change(None if shown == ground else shown)
    return changes


def _less(override: Override, segments: _Segments, changes: dict[str, list[_Change | None]]) -> Iterator[Override]:
    """``override`` without what the timeline no longer shows; itself where nothing changed."""
    among = segments.within(override.range.start, override.range.stop)
    given = [name for name in READ if getattr(override, name) is not None]
    lost = {index: frozenset(name for name in given if changes[name][index] is not None) for index in among}
    if not any(lost.values()):
        yield override
        return
    for stretch, gone in segments.runs(lost, among):
        if any(getattr(override, n) is not None for n in FIELDS if n not in gone):
            yield attrs.evolve(override, range=stretch, **dict.fromkeys(gone))


def _new_decisions(
    segments: _Segments, changes: dict[str, list[_Change | None]]
) -> list[tuple[FrameRange, dict[str, Any]]]:
    """Maximal stretches of one new decision, those of the same range together, by time."""
    by_range: dict[FrameRange, dict[str, Any]] = {}
    for name in READ:
        for stretch, change in segments.runs(changes[name]):
            if change is not None and change.value is not None:
                by_range.setdefault(stretch, {})[name] = change.value
    return sorted(by_range.items(), key=lambda item: item[0])


def _with_new(kept: Sequence[Override], new: list[tuple[FrameRange, dict[str, Any]]]) -> tuple[Override, ...]:
    """``kept`` and the new decisions: a neighbour that says just the same grows, the rest comes after."""
    result: list[Override | None] = list(kept)
    ends: dict[tuple[str, int], list[int]] = {}
    for index, override in enumerate(kept):
        ends.setdefault(("stop", override.range.stop), []).append(index)
        ends.setdefault(("start", override.range.start), []).append(index)
    for stretch, given in new:
        before = _same(result, ends.get(("stop", stretch.start), ()), given, stretch.start - 1)
        after = _same(result, ends.get(("start", stretch.stop), ()), given, stretch.stop)
        first, last = (None if index is None else result[index] for index in (before, after))
        if first is not None and before is not None:
            stop = stretch.stop
            if last is not None and after is not None and last.note == first.note and _alone(result, after):
                stop, result[after] = last.range.stop, None
                ends.setdefault(("stop", stop), []).append(before)
            result[before] = attrs.evolve(first, range=FrameRange(first.range.start, stop))
        elif last is not None and after is not None:
            result[after] = attrs.evolve(last, range=FrameRange(stretch.start, last.range.stop))
        else:
            result.append(Override(range=stretch, **given))
    return tuple(override for override in result if override is not None)


def _same(
    overrides: Sequence[Override | None], candidates: Iterable[int], given: dict[str, Any], frame: int
) -> int | None:
    """The candidate that gives just ``given`` and is what the viewer gets at ``frame``."""
    for index in candidates:
        override = overrides[index]
        if override is None or frame not in override.range:
            continue
        later = (o for o in overrides[index + 1 :] if o is not None and frame in o.range)
        hidden = any(getattr(o, name) is not None for o in later for name in given)
        if not hidden and all(getattr(override, name) == given.get(name) for name in FIELDS):
            return index
    return None


def _alone(overrides: Sequence[Override | None], index: int) -> bool:
    """Whether no other override decides the same fields over the range: only then its place in the list is free."""
    mine = overrides[index]
    assert mine is not None
    fields = [name for name in FIELDS if getattr(mine, name) is not None]
    return not any(
        o.range.intersection(mine.range) and any(getattr(o, name) is not None for name in fields)
        for i, o in enumerate(overrides)
        if o is not None and i != index
    )
