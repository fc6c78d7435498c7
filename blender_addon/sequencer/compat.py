# SPDX-License-Identifier: GPL-3.0-or-later
"""What differs between Blender 4.5 LTS, 5.0 and 5.2 LTS."""

from __future__ import annotations

from array import array
from typing import Any

import bpy  # pyright: ignore[reportMissingImports]

_HANDLES = "left_handle" in bpy.types.Strip.bl_rna.properties
_OLD_ENDS = ("frame_final_start", "frame_final_end")


def new_effect(scene: Any, name: str, kind: str, channel: int, start: int, stop: int) -> Any:
    """An effect strip over programme frames [start, stop). 4.5 takes an end, 5.0 a length."""
    span = {"length": stop - start} if bpy.app.version >= (5, 0, 0) else {"frame_end": stop + 1}
    return scene.sequence_editor.strips.new_effect(name=name, type=kind, channel=channel, frame_start=start + 1, **span)


def ends(strip: Any) -> tuple[int, int]:
    """The programme frames [start, stop) a strip shows. `frame_final_*` is deprecated in 5.2."""
    if _HANDLES:
        return int(strip.left_handle) - 1, int(strip.right_handle) - 1
    return int(strip.frame_final_start) - 1, int(strip.frame_final_end) - 1


def strips_of(scene: Any, kind: str) -> list[Any]:
    """The strips of a type, outside meta strips: a property of ours is looked for in these alone."""
    return [strip for strip in scene.sequence_editor.strips if strip.type == kind]


def selected_strips(scene: Any) -> list[Any]:
    """What is selected, outside meta strips."""
    strips = scene.sequence_editor.strips
    flags = array("b", bytes(len(strips)))
    strips.foreach_get("select", flags)
    return [strip for strip, selected in zip(strips, flags, strict=True) if selected]


def sequencer_scene(context: Any) -> Any:
    """The scene the sequencer cuts; from 5.0 the workspace names it, and it may be none."""
    return getattr(context, "sequencer_scene", None) or context.scene


def use_sequencer_scene(scene: Any) -> None:
    """From 5.0 each workspace names the scene it cuts; unset, touching strip modifiers crashes."""
    for workspace in bpy.data.workspaces:
        if hasattr(workspace, "sequencer_scene"):
            workspace.sequencer_scene = scene


def set_ends(strip: Any, start: int, stop: int) -> None:
    """The strip shows programme frames [start, stop); its content stays where it is."""
    left, right = ("left_handle", "right_handle") if _HANDLES else _OLD_ENDS
    setattr(strip, right, stop + 1)  # an end stops at the other: twice, so that neither is in the other's way
    setattr(strip, left, start + 1)
    setattr(strip, right, stop + 1)


def content_start(strip: Any) -> int:
    """The programme frame at which a strip's first picture or sample stands, shown or not."""
    return round(strip.content_start if hasattr(strip, "content_start") else strip.frame_start) - 1


def set_content_start(strip: Any, start: int) -> None:
    """Moves the content, and the ends with it."""
    if hasattr(strip, "content_start"):
        strip.content_start = start + 1
    else:
        strip.frame_start = start + 1
