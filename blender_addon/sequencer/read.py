# SPDX-License-Identifier: GPL-3.0-or-later
"""The sequencer -> SequencerState: what the editor left."""

from __future__ import annotations

from typing import Any

from mcsl_core.errors import InputError

from ..core import strip_plan as plans
from ..core.corrections import FoundCamera
from ..core.read_overrides import AUTOMATIC, FoundStrip, SequencerState
from .centering_keys import centering_keys_hash
from .compat import ends
from .edit import transform_from_numbers
from .scene_properties import AIDS, KEYS, LOOK, PLANNED, role_of

# --------------------------------------------------------------------------------------------------------- reading


def read_timeline(scene: Any) -> SequencerState:
    """What the editor left: every Multicam strip on every channel, and where the cameras are."""
    editor = scene.sequence_editor
    top = {s.name for s in editor.strips}
    for strip in editor.strips_all:
        if strip.type == "MULTICAM" and strip.name not in top:
            raise InputError(
                "is a Multicam strip inside a meta strip, where it has no cameras",
                where=f"strip {strip.name!r}",
                remedy="Separate the meta strip (Ctrl-Alt-G) and save",
            )
    strips, cameras = [], []
    for strip in editor.strips:
        start, stop = ends(strip)
        if strip.type == "MULTICAM":
            strips.append(
                FoundStrip(
                    name=strip.name,
                    channel=strip.channel,
                    start=start,
                    stop=stop,
                    source=strip.multicam_source,
                    muted=strip.mute,
                    centering=_switch(strip, "mcsl_centering"),
                    fill=_switch(strip, "mcsl_fill"),
                    colour=_switch(strip, "mcsl_colour"),
                    offset=_offset(strip),
                )
            )
        elif role_of(strip) == "camera":
            planned = strip.get(PLANNED)
            t = strip.transform
            cameras.append(
                FoundCamera(
                    camera=strip["mcsl_camera"],
                    channel=strip.channel,
                    start=start,
                    stop=stop,
                    name=strip.name,
                    transform=transform_from_numbers([t.offset_x, t.offset_y, t.scale_x, t.scale_y, t.rotation]),
                    planned=None if planned is None else transform_from_numbers(planned),
                )
            )
    automatic = scene.get("mcsl_automatic")
    return SequencerState(
        strips=tuple(strips),
        cameras=tuple(cameras),
        automatic=plans.automatic_from_text(automatic) if automatic else None,
        look=tuple((aid, bool(scene[LOOK + aid])) for aid in AIDS if LOOK + aid in scene),
        notes=_remarks(scene),
    )


def _remarks(scene: Any) -> tuple[str, ...]:
    """What an editor did that is not read, for a person."""
    if scene.get(KEYS, "") not in ("", centering_keys_hash(scene)):
        return (
            "the Centering strip or its keys were changed by hand, which is not read: to set the centre of a shot, "
            "use the panel (or the strip's property mcsl_offset)",
        )
    return ()


def _offset(strip: Any) -> Any:
    """The strip's centre by hand: two numbers to a thousandth of a pixel, AUTOMATIC, or None."""
    value = strip.get("mcsl_offset")
    if value is None or value == AUTOMATIC:
        return value
    try:
        x, y = (round(float(number), 3) for number in value)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"has mcsl_offset {value!r}; two numbers [dx, dy] are expected, or {AUTOMATIC!r}",
            where=f"strip {strip.name!r}, frame {ends(strip)[0] + 1}",
            remedy="Correct it among the strip's custom properties, or remove it",
        ) from error
    return x, y


def _switch(strip: Any, name: str) -> bool | None:
    value = strip.get(name)
    return None if value is None else bool(value)
