# SPDX-License-Identifier: GPL-3.0-or-later
"""EDL -> StripPlan: everything that stands in the sequencer, as plain values. No bpy; the decisions are made here.

Frames are programme frames (0 is the first); the sequencer adds Blender's 1. Channels bottom up: audio, the cameras
with the reference camera last, Programme, Centering, Conformed; above is the editor's own. Offsets are in programme
pixels, x right and y up as Blender has them. The way back is `read_overrides.py`.

A camera's clock drift is not in the preview: the start of each of its files is exact to the frame, within a file
12 ppm come to one frame of 30 after 46 minutes. Conformed pictures follow the drift.
"""

from __future__ import annotations

import hashlib
import json
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Sequence
from fractions import Fraction
from itertools import groupby
from math import ceil
from pathlib import Path
from typing import Any

import attrs
from attrs import field, frozen

from mcsl_core.blender.messages import ConformedPiece
from mcsl_core.edl import Camera, Edl
from mcsl_core.edl.placement import placement_matrix
from mcsl_core.edl.resolve import Decision, DecisionsByPose, resolve, resolve_by_pose, shift_at, sound_camera
from mcsl_core.timing import FrameRange, merge_equal, ranges_of_spans, touching, without

from .camera_places import corrected, planned_transform
from .markers import MarkerPlan, markers_of
from .moving import TransformKey, followed_ranges, moving_keys
from .similarity import Transform

AUDIO_CHANNEL = 1
FIRST_CAMERA_CHANNEL = 2


@frozen
class MoviePiece:
    """A stretch of a camera file with one transform, while the lamp stands in a pose; or with keys, while it moves.

    Attributes
    ----------
    range
        Programme frames.
    transform
        As it is shown; the first key's where there are keys.
    planned
        The transform without any correction; None where there are keys.
    keys
        Where the picture lies while the lamp moves and is followed; they may reach beyond the range.
    """

    range: FrameRange
    transform: Transform
    planned: Transform | None
    keys: tuple[TransformKey, ...] = ()


@frozen
class CameraFile:
    """One file of a camera: its first picture stands at programme frame ``start``, which may lie before 0."""

    path: str
    start: int
    frames: int
    pieces: tuple[MoviePiece, ...]


@frozen
class CameraTrack:
    """A camera's channel. key: the number key that shows it."""

    camera: str
    channel: int
    files: tuple[CameraFile, ...]
    key: int = 0


@frozen
class ProgrammeStrip:
    """One Multicam strip: a stretch of the programme as the EDL has it now, overrides included.

    key: the number key of its camera.
    """

    id: str
    range: FrameRange
    camera: str
    source: int
    automatic: str
    overridden: bool
    key: int = 0


@frozen
class OffsetKey:
    """The Centering strip's offset at a frame; ``hold`` keeps it until the next key instead of moving towards it."""

    frame: int
    x: float
    y: float
    hold: bool = False


@frozen
class SoundPiece:
    """A sound file whose first sample stands at programme frame ``start``."""

    path: str
    start: int


@frozen
class StripPlan:
    """The whole timeline. Paths are as the EDL gives them: relative to the EDL's folder, or absolute."""

    rate: Fraction
    size: tuple[int, int]
    frames: int
    sound: tuple[SoundPiece, ...]
    cameras: tuple[CameraTrack, ...]
    programme_channel: int
    programme: tuple[ProgrammeStrip, ...]
    centering_channel: int
    centering: tuple[OffsetKey, ...]
    conformed_channel: int
    conformed: tuple[ConformedPiece, ...]
    markers: tuple[MarkerPlan, ...]
    automatic: tuple[tuple[FrameRange, str], ...]
    removed: tuple[FrameRange, ...] = ()
    notes: tuple[str, ...] = ()


def make_plan(edl: Edl, conformed: Iterable[ConformedPiece] = (), sound: Path | None = None) -> StripPlan:
    """The timeline of an EDL.

    Parameters
    ----------
    edl
        The decisions, overrides included.
    conformed
        Exact pictures to put in place, in any order.
    sound
        The conformed sound, from frame 0; None takes the own files of the camera whose sound the programme has.
    """
    tracks = camera_tracks(edl)
    channels = {track.camera: track.channel for track in tracks}
    programme_channel = FIRST_CAMERA_CHANNEL + len(tracks)
    heard = sound_camera(edl)
    if sound is not None:
        sounds: tuple[SoundPiece, ...] = (SoundPiece(str(sound), 0),)
    else:
        sounds = tuple(SoundPiece(f.path, f.start) for track in tracks if track.camera == heard for f in track.files)
    return StripPlan(
        rate=edl.rate,
        size=edl.size,
        frames=edl.frames,
        sound=sounds,
        cameras=tracks,
        programme_channel=programme_channel,
        programme=_programme(edl, channels),
        centering_channel=programme_channel + 1,
        centering=offset_keys(edl),
        conformed_channel=programme_channel + 2,
        conformed=tuple(sorted(conformed, key=lambda piece: piece.range)),
        markers=markers_of(edl),
        automatic=automatic_cameras(edl),
        removed=edl.removed,
        notes=tuple(
            f"{c.name} runs at {float(c.rate):.3f} frames/s, the programme at {float(edl.rate):.3f}: "
            "its strips drift from the sound until the stretch is conformed"
            for c in (edl.camera(track.camera) for track in tracks)
            if c.rate != edl.rate
        ),
    )


def camera_tracks(edl: Edl) -> tuple[CameraTrack, ...]:
    """The cameras' channels, the reference camera last."""
    order = [c for c in edl.cameras if c.name != edl.reference] + [edl.camera(edl.reference)]
    keys = key_numbers(edl)
    return tuple(
        CameraTrack(c.name, channel, _files(edl, c), keys[c.name])
        for channel, c in enumerate(order, FIRST_CAMERA_CHANNEL)
    )


def key_numbers(edl: Edl) -> dict[str, int]:
    """Which number key shows a camera: key n is the EDL's n-th."""
    return {camera.name: number for number, camera in enumerate(edl.cameras, 1)}


def strip_name(number: int | str, camera: str, key: int) -> str:
    """What a Programme strip is called: the number of its shot, its camera, and that camera's key."""
    return f"{number}: {camera} [{key}]"


def automatic_cameras(edl: Edl) -> tuple[tuple[FrameRange, str], ...]:
    """The analysis' choice by time, neighbours of one camera joined."""
    return tuple(merge_equal([(shot.range, shot.camera) for shot in edl.shots]))


def automatic_to_text(automatic: Sequence[tuple[FrameRange, str]]) -> str:
    """The automatic choice as the scene keeps it: [[stop, camera], ...], because the pieces tile from 0."""
    return json.dumps([[piece.stop, camera] for piece, camera in automatic], ensure_ascii=False)


def automatic_from_text(text: str) -> tuple[tuple[FrameRange, str], ...]:
    """The inverse of `automatic_to_text`.

    Raises
    ------
    ValueError, TypeError
        The text is not of its making.
    """
    pieces, start = [], 0
    for stop, camera in json.loads(text):
        pieces.append((FrameRange(start, stop), str(camera)))
        start = stop
    return tuple(pieces)


def tracks_key(tracks: Sequence[CameraTrack]) -> str:
    """A hash of what the camera strips are made from: files, ranges and planned transforms.

    Corrections play no part, since they are in the strips already.
    """
    value = [
        [
            t.camera,
            t.channel,
            [[f.path, f.start, f.frames, [_made_from(p) for p in f.pieces]] for f in t.files],
        ]
        for t in tracks
    ]
    return hashlib.sha256(repr(value).encode()).hexdigest()[:16]


def _made_from(piece: MoviePiece) -> list[Any]:
    keys = [[key.frame, key.planned, key.hold] for key in piece.keys]
    return [str(piece.range), keys or piece.planned]


def first_frame(time_s: float, rate: Fraction) -> int:
    """The first programme frame that begins at or after a time: there a picture of that time is first shown.

    Parameters
    ----------
    time_s
        Programme time in seconds.
    rate
        Programme frames a second.
    """
    # A millionth of a frame forgives the float: an offset of exactly 3 frames must not become 4.
    return ceil(time_s * float(rate) - 1e-6)


def _files(edl: Edl, camera: Camera) -> tuple[CameraFile, ...]:
    """A camera's files one after another, each cut at the poses, at movements that are followed and to the programme,
    gaps left out.
    """
    starts, played = [], 0
    for media in camera.media:
        starts.append(first_frame(camera.clock.programme_time(played / camera.rate), edl.rate))
        played += media.frames
    files = []
    places = _places(edl, camera)
    for index, media in enumerate(camera.media):
        stop = starts[index] + media.frames
        if index + 1 < len(starts):
            stop = min(stop, starts[index + 1])
        pieces: list[MoviePiece] = []
        there = without(ranges_of_spans([(starts[index], stop)]), camera.gaps)
        for place in places:
            parts = (place.range.intersection(part) for part in touching(there, place.range.start, place.range.stop))
            pieces += [attrs.evolve(place, range=part) for part in parts if part]
        files.append(CameraFile(media.path, starts[index], media.frames, tuple(pieces)))
    return tuple(files)


def _places(edl: Edl, camera: Camera) -> list[MoviePiece]:
    """Where a camera's picture lies over the whole programme, in order: poses, and between them followed movements."""
    followed = followed_ranges(edl)
    places = []
    for pose in edl.poses:
        planned = planned_transform(edl, camera, pose)
        shown = corrected(edl, camera, pose, planned)
        standing = without([pose.range], (span for span, _ in followed))
        places += [MoviePiece(span, shown, planned) for span in standing]
    for span, movement in followed:
        keys = moving_keys(edl, camera, movement)
        places.append(MoviePiece(span, keys[0].transform, None, keys))
    return sorted(places, key=lambda place: place.range)


def _programme(edl: Edl, channels: dict[str, int]) -> tuple[ProgrammeStrip, ...]:
    shots, keys = iter(edl.shots), key_numbers(edl)
    shot = next(shots)
    strips = []
    for stretch, decision in resolve(edl):
        while stretch.start not in shot.range:
            shot = next(shots)
        strips.append(
            ProgrammeStrip(
                id=f"shot-{stretch.start:07d}",
                range=stretch,
                camera=decision.camera,
                source=channels[decision.camera],
                automatic=shot.camera,
                overridden=decision.overridden,
                key=keys[decision.camera],
            )
        )
    return tuple(strips)


def centred(edl: Edl, by_pose: DecisionsByPose | None = None) -> tuple[tuple[FrameRange, Centring], ...]:
    """How the programme is centred, stretch by stretch; () where it is not. With `Edl.centering` it makes the keys.

    Off as well where a weak camera is shown: its picture stands whole, and the field's place in it is not known.
    by_pose: what `resolve_by_pose` says of ``edl``, where that is known.
    """
    if not edl.centering and all(override.offset is None for override in edl.overrides):
        return ()
    known: dict[tuple[int, str], bool] = {}

    def how(piece: tuple[FrameRange, Decision, int]) -> tuple[Any, ...]:
        _, decision, number = piece
        where = number, decision.camera
        if where not in known:
            known[where] = placement_matrix(edl, edl.poses[number], decision.camera) is not None
        return decision.centering and known[where], decision.offset, decision.eases

    found = []
    for (on, *_), group in groupby(resolve_by_pose(edl) if by_pose is None else by_pose, key=how):
        pieces = list(group)
        found.append((FrameRange(pieces[0][0].start, pieces[-1][0].stop), Centring(on, pieces[0][1])))
    return tuple(found)


def offset_keys(edl: Edl) -> tuple[OffsetKey, ...]:
    """The EDL's keys where centering is on, what was set by hand, zero where it is off; changes lie between frames."""
    states = centred(edl)
    if not states:
        return ()
    if len(states) == 1 and states[0][1].on and states[0][1].decision.offset is None:
        return tuple(OffsetKey(frame, dx, 0.0 - dy) for frame, dx, dy in edl.centering)
    frames = [frame for frame, _, _ in edl.centering]
    keys: list[OffsetKey] = []
    for stretch, state in states:
        last = stretch.stop - 1
        if not state.on:
            keys.append(OffsetKey(stretch.start, 0.0, 0.0, hold=True))
            continue
        if state.decision.offset is None:
            needed = {last, *frames[bisect_right(frames, stretch.start) : bisect_left(frames, last)]}
        else:  # a smooth step is not linear: a key for each of its frames, and one on either side
            eased = [e.range.intersection(FrameRange(stretch.start, stretch.stop)) for e in state.decision.eases]
            needed = {n for e in eased if e for n in range(e.start - 1, e.stop + 1) if n in stretch}
        shifts = [(n, shift_at(edl, state.decision, n)) for n in sorted({stretch.start, *needed})]
        keys.extend(OffsetKey(n, dx, 0.0 - dy) for n, (dx, dy) in shifts)
        keys[-1] = attrs.evolve(keys[-1], hold=True)
    return tuple(keys)


@frozen
class Centring:
    """What the centering of a stretch depends on; equal where it goes on without a break."""

    on: bool
    decision: Decision = field(eq=lambda d: (d.offset, d.eases))
