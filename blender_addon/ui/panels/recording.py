# SPDX-License-Identifier: GPL-3.0-or-later
"""Which files are cameras, and the EDL that takes the decisions."""

from __future__ import annotations

import bpy  # pyright: ignore[reportMissingImports]

from ...sequencer.compat import sequencer_scene
from ...sequencer.scene_properties import has_timeline
from ..operators.recording import work_of
from ..translations.lookup import shown
from .drawing import SidebarPanel


class MCSL_UL_cameras(bpy.types.UIList):
    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        row = layout.row(align=True)
        row.label(text=f"{data.cameras.find(item.name) + 1}  {item.name}", icon="VIEW_CAMERA", translate=False)
        count = len(item.files.splitlines())
        if count > 1:
            row.label(text=shown("{count} files").format(count=count), translate=False)
        first = data.cameras[0].name if data.cameras else ""
        is_reference = item.name == (data.reference or first)
        button = row.operator(
            "mcsl.set_reference", text="", icon="SOLO_ON" if is_reference else "SOLO_OFF", emboss=False
        )
        button.camera = item.name


class MCSL_PT_recording(SidebarPanel, bpy.types.Panel):
    bl_label = "Recording"
    bl_idname = "MCSL_PT_recording"
    bl_order = 0

    def draw(self, context):
        layout, work = self.layout, work_of(context)
        row = layout.row()
        row.template_list("MCSL_UL_cameras", "", work, "cameras", work, "active_camera", rows=5)
        column = row.column(align=True)
        column.operator("mcsl.add_cameras", text="", icon="ADD")
        column.operator("mcsl.remove_camera", text="", icon="REMOVE")
        column.separator()
        column.operator("mcsl.move_camera", text="", icon="TRIA_UP").direction = "UP"
        column.operator("mcsl.move_camera", text="", icon="TRIA_DOWN").direction = "DOWN"
        if not work.cameras:
            layout.operator("mcsl.add_cameras", icon="FILE_MOVIE")
        else:
            layout.label(text="The star is the reference camera", icon="INFO")
        layout.prop(work, "edl")
        if has_timeline(sequencer_scene(context)):
            layout.operator("mcsl.build_proxies", icon="SEQ_PREVIEW")
        else:
            layout.operator("mcsl.build_timeline", icon="SEQ_SEQUENCER")


CLASSES = (MCSL_UL_cameras, MCSL_PT_recording)
