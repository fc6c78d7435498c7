# SPDX-License-Identifier: GPL-3.0-or-later
"""Strips cut, switched, labelled and set back, as decided in the plain modules."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from mcsl_core.edl import Look
from mcsl_core.errors import BlenderError

from ..core.multicam import Switch
from ..core.read_overrides import AUTOMATIC
from ..core.revert import Setting
from ..core.similarity import Transform
from .scene_properties import AIDS, LOOK, NAME, PLANNED, role_of

OVERRIDDEN_COLOUR = "COLOR_03"  # yellow: an editor's decision


def set_transform(strip: Any, transform: Transform) -> None:
    to = strip.transform
    # rounded far below a pixel, so that no field shows -0
    to.offset_x, to.offset_y, to.scale_x, to.scale_y, to.rotation = (
        round(n, 9) + 0.0 for n in transform_numbers(transform)
    )


def transform_numbers(transform: Transform) -> list[float]:
    """As the property `mcsl_planned` holds it: offset_x, offset_y, scale_x, scale_y, rotation."""
    t = transform
    return [t.offset_x, t.offset_y, t.scale, t.height_scale, t.rotation]


def transform_from_numbers(numbers: Sequence[float]) -> Transform:
    """The inverse of `_numbers`."""
    x, y, scale, scale_y, rotation = map(float, numbers)
    return Transform(x, y, scale, rotation, None if scale == scale_y else scale_y)


def split_strip(strip: Any, frame: int) -> Any:
    """The right part of ``strip`` cut at a programme frame; ``strip`` keeps the left."""
    right = strip.split(frame=frame + 1, split_method="SOFT")
    if right is None:
        raise BlenderError(f"strip {strip.name!r} cannot be split at frame {frame + 1}")
    return right


def split_at(strip: Any, frames: Sequence[int]) -> list[Any]:
    """The parts of ``strip`` cut at programme frames, which rise and lie inside it; in order."""
    parts = [strip]
    for frame in frames:
        parts.append(split_strip(parts[-1], frame))
    return parts


# --------------------------------------------------------------------------------------------------------- by hand


def apply_switch(scene: Any, change: Switch) -> None:
    """Cuts and switches as decided; the part that is shown from now on becomes the active strip, alone selected."""
    strip = scene.sequence_editor.strips[change.name]
    if change.split is not None:
        strip = split_strip(strip, change.split)
    strip.multicam_source = change.source
    for other in scene.sequence_editor.strips:
        if other.select and other != strip:
            other.select = False
    strip.select = True
    scene.sequence_editor.active_strip = strip


def apply_settings(scene: Any, settings: Mapping[str, Sequence[Setting]], look: Look) -> None:
    """Strips cut and set as `reverting` decided; in what is set, look and centre are the programme's again."""
    for name, parts in settings.items():
        cuts = [part.range.stop for part in parts[:-1]]
        for strip, part in zip(split_at(scene.sequence_editor.strips[name], cuts), parts, strict=True):
            if part.source is not None:
                strip.multicam_source = part.source
                _clear_decisions(strip)
                for aid in part.said & set(AIDS):
                    strip[f"mcsl_{aid}"] = getattr(look, aid)
                if "offset" in part.said:
                    strip["mcsl_offset"] = AUTOMATIC


def clear_strip_decisions(scene: Any) -> None:
    """The EDL holds all that the strips said about looks and centres: from now on they say nothing of their own."""
    for strip in scene.sequence_editor.strips:
        if strip.type == "MULTICAM":
            _clear_decisions(strip)
    for aid in AIDS:
        scene.pop(LOOK + aid, None)


def _clear_decisions(strip: Any) -> None:
    for name in (*AIDS, "offset"):
        strip.pop(f"mcsl_{name}", None)


def label_strips(scene: Any, overridden: frozenset[str], cameras: Mapping[str, str]) -> None:
    """Yellow for the ``overridden`` strips, none for the other Multicam strips, and the camera in their names.

    cameras: what each strip shows, by its name. An editor's own colours and names stay.
    """
    for strip in [s for s in scene.sequence_editor.strips if s.type == "MULTICAM"]:
        name = strip.name
        wanted = OVERRIDDEN_COLOUR if name in overridden else "NONE"
        if strip.color_tag != wanted and strip.color_tag in ("NONE", OVERRIDDEN_COLOUR):
            strip.color_tag = wanted
        given = strip.get(NAME)  # split, it is followed by .001
        if given and name.startswith(given) and name in cameras:
            number = given.partition(":")[0]
            if (now := f"{number}: {cameras[name]}") != given:
                strip.name = strip[NAME] = now


def can_be_reset(strip: Any) -> bool:
    """Whether it is a camera strip that knows its automatic place."""
    return role_of(strip) == "camera" and strip.get(PLANNED) is not None


def reset_transform(strip: Any) -> None:
    """Back to where the analysis placed the camera: pulling then takes the correction away."""
    set_transform(strip, transform_from_numbers(strip[PLANNED]))
