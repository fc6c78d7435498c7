# SPDX-License-Identifier: GPL-3.0-or-later
"""Strips cut, switched and labelled, as decided in `core`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from mcsl_core.edl import DrawnField, Look
from mcsl_core.edl.playlists import list_kind
from mcsl_core.errors import BlenderError, InputError

from ..core.field import to_text
from ..core.multicam import Switch
from ..core.read_overrides import AUTOMATIC
from ..core.revert import Setting
from ..core.strip_plan import strip_name
from .compat import ends, selected_strips, set_ends, strips_of
from .scene_properties import (
    CENTRE,
    DRAWN_FIELDS,
    DRAWN_UPON,
    GIVEN_COLOUR,
    GIVEN_NAME,
    LOOK_FOR_ALL,
    LOOK_OF_SHOT,
    SOUND_FROM,
    given_name,
)

HIGHEST_CHANNEL = 128  # Blender has no more
OVERRIDDEN_COLOUR = "COLOR_03"  # yellow: an editor's decision
CAMERA_COLOURS = tuple(f"COLOR_0{n}" for n in (5, 4, 6, 8, 7, 1, 2, 9))  # by key: blue, green, ...


def check_there(path: Path) -> None:
    """InputError where a media file is missing."""
    if not path.is_file():
        raise InputError("is missing", where=str(path), remedy="Put the file back, or correct the EDL's media paths")
    if kind := list_kind(path):  # Blender would open what it leads to
        raise InputError(f"is {kind}; what it leads to is not opened", where=str(path), remedy="Name the video itself")


def split_strip(strip: Any, frame: int) -> Any:
    """The right part of ``strip`` cut at a programme frame; ``strip`` keeps the left. Locked, both parts are."""
    channel = (strip.parent_meta() or strip.id_data.sequence_editor).channels[strip.channel]
    locked = [owner for owner in (channel, strip) if owner.lock]
    right = None
    for owner in locked:  # a lock is for hands, and Blender minds it here as well
        owner.lock = False
    try:
        right = strip.split(frame=frame + 1, split_method="SOFT")
    finally:
        for owner in locked:
            owner.lock = True
        if right is not None and strip.lock:
            right.lock = True
    if right is None:
        raise BlenderError(f"strip {strip.name!r} cannot be split at frame {frame + 1}")
    return right


def split_at(strip: Any, frames: Sequence[int]) -> list[Any]:
    """The parts of ``strip`` cut at programme frames, which rise and lie inside it; in order."""
    parts = [strip]
    for frame in frames:
        parts.append(split_strip(parts[-1], frame))
    return parts


def effect_inputs(scene: Any) -> set[str]:
    """The names of strips that an effect strip is made of. Never split one: Blender then copies all that hang together,
    and what one held of them is gone from memory.
    """
    return {
        strip.name
        for effect in scene.sequence_editor.strips_all
        for strip in (getattr(effect, "input_1", None), getattr(effect, "input_2", None))
        if strip is not None
    }


def remove(scene: Any, strip: Any) -> None:
    """Removes a strip, out of its meta strip where it lies in one."""
    meta = strip.parent_meta()
    (scene.sequence_editor if meta is None else meta).strips.remove(strip)


@contextmanager
def parked(scene: Any, strip: Any) -> Iterator[None]:
    """The strip lies on a free channel meanwhile: while its ends move it must not push, nor be pushed by, others.

    Its keys stay where they are in time: moving content takes them along.
    """
    channel, keys = strip.channel, keys_of(scene, strip.name)
    used = max(other.channel for other in scene.sequence_editor.strips_all)
    strip.channel = min(used + 1, HIGHEST_CHANNEL)
    try:
        yield
    finally:
        strip.channel = channel
        for curve, points in keys.items():
            for point, at in zip(curves_of(scene)[curve].keyframe_points, points, strict=True):
                point.co_ui = at
            curves_of(scene)[curve].update()


def keys_of(scene: Any, name: str) -> dict[str, list[tuple[float, float]]]:
    """The keys of a strip: data path -> (frame, value)."""
    return {
        path: [tuple(point.co) for point in curve.keyframe_points]
        for path, curve in curves_of(scene).items()
        if path.startswith(f'sequence_editor.strips_all["{name}"]')
    }


def curves_of(scene: Any) -> dict[str, Any]:
    """The scene's F-curves by data path; those of an array's elements are apart by their index."""
    data = scene.animation_data
    found: dict[str, Any] = {}
    for layer in data.action.layers if data is not None and data.action is not None else ():
        for part in layer.strips:
            bag = part.channelbag(data.action_slot) if data is not None and data.action_slot else None
            for curve in bag.fcurves if bag is not None else ():
                found[curve.data_path if curve.array_index == 0 else f"{curve.data_path}[{curve.array_index}]"] = curve
    return found


def apply_switch(scene: Any, change: Switch) -> list[Any]:
    """Cuts and switches as decided; the part that is shown from now on becomes the active strip, alone selected.

    Returns the parts of the strip that was there.
    """
    parts = [scene.sequence_editor.strips[change.name]]
    if change.split is not None:
        parts.append(split_strip(parts[0], change.split))
    strip = parts[-1]
    strip.multicam_source = change.source
    for other in selected_strips(scene):
        other.select = False
    strip.select = True
    scene.sequence_editor.active_strip = strip
    return parts


def join(scene: Any, groups: Iterable[Sequence[str]]) -> int:
    """The first strip of each group lasts to the end of its last, the others go; how many cuts that takes away."""
    strips = {strip.name: strip for strip in strips_of(scene, "MULTICAM")}
    joined = 0
    for group in groups:
        first, *others = (strips[name] for name in group)
        start, stop = ends(first)[0], ends(others[-1])[1]
        for strip in others:
            scene.sequence_editor.strips.remove(strip)
        set_ends(first, start, stop)
        joined += len(others)
    return joined


def apply_settings(scene: Any, settings: Mapping[str, Sequence[Setting]], look: Look) -> None:
    """Strips cut and set as core/revert.py decided; in what is set, look and centre are the programme's again."""
    for name, parts in settings.items():
        cuts = [part.range.stop for part in parts[:-1]]
        for strip, part in zip(split_at(scene.sequence_editor.strips[name], cuts), parts, strict=True):
            if part.source is not None:
                strip.multicam_source = part.source
                _clear_decisions(strip)
                for aid in part.said & LOOK_OF_SHOT.keys():
                    strip[LOOK_OF_SHOT[aid]] = getattr(look, aid)
                if "offset" in part.said:
                    strip[CENTRE] = AUTOMATIC


def clear_strip_decisions(scene: Any) -> None:
    """The EDL holds all that strips and scene said beside cuts: from now on they say nothing of their own."""
    for strip in scene.sequence_editor.strips:
        if strip.type == "MULTICAM":
            _clear_decisions(strip)
    for name in (*LOOK_FOR_ALL.values(), SOUND_FROM):
        scene.pop(name, None)
    drop_drawing(scene)


def keep_drawing(scene: Any, fields: Sequence[DrawnField], upon: Sequence[DrawnField]) -> None:
    """The scene keeps the field drawn by hand until it is in the EDL, and what the EDL has: ``upon``."""
    scene[DRAWN_FIELDS], scene[DRAWN_UPON] = to_text(fields), to_text(upon)


def drop_drawing(scene: Any) -> None:
    """The EDL has the field that was drawn: the scene says nothing of it any more."""
    for name in (DRAWN_FIELDS, DRAWN_UPON):
        scene.pop(name, None)


def _clear_decisions(strip: Any) -> None:
    for name in (*LOOK_OF_SHOT.values(), CENTRE):
        strip.pop(name, None)


def colour_is_ours(strip: Any) -> bool:
    """Whether no editor gave the strip a colour."""
    return strip.color_tag in ("NONE", OVERRIDDEN_COLOUR, strip.get(GIVEN_COLOUR))


def set_colour(strip: Any, key: int, *, overridden: bool = False) -> None:
    """The colour of the camera with that key, or of an override; an editor's own stays."""
    wanted = OVERRIDDEN_COLOUR if overridden else CAMERA_COLOURS[(key - 1) % len(CAMERA_COLOURS)]
    if strip.color_tag != wanted and colour_is_ours(strip):
        strip.color_tag = strip[GIVEN_COLOUR] = wanted


def label_strips(
    strips: Iterable[Any], overridden: frozenset[str], cameras: Mapping[str, str], keys: Mapping[str, int]
) -> dict[str, str]:
    """Yellow for the ``overridden`` of these Multicam strips, for the others their camera's colour, and their names.

    cameras: what each strip shows, by its name; keys: the number key of each camera. An editor's own colours and names
    stay. Returns what was renamed: old -> new.
    """
    renamed = {}
    for strip in strips:
        name = strip.name
        key = keys.get(cameras.get(name, ""), 0)
        if key or name in overridden:
            set_colour(strip, key, overridden=name in overridden)
        given = given_name(strip)  # split, it is followed by .001
        if given and name.startswith(given) and name in cameras:
            number = given.partition(":")[0]
            if (now := strip_name(number, cameras[name], key)) != given:
                strip.name = strip[GIVEN_NAME] = now
                renamed[name] = strip.name
    return renamed
