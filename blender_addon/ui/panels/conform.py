# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of the programme shows the preview, and the exact pictures for it."""

from __future__ import annotations

import bpy  # pyright: ignore[reportMissingImports]

from ...core import shot_list
from ...sequencer import conformed
from ...sequencer.compat import sequencer_scene
from ..translations.lookup import shown, told
from .drawing import TimelinePanel, draw_job, draw_message, draw_notices, wrapped


class MCSL_PT_conform(TimelinePanel, bpy.types.Panel):
    bl_label = "Conform"
    bl_idname = "MCSL_PT_conform"
    bl_order = 4

    def draw(self, context):
        layout, state = self.layout, context.window_manager.mcsl_state
        scene = sequencer_scene(context)
        if state.outstanding_s > 0:
            text = shown("{seconds} outstanding: the preview is shown there")
            wrapped(layout, text.format(seconds=shot_list.seconds_text(state.outstanding_s)), "TIME")
            if state.lost_s > 0:
                text = shown("{seconds} of exact pictures fell away, because their decisions changed")
                wrapped(layout, text.format(seconds=shot_list.seconds_text(state.lost_s)), "INFO")
        elif conformed.any_there(scene):
            layout.label(text="All pictures are exact", icon="CHECKMARK")
        draw_notices(layout, state)
        if not draw_job(layout, told("Conforming")):
            layout.operator("mcsl.conform", icon="RENDER_RESULT")
        draw_message(layout, told("Conforming"))


CLASSES = (MCSL_PT_conform,)
