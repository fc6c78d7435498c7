# SPDX-License-Identifier: GPL-3.0-or-later
"""The sequencer -> SequencerState: what the editor left."""

from __future__ import annotations

import math
from typing import Any

from mcsl_core.errors import InputError

from ..core.corrections import FoundCamera
from ..core.field import FoundDrawing, from_text
from ..core.read_overrides import AUTOMATIC, FoundStrip, SequencerState, in_order
from ..core.similarity import Transform
from ..core.strip_plan import automatic_from_text
from .camera_keys import moved_by_hand
from .centering_keys import keyed_by_hand
from .compat import ends, strips_of
from .marks import read_marks
from .read_times import read_films, read_scene_time
from .scene_properties import (
    AUTOMATIC_CAMERA,
    CAMERA,
    CENTRE,
    DRAWN_FIELDS,
    DRAWN_UPON,
    GIVEN_COLOUR,
    GIVEN_NAME,
    LOOK_FOR_ALL,
    LOOK_OF_SHOT,
    MARK,
    PLANNED_TRANSFORM,
    SHOT_ID,
    SOUND_FROM,
    TRACKS_HASH,
    odd,
    role_of,
    text_of,
)
from .transforms import NUMBERS, transform_from_numbers

_BUILT = {MARK, SHOT_ID, AUTOMATIC_CAMERA, GIVEN_COLOUR, GIVEN_NAME}
FARTHEST_PX = 1e7  # what no transform or centre of a picture reaches


def read_timeline(scene: Any) -> SequencerState:
    """What the editor left: every Multicam strip on every channel, where the cameras are, and the time they run in.

    Raises
    ------
    InputError
        A strip or a property cannot be read; the error names it.
    """
    _check_metas(scene.sequence_editor)
    strips = in_order(read_shot(strip) for strip in strips_of(scene, "MULTICAM"))
    cameras = [_camera(strip) for strip in _others(scene) if role_of(strip) == "camera"]
    return SequencerState(
        strips=strips,
        cameras=tuple(cameras),
        automatic=_automatic(scene),
        look=tuple((aid, _flag(scene, name, "the scene")) for aid, name in LOOK_FOR_ALL.items() if name in scene),
        drawing=read_drawing(scene),
        removal=read_marks(scene),
        sound_from=text_of(scene, SOUND_FROM, "the scene", None),
        notes=_remarks(scene),
        scene=read_scene_time(scene),
        films=read_films(scene),
        tracks=text_of(scene, TRACKS_HASH, "the scene", ""),
    )


def read_about(scene: Any, frame: int) -> SequencerState:
    """Of all that decides, what says which strip and channel show a camera at a programme frame: for a cut by key."""
    _check_metas(scene.sequence_editor)
    shots = [s for s in strips_of(scene, "MULTICAM") if ends(s)[0] <= frame < ends(s)[1]]
    cameras = [_camera(strip) for strip in _others(scene) if role_of(strip) == "camera"]
    return SequencerState(tuple(map(read_shot, shots)), tuple(cameras))


def _others(scene: Any) -> list[Any]:
    return [strip for strip in scene.sequence_editor.strips if strip.type != "MULTICAM"]


def read_shot(strip: Any) -> FoundStrip:
    """A Multicam strip and what it says. InputError where that cannot be read; the error names it."""
    start, stop = ends(strip)
    said = set(strip.keys()) - _BUILT  # a strip as it was built says nothing of its own
    return FoundStrip(
        name=strip.name,
        channel=strip.channel,
        start=start,
        stop=stop,
        source=strip.multicam_source,
        muted=strip.mute,
        **{aid: _switch(strip, name) for aid, name in LOOK_OF_SHOT.items() if name in said},
        offset=_offset(strip) if CENTRE in said else None,
        id=text_of(strip, SHOT_ID, _where, ""),
    )


def _camera(strip: Any) -> FoundCamera:
    start, stop = ends(strip)
    planned = _planned(strip)
    return FoundCamera(
        camera=text_of(strip, CAMERA, _where),
        channel=strip.channel,
        start=start,
        stop=stop,
        name=strip.name,
        # over a movement our keys move it with the playhead, and it says nothing
        transform=None if planned is None else transform_from_numbers([getattr(strip.transform, n) for n in NUMBERS]),
        planned=planned,
    )


def _check_metas(editor: Any) -> None:
    if len(editor.strips) == len(editor.strips_all):
        return
    top = {s.name for s in editor.strips}
    for strip in editor.strips_all:
        if strip.name in top:
            continue
        if strip.type == "MULTICAM":
            raise InputError(
                "is a Multicam strip inside a meta strip, where it has no cameras",
                where=f"strip {strip.name!r}",
                remedy="Separate the meta strip (Ctrl-Alt-G) and save",
            )
        if (role := role_of(strip)) and role != "sound":
            raise InputError(
                f"is a {role} strip of this timeline inside a meta strip, where it cannot be kept up to date",
                where=_where(strip),
                remedy="Separate the meta strip (Ctrl-Alt-G) and save",
            )


def _automatic(scene: Any) -> Any:
    text = text_of(scene, AUTOMATIC_CAMERA, "the scene", "")
    try:
        return automatic_from_text(text) or None if text else None
    except (ValueError, TypeError) as error:
        raise odd(AUTOMATIC_CAMERA, text, "the automatic choice by time", "the scene") from error


def read_drawing(scene: Any) -> FoundDrawing | None:
    """The field drawn by hand that the scene keeps; None where it keeps none."""
    fields = _drawn(scene, DRAWN_FIELDS)
    return None if fields is None else FoundDrawing(fields, _drawn(scene, DRAWN_UPON))


def _drawn(scene: Any, name: str) -> Any:
    text = text_of(scene, name, "the scene", None)
    try:
        return None if text is None else from_text(text)
    except (ValueError, TypeError) as error:
        raise odd(name, text, "outlines of the surgical field", "the scene") from error


def _planned(strip: Any) -> Transform | None:
    value = strip.get(PLANNED_TRANSFORM)
    if value is None:
        return None
    try:
        numbers = [float(number) for number in value]
        if len(numbers) != 5 or not all(abs(n) < FARTHEST_PX for n in numbers) or 0 in numbers[2:4]:
            raise ValueError
    except (TypeError, ValueError) as error:
        raise odd(PLANNED_TRANSFORM, value, "a transform of five numbers", _where(strip)) from error
    return transform_from_numbers(numbers)


def _remarks(scene: Any) -> tuple[str, ...]:
    """What an editor did that is not read, for a person."""
    found = []
    if keyed_by_hand(scene):
        found.append(
            "the Centering strip or its keys were changed by hand, which is not read: to set the centre of a shot, "
            f"use the panel (or the strip's property {CENTRE})"
        )
    if moved := moved_by_hand(scene):
        found.append(
            f"the keys of {_where(moved[0])}, over a movement of the lamp, were changed by hand, which is not read: "
            "move the camera's strips before and after it instead"
        )
    return tuple(found)


def _offset(strip: Any) -> Any:
    """The strip's centre by hand: two numbers to a thousandth of a pixel, AUTOMATIC, or None."""
    value = strip.get(CENTRE)
    if value is None or value == AUTOMATIC:
        return value
    try:
        x, y = (round(float(number), 3) for number in value)
        if not (math.isfinite(x + y) and max(abs(x), abs(y)) < FARTHEST_PX):
            raise ValueError
    except (TypeError, ValueError) as error:
        raise InputError(
            f"has {CENTRE} {value!r}; two numbers [dx, dy] are expected, or {AUTOMATIC!r}",
            where=_where(strip),
            remedy="Correct it among the strip's custom properties, or remove it",
        ) from error
    return x, y


def _switch(strip: Any, name: str) -> bool | None:
    return None if strip.get(name) is None else _flag(strip, name, _where(strip))


def _flag(owner: Any, name: str, where: str) -> bool:
    """On or off; scripts write 0 and 1 for it, in older files whole numbers stand too."""
    value = owner.get(name)
    if not isinstance(value, bool | int) or value not in (0, 1):
        raise odd(name, value, "on or off", where)
    return bool(value)


def _where(strip: Any) -> str:
    return f"strip {strip.name!r}, frame {ends(strip)[0] + 1}"
