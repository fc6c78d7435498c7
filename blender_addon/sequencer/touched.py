# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether one of our strips bears an editor's work: whatever is not as it was built is his, and is kept.

Blender's own defaults are what a strip is compared with, so that a property that nobody thought of counts as well.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from .edit import OVERRIDDEN_COLOUR, curves_of, effect_inputs
from .scene_properties import CAMERA, FALLEN, FOLLOWS, given_name, role_of
from .transforms import NUMBERS

# What is not work on a strip: where it lies, what it shows (decisions, read elsewhere), how the window shows it.
_PLACE = re.compile(
    r"rna_type|type|name|channel|select.*|frame_.*|(left|right)_handle.*|content_.*|duration|elements|fps"
)
_SHOWN = re.compile(r"multicam_source|filepath|sound|show_waveform|.*_ptr|input_.*|stream_index|views_format|mute")
_BUILT: dict[str, Any] = {  # as built, where it is not Blender's default
    "color_tag": ("NONE", OVERRIDDEN_COLOUR),
    "blend_type": ("REPLACE", "CROSS", "ALPHA_OVER"),  # of effects; films are laid with REPLACE
    "use_default_fade": (True, False),  # effects and films differ; a fade of the editor's own has keys
    "pitch_correction": (True,),
}
_TRANSFORM = {"offset_x": 0, "offset_y": 0, "scale_x": 1, "scale_y": 1, "rotation": 0}
_CROP = ("min_x", "min_y", "max_x", "max_y")
_NAMES = {"conformed": "conformed", "sound": "sound", "centering": "Centering"}
_OURS = re.compile(r"mcsl(_.*)?")


class Work:
    """What the editor did to the strips of a scene, as it is when this is made."""

    def __init__(self, scene: Any) -> None:
        self._animated = animated_names(scene)
        self._inputs = effect_inputs(scene)

    def on(self, strip: Any) -> tuple[str, ...]:
        """What of ``strip`` is the editor's, by Blender's names; () where it is as it was built."""
        return tuple(self._found(strip))

    def _found(self, strip: Any) -> Iterator[str]:
        role = role_of(strip)
        if strip.mute and not strip.get(FALLEN):
            yield "mute"
        if not _is_given(strip, role):
            yield "name"
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
        yield from (key for key in strip.keys() if not _OURS.fullmatch(key))  # noqa: SIM118 - a strip is no mapping
        yield from _placed_otherwise(strip, role)
        yield from _set_otherwise(strip)


def _keyed(strip: Any, role: str) -> set[str]:
    """What has keys of ours."""
    if role == "camera" and FOLLOWS in strip:
        return {f"transform.{name}" for name in NUMBERS}
    return {"transform.offset_x", "transform.offset_y"} if role == "centering" else set()


def _is_given(strip: Any, role: str) -> bool:
    """Whether the name is the one that the strip was built with, or that with Blender's .001."""
    given = str({**_NAMES, "camera": strip.get(CAMERA, ""), "programme": given_name(strip)}.get(role, ""))
    return not given or re.fullmatch(re.escape(given) + r"(\.\d+)?", strip.name) is not None


def _placed_otherwise(strip: Any, role: str) -> Iterator[str]:
    transform, crop = getattr(strip, "transform", None), getattr(strip, "crop", None)
    if transform is not None and role not in ("camera", "centering"):
        yield from (f"transform {n}" for n, built in _TRANSFORM.items() if abs(getattr(transform, n) - built) > 1e-6)
    if crop is not None:
        yield from (f"crop {name}" for name in _CROP if getattr(crop, name) != 0)


def _set_otherwise(strip: Any) -> Iterator[str]:
    for prop in strip.bl_rna.properties:
        name = prop.identifier
        if (
            prop.is_readonly
            or prop.type in ("POINTER", "COLLECTION")
            or _PLACE.fullmatch(name)
            or _SHOWN.fullmatch(name)
        ):
            continue
        value = getattr(strip, name)
        if name == "blend_type" and strip.type == "MOVIE":
            if value != "REPLACE":
                yield name
        elif name in _BUILT:
            if value not in _BUILT[name]:
                yield name
        elif prop.type == "ENUM" and prop.is_enum_flag:
            continue
        elif getattr(prop, "is_array", False):
            if any(abs(a - b) > 1e-6 for a, b in zip(value, prop.default_array, strict=True)):
                yield name
        elif value != prop.default:
            yield name


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
