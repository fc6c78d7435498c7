# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel in the sequencer's sidebar, tab mcsl."""

from __future__ import annotations

import bpy  # pyright: ignore[reportMissingImports]


class MCSL_PT_timeline(bpy.types.Panel):
    bl_label = "mcsl"
    bl_idname = "MCSL_PT_timeline"
    bl_space_type = "SEQUENCE_EDITOR"
    bl_region_type = "UI"
    bl_category = "mcsl"

    def draw(self, context):
        scene = getattr(context, "sequencer_scene", None) or context.scene
        layout = self.layout
        layout.operator("mcsl.build_timeline", icon="SEQ_SEQUENCER")
        layout.operator("mcsl.pull_overrides", icon="IMPORT")
        if scene.get("mcsl_edl"):
            count = scene.get("mcsl_overrides", 0)
            layout.label(text=f"{count} override{'s' * (count != 1)} in {scene['mcsl_edl'].removeprefix('//')}")


def register() -> None:
    bpy.utils.register_class(MCSL_PT_timeline)


def unregister() -> None:
    bpy.utils.unregister_class(MCSL_PT_timeline)
