# SPDX-License-Identifier: GPL-3.0-or-later
"""The analysis, and which plugin does each stage of it."""

from __future__ import annotations

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.errors import McslError

from ...core.camera_files import STAGES
from ...sequencer.compat import sequencer_scene
from ...sequencer.scene_properties import has_timeline
from .. import job_runner, preferences
from ..operators.recording import work_of
from ..translations.lookup import shown, told
from .drawing import SidebarPanel, draw_job, draw_message, wrapped


class MCSL_PT_analyse(SidebarPanel, bpy.types.Panel):
    bl_label = "Analyse"
    bl_idname = "MCSL_PT_analyse"
    bl_order = 1

    def draw(self, context):
        layout = self.layout
        if not draw_job(layout, told("Analysis")):
            row = layout.row()
            row.scale_y = 1.3
            row.operator("mcsl.analyse", icon="PLAY")
        draw_message(layout, told("Analysis"), "")
        if not has_timeline(sequencer_scene(context)):
            wrapped(layout, shown("Next: shots, look and render appear here after the analysis"), "INFO")
        try:
            preferences.mcsl()
        except McslError:
            preferences.draw_state(layout)
            layout.operator("mcsl.open_preferences", icon="PREFERENCES")


class MCSL_PT_stages(SidebarPanel, bpy.types.Panel):
    bl_label = "Stages"
    bl_idname = "MCSL_PT_stages"
    bl_parent_id = "MCSL_PT_analyse"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    def draw(self, context):
        layout, work = self.layout, work_of(context)
        if not job_runner.desk.offers:
            layout.operator("mcsl.read_plugins", icon="PLUGIN")
            return
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column()
        for stage in STAGES:
            column.prop(work, stage)


CLASSES = (MCSL_PT_analyse, MCSL_PT_stages)
