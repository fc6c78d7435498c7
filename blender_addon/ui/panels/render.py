# SPDX-License-Identifier: GPL-3.0-or-later
"""What is delivered, and where to."""

from __future__ import annotations

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.edl.checks import NO_SOUND
from mcsl_core.errors import McslError

from ...sequencer.compat import sequencer_scene
from .. import refresh
from ..operators.recording import work_of
from ..translations.lookup import shown, told
from .drawing import TimelinePanel, draw_job, draw_message


class MCSL_PT_render(TimelinePanel, bpy.types.Panel):
    bl_label = "Render"
    bl_idname = "MCSL_PT_render"
    bl_order = 5

    def draw(self, context):
        layout, work = self.layout, work_of(context)
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(work, "preset")
        layout.prop(work, "video")
        _draw_sound(layout, context)
        if context.window_manager.mcsl_state.outstanding_s > 0:
            layout.label(text="Conform first for exact pictures", icon="INFO")
        row = layout.row(align=True)
        row.operator("mcsl.render", icon="RENDER_ANIMATION")
        row.operator("mcsl.apply_preset", icon="OUTPUT")
        if not draw_job(layout, told("Exporting")):
            layout.operator("mcsl.export", icon="EXPORT")
        draw_message(layout, told("Exporting"))


def _draw_sound(layout, context) -> None:
    """Whose sound the programme has; a click chooses another's."""
    try:
        heard = refresh.last(sequencer_scene(context)).audio_from
    except McslError:
        heard = None
    row = layout.split(factor=0.4)
    side = row.row()
    side.alignment = "RIGHT"
    side.label(text="Sound")
    text = {None: shown("Automatic"), NO_SOUND: shown("None")}.get(heard, heard)
    row.operator_menu_enum("mcsl.sound_from", "source", text=text, icon="SPEAKER", translate=False)


CLASSES = (MCSL_PT_render,)
