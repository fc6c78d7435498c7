# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether one of our strips bears an editor's work: whatever is not as it was built is his, and is kept.

Blender's own defaults are what a strip is compared with, so that a property that nobody thought of counts as well.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from operator import attrgetter
from typing import Any

from .edit import colour_is_ours, curves_of, effect_inputs
from .scene_properties import CAMERA, FALLEN, FOLLOWS, MARK, given_name, role_of
from .transforms import NUMBERS

# What is not work on a strip: where it lies, what it shows (decisions, read elsewhere), how the window shows it.
_PLACE = re.compile(
    r"rna_type|type|name|channel|select.*|frame_.*|(left|right)_handle.*|content_.*|duration|elements|fps|color_tag"
)
_SHOWN = re.compile(
    r"multicam_source|filepath|sound|show_waveform|.*_ptr|input_.*|stream_index|views_format|mute|use_proxy"
)
_BUILT: dict[str, Any] = {  # as built, where it is not Blender's default
    "blend_type": ("REPLACE", "CROSS", "ALPHA_OVER"),  # of effects; films are laid with REPLACE
    "use_default_fade": (True, False),  # effects and films differ; a fade of the editor's own has keys
    "pitch_correction": (True,),
}
_TRANSFORM = {"offset_x": 0, "offset_y": 0, "scale_x": 1, "scale_y": 1, "rotation": 0}
_CROP = ("min_x", "min_y", "max_x", "max_y")
_MOVED = ("camera", "centering")  # by us
_NAMES = {"conformed": "conformed", "sound": "sound", "centering": "Centering"}
_COPY = re.compile(r"\.\d+")


class Work:
    """What the editor did to the strips of a scene, as it is when this is made."""

    def __init__(self, scene: Any) -> None:
        self._animated = animated_names(scene)
        self._inputs = effect_inputs(scene)
        self._settings: dict[Any, _Settings] = {}  # by type of strip and role

    def on(self, strip: Any) -> tuple[str, ...]:
        """What of ``strip`` is the editor's, by Blender's names; () where it is as it was built."""
        return tuple(self._found(strip))

    def _found(self, strip: Any) -> Iterator[str]:
        role = role_of(strip)
        if strip.mute and not strip.get(FALLEN):
            yield "mute"
        if not _is_given(strip, role):
            yield "name"
        if not colour_is_ours(strip):
            yield "color_tag"
        if strip.name in self._inputs:
            yield "effect strip"
        if paths := self._animated.get(strip.name, set()) - _keyed(strip, role):
            yield f"keys of {', '.join(sorted(paths))}"
        if getattr(strip, "retiming_keys", ()):
            yield "retiming"
        if strip.type == "SOUND" and strip.sound is not None and strip.sound.use_mono:
            yield "mono"
        if getattr(strip, "modifiers", ()):
            yield "modifiers"
        yield from (key for key in strip.keys() if not _is_ours(key))  # noqa: SIM118 - a strip is no mapping
        kind = type(strip), role
        if kind not in self._settings:
            self._settings[kind] = _Settings(strip, role)
        yield from self._settings[kind].otherwise(strip)


class _Settings:
    """What can be set on strips of a type and role. Most stand as others do that were found to be as built."""

    def __init__(self, strip: Any, role: str) -> None:
        self._role, self._built = role, _settings_of(type(strip))
        parts = [f"transform.{n}" for n in _TRANSFORM if hasattr(strip, "transform") and role not in _MOVED]
        parts += [f"crop.{n}" for n in _CROP if getattr(strip, "crop", None) is not None]
        self._values = attrgetter(*(name for name, _ in self._built), *parts)
        self._clean: list[Any] = []

    def otherwise(self, strip: Any) -> tuple[str, ...]:
        """What is set otherwise than it was built."""
        values = self._values(strip)
        if values in self._clean:
            return ()
        found = *_placed_otherwise(strip, self._role), *_set_otherwise(strip, self._built)
        if not found:
            self._clean = [values, *self._clean[:9]]
        return found


def _keyed(strip: Any, role: str) -> set[str]:
    """What has keys of ours."""
    if role == "camera" and FOLLOWS in strip:
        return {f"transform.{name}" for name in NUMBERS}
    return {"transform.offset_x", "transform.offset_y"} if role == "centering" else set()


def _is_ours(key: str) -> bool:
    return key == MARK or key.startswith(f"{MARK}_")


def _is_given(strip: Any, role: str) -> bool:
    """Whether the name is the one that the strip was built with, or that with Blender's .001."""
    given = _NAMES.get(role, "")
    if role in ("camera", "programme"):
        given = str(strip.get(CAMERA, "")) if role == "camera" else given_name(strip)
    name = strip.name
    return given in ("", name) or (name.startswith(given) and _COPY.fullmatch(name, len(given)) is not None)


def _placed_otherwise(strip: Any, role: str) -> Iterator[str]:
    transform, crop = getattr(strip, "transform", None), getattr(strip, "crop", None)
    if transform is not None and role not in _MOVED:
        yield from (f"transform {n}" for n, built in _TRANSFORM.items() if abs(getattr(transform, n) - built) > 1e-6)
    if crop is not None:
        yield from (f"crop {name}" for name in _CROP if getattr(crop, name) != 0)


def _set_otherwise(strip: Any, settings: Iterable[tuple[str, Any]]) -> Iterator[str]:
    for name, built in settings:
        value = getattr(strip, name)
        if name == "blend_type" and strip.type == "MOVIE":
            if value != "REPLACE":
                yield name
        elif isinstance(built, frozenset):
            if value not in built:
                yield name
        elif isinstance(built, tuple):
            if any(abs(a - b) > 1e-6 for a, b in zip(value, built, strict=True)):
                yield name
        elif value != built:
            yield name


def _settings_of(kind: Any) -> tuple[tuple[str, Any], ...]:
    """What can be set on strips of a type, and as what it is built: a value, an array, or a set of values."""
    found = []
    for prop in kind.bl_rna.properties:
        name = prop.identifier
        passed = (
            prop.is_readonly or prop.type in ("POINTER", "COLLECTION") or (prop.type == "ENUM" and prop.is_enum_flag)
        )
        if passed or _PLACE.fullmatch(name) or _SHOWN.fullmatch(name):
            continue
        built = tuple(prop.default_array) if getattr(prop, "is_array", False) else prop.default
        found.append((name, frozenset(_BUILT[name]) if name in _BUILT else built))
    return tuple(found)


def animated_names(scene: Any) -> dict[str, set[str]]:
    """The names of strips that have keys or drivers, and which of their properties."""
    found: dict[str, set[str]] = {}
    data = scene.animation_data
    if data is None:
        return found
    for curve in (*data.drivers, *curves_of(scene).values()):
        if match := re.match(r'sequence_editor\.strips_all\["(.*?)"\]\.(.+)', curve.data_path):
            found.setdefault(match[1].replace('\\"', '"'), set()).add(match[2])
    return found
