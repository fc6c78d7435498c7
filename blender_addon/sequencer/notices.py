# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person should know of a timeline before it is conformed, rendered or brought up to date."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from mcsl_core.edl import Edl

from ..core import times
from ..core.read_overrides import SequencerState
from ..core.strip_plan import FIRST_CAMERA_CHANNEL
from .compat import ends
from .scene_properties import CAMERA, placed_of, role_of
from .touched import Work

_SEEN = ("mute", "name", "color_tag", "effect strip", "lock")  # changes no picture


def notices(scene: Any, edl: Edl, state: SequencerState) -> tuple[str, ...]:
    """Lines for a person: what is kept as it is but may surprise, and what cannot be kept.

    Parameters
    ----------
    scene
        The scene with the timeline.
    edl
        Its EDL.
    state
        The timeline as read.
    """
    return (*state.notes, *times.remarks(edl, state.scene, state.films), *_of_strips(scene, edl))


def _of_strips(scene: Any, edl: Edl) -> Iterator[str]:
    editor = scene.sequence_editor
    conformed = FIRST_CAMERA_CHANNEL + len(edl.cameras) + 2
    exact = [ends(s) for s in editor.strips if role_of(s) == "conformed" and not s.mute]
    if exact and editor.channels[conformed].mute:
        yield f"channel {conformed}, Conformed, is muted: the preview shows in place of the exact pictures"
    work = Work(scene)
    for strip in editor.strips:
        where = f"strip {strip.name!r}, frame {ends(strip)[0] + 1}"
        if strip.type == "MULTICAM" and (done := [what for what in work.on(strip) if what not in _SEEN]):
            if strip.mute:
                yield f"{where} is muted and decides nothing: its {done[0]} goes when the timeline is made anew"
            elif any(a < ends(strip)[1] and ends(strip)[0] < b for a, b in exact):
                yield f"{where}: its {done[0]} is hidden by the exact pictures above it; put it on those, or above them"
        placed = placed_of(strip) if role_of(strip) in ("camera", "conformed") else None
        if placed is not None and not strip.filepath.replace("\\", "/").endswith(placed[1]):
            yield f"{where} shows {strip.filepath}, not {placed[1]} as it was built"
        if role_of(strip) == "camera" and edl_lacks(edl, strip) and any(w != "mute" for w in work.on(strip)):
            yield f"{where}: its camera is not in the EDL any more, so your work on it goes with the next rebuild"


def edl_lacks(edl: Edl, strip: Any) -> bool:
    """Whether the camera whose file the strip plays is gone from the EDL."""
    return strip.get(CAMERA) not in {camera.name for camera in edl.cameras}
