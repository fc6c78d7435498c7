# SPDX-License-Identifier: GPL-3.0-or-later
"""A timeline brought up to date: what follows from decisions is made anew, what an editor did to it stays.

Strips as they were built are replaced. One that bears work of the editor stays the strip it is, so that nothing of it
can be forgotten, and is given its new shot, file or place; his own strips are only moved up where ours need room.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from mcsl_core.errors import InputError
from mcsl_core.timing import FrameRange

from ..core.carry_over import Part, Place, main_part, parts_of, uncovered
from ..core.strip_plan import FIRST_CAMERA_CHANNEL, CameraTrack, StripPlan, automatic_to_text, strip_name, tracks_key
from . import conformed
from .build import build_camera, deselect, lay_centering, lay_shot, name_channel, set_shot
from .camera_keys import follow_movements, place_camera
from .centering_keys import set_centering_keys
from .compat import ends, set_ends, strips_of
from .edit import HIGHEST_CHANNEL, effect_inputs, remove, split_at
from .films import link_film
from .marks import check_room, lay_marks, marks_of
from .scene_properties import (
    AUTOMATIC_CAMERA,
    CAMERA,
    GIVEN_NAME,
    TRACKS_HASH,
    given_name,
    role_of,
)
from .sound import renew_sound
from .touched import Work


def rebuild_timeline(scene: Any, plan: StripPlan, base: Path, *, exact: bool = False) -> list[str]:
    """Programme, Centering, Conformed and sound from ``plan``; what the editor made of them, and his own strips, stay.

    The camera strips stay as well, unless the EDL's cameras, files or poses are others than when they were made. Where
    one of the editor's strips lies on our channels, all of them move up together, keeping their order. Returns what
    there is to say. exact: the conformed pictures in place still hold and stay, whatever the plan has. InputError,
    before anything is changed, where Blender has too few channels for it.
    """
    editor = scene.sequence_editor
    others = scene.get(TRACKS_HASH) not in (None, tracks_key(plan.cameras))
    cameras = {s[CAMERA] for s in editor.strips if role_of(s) == "camera"}
    was = FIRST_CAMERA_CHANNEL + len(cameras)  # the Programme's channel until now
    work = Work(scene)
    kept, gone = {name: [] for name in ("programme", "centering", "camera")}, []
    for strip in editor.strips:
        role = "programme" if strip.type == "MULTICAM" and not strip.mute else role_of(strip)
        if role not in kept or (role == "camera" and not others):
            continue
        goes = (strip.type == "MULTICAM" and strip.mute) or not work.on(strip)
        (gone if goes else kept[role]).append(strip)
    _check_room(scene, plan, was, gone)
    for strip in gone:
        editor.strips.remove(strip)
    notes = _make_room(scene, plan, was)
    if others:
        notes.append("the EDL has other cameras, files or poses than this timeline: its camera strips were made anew")
        notes.extend(_cameras(scene, plan, base, kept["camera"]))
    else:
        follow_movements(scene, plan.cameras)
    for above, name in enumerate(("Programme", "Centering", "Conformed")):
        name_channel(scene, plan.programme_channel + above, name)
    _programme(scene, plan, kept["programme"])
    _centering(scene, plan, kept["centering"])
    if not exact:
        for _ in conformed.renew(scene, plan.conformed, plan.conformed_channel, base):
            pass
    notes.extend(renew_sound(scene, plan, base))
    scene[AUTOMATIC_CAMERA] = automatic_to_text(plan.automatic)
    lay_marks(scene, plan.removed)
    deselect(scene)
    return notes


def lay_missing(scene: Any, plan: StripPlan, piece: FrameRange) -> None:
    """Programme strips over what of ``piece`` has none any more, where the preview shows what nobody chose.

    A muted one is the editor's doing and keeps its place; on other channels it stands in nobody's way.
    """
    strips = scene.sequence_editor.strips
    sources = {strip[CAMERA]: strip.channel for strip in strips if role_of(strip) == "camera"}  # an editor moves tracks
    channels = [strip.channel for strip in strips if role_of(strip) == "programme" and not strip.mute]
    channel = channels[0] if channels else plan.programme_channel
    there = [ends(strip) for strip in strips_of(scene, "MULTICAM") if not strip.mute or strip.channel == channel]
    for span, place in _shots_without(plan, there):
        number, shot = place.value
        if (part := span.intersection(piece)) and shot.camera in sources:
            shot = attrs.evolve(shot, source=sources[shot.camera])
            lay_shot(scene, number, shot, channel, part)
    deselect(scene)


def _shots_without(plan: StripPlan, spans: Iterable[tuple[int, int]]) -> Iterable[tuple[FrameRange, Place]]:
    """The shots, numbered, over what no span covers."""
    return uncovered([Place(shot.range, value=(number, shot)) for number, shot in enumerate(plan.programme, 1)], spans)


def _check_room(scene: Any, plan: StripPlan, was: int, gone: Sequence[Any]) -> None:
    """InputError where the editor's strips, or marks above them, would need more channels than there are."""
    above, lift = _above(scene, plan, was, gone)
    if lift and above[-1].channel + lift > HIGHEST_CHANNEL:
        raise InputError(
            "has no channel left above Conformed for your strips",
            where=f"strip {above[-1].name!r} on channel {above[-1].channel}",
            remedy="Move your highest strips down",
        )
    marks = marks_of(scene)
    highest = max((strip.channel + lift for strip in above if strip not in marks), default=0)
    check_room(scene, plan.removed, max(plan.conformed_channel, highest))


def _above(scene: Any, plan: StripPlan, was: int, gone: Sequence[Any] = ()) -> tuple[list[Any], int]:
    """The editor's strips on our channels or above, the lowest first, and by how many channels they have to move up."""
    lowest = min(plan.programme_channel, was)
    strips = [s for s in scene.sequence_editor.strips if role_of(s) in ("", "removed") and s.channel >= lowest]
    above = sorted((s for s in strips if s not in gone), key=_by_channel)
    return above, max(0, plan.conformed_channel + 1 - above[0].channel) if above else 0


def _make_room(scene: Any, plan: StripPlan, was: int) -> list[str]:
    """Our strips that stay, and the editor's above, move to where the plan has room for them; a remark if his did."""
    editor, notes = scene.sequence_editor, []
    shift = plan.programme_channel - was
    ours = [s for s in editor.strips if role_of(s) in ("programme", "centering", "conformed")]
    above, lift = _above(scene, plan, was)
    moves = {s.channel: shift for s in ours if shift} | ({s.channel: lift for s in above} if lift else {})
    if lift:
        _move(above, lift)
        notes.append(f"your strips moved up by {lift} channels, to lie above the Conformed channel")
    _move(ours, shift)
    _move_channels(editor.channels, moves)
    return notes


def _move(strips: Sequence[Any], by: int) -> None:
    """All strips by as many channels, in an order in which each finds its new place free."""
    for strip in sorted(strips, key=_by_channel, reverse=by > 0) if by else ():
        strip.channel += by


def _move_channels(channels: Any, moves: Mapping[int, int]) -> None:
    """Muted and locked goes with the strips: what was hidden or silent must not come out."""
    states = {old: (channels[old].name, channels[old].mute, channels[old].lock) for old in moves}
    for old in moves:
        channels[old].mute = channels[old].lock = False
    for old, by in moves.items():
        channel = channels[old + by]
        channel.name, channel.mute, channel.lock = states[old]


def _cameras(scene: Any, plan: StripPlan, base: Path, kept: Iterable[Any]) -> list[str]:
    """The camera strips anew; those that bear work of the editor keep it, over the same frames of the same camera."""
    scene[TRACKS_HASH] = tracks_key(plan.cameras)
    notes = []
    by_camera: dict[str, list[Any]] = {}
    for strip in kept:
        by_camera.setdefault(strip[CAMERA], []).append(strip)
    for track in plan.cameras:
        strips = by_camera.pop(track.camera, [])
        for strip in strips:
            strip.channel = track.channel
        spans = [ends(strip) for strip in strips]
        notes.extend(build_camera(scene, track, base, spans))
        for strip in strips:
            _renew_camera(scene, strip, track, base)
    for name, strips in by_camera.items():
        for strip in strips:
            notes.append(f"{name} is gone from the EDL, and with it your work on its strip {strip.name!r}")
            remove(scene, strip)
    return notes


def _renew_camera(scene: Any, strip: Any, track: CameraTrack, base: Path) -> None:
    places = [
        Place(piece.range, file.path, file.start, piece)
        for file in track.files
        for piece in file.pieces
        if piece.range.start < file.start + file.frames
    ]
    for part, place in _cut(scene, strip, places):
        if not link_film(scene, part, base / place.path, place.start):
            part.mute = True  # under an effect, over the end of a file: it cannot be cut there
        place_camera(scene, part, place.value)


def _programme(scene: Any, plan: StripPlan, kept: Sequence[Any]) -> None:
    """A Multicam strip for each shot, but where an editor's strip lies: that shows the shot in its part."""
    places = [Place(shot.range, value=(number, shot)) for number, shot in enumerate(plan.programme, 1)]
    spans = [ends(strip) for strip in kept]
    for strip in kept:
        his_name = not strip.name.startswith(given_name(strip) or "\0")
        for part, place in _cut(scene, strip, places):
            number, shot = place.value
            if not his_name:
                part.name = part[GIVEN_NAME] = strip_name(number, shot.camera, shot.key)
            set_shot(part, shot)
    for span, place in _shots_without(plan, spans):
        number, shot = place.value
        lay_shot(scene, number, shot, plan.programme_channel, span)


def _centering(scene: Any, plan: StripPlan, kept: Sequence[Any]) -> None:
    """The Adjustment strip over the whole programme; an editor's strip, or the pieces he cut it to, stay."""
    if len(kept) == 1:
        set_ends(kept[0], 0, plan.frames)
    for span, _ in uncovered([Place(FrameRange(0, plan.frames))], [ends(strip) for strip in kept]):
        lay_centering(scene, plan.centering_channel, span.start, span.stop)
    set_centering_keys(scene, plan.centering)


def _cut(scene: Any, strip: Any, places: Iterable[Place]) -> Iterator[tuple[Any, Place]]:
    """The parts of an editor's strip and what each is to show; a part where nothing stands any more goes."""
    whole = strip.name in effect_inputs(scene)
    parts: tuple[Part, ...] = (main_part if whole else parts_of)(*ends(strip), places)
    for piece, part in zip(split_at(strip, [part.stop for part in parts[:-1]]), parts, strict=True):
        if part.place is None:
            remove(scene, piece)
        else:
            yield piece, part.place


def _by_channel(strip: Any) -> int:
    return strip.channel
