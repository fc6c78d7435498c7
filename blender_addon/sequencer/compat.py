# SPDX-License-Identifier: GPL-3.0-or-later
"""What differs between Blender 4.5 LTS, 5.0 and 5.2 LTS."""

from __future__ import annotations

from typing import Any

import bpy  # pyright: ignore[reportMissingImports]

# --------------------------------------------------------------------------------------------- version differences


def new_effect(scene: Any, name: str, kind: str, channel: int, start: int, stop: int) -> Any:
    """An effect strip over programme frames [start, stop). 4.5 takes an end, 5.0 a length."""
    span = {"length": stop - start} if bpy.app.version >= (5, 0, 0) else {"frame_end": stop + 1}
    return scene.sequence_editor.strips.new_effect(name=name, type=kind, channel=channel, frame_start=start + 1, **span)


def ends(strip: Any) -> tuple[int, int]:
    """The programme frames [start, stop) a strip shows. `frame_final_*` is deprecated in 5.2."""
    if hasattr(strip, "left_handle"):
        return int(strip.left_handle) - 1, int(strip.right_handle) - 1
    return int(strip.frame_final_start) - 1, int(strip.frame_final_end) - 1


def sequencer_scene(context: Any) -> Any:
    """The scene the sequencer cuts; from 5.0 the workspace names it, and it may be none."""
    return getattr(context, "sequencer_scene", None) or context.scene


def use_sequencer_scene(scene: Any) -> None:
    """From 5.0 each workspace names the scene it cuts; unset, touching strip modifiers crashes."""
    for workspace in bpy.data.workspaces:
        if hasattr(workspace, "sequencer_scene"):
            workspace.sequencer_scene = scene
