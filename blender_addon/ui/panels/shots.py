# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of shots, why each is what it is, and choosing another camera."""

from __future__ import annotations

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.errors import McslError

from ...core import shot_list
from ...sequencer import scene_properties
from ...sequencer.compat import sequencer_scene
from ..translations.lookup import shown
from .drawing import TimelinePanel, wrapped


class MCSL_UL_shots(bpy.types.UIList):
    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        row = layout.row(align=True)
        split = row.split(factor=0.4, align=True)
        here = item.start < sequencer_scene(context).frame_current <= item.stop
        split.label(text=item.time, icon="TRIA_RIGHT" if here else "BLANK1", translate=False)
        split = split.split(factor=0.65, align=True)
        split.label(text=item.camera, translate=False)
        right = split.row()
        right.alignment = "RIGHT"
        if item.stop - item.start < shot_list.SHORT_FRAMES:
            right.label(text="", icon="ERROR")
        if item.overridden:
            right.label(text="", icon="DECORATE_OVERRIDE")
        else:
            right.label(text=f"{item.score:.0%}", translate=False)

    def filter_items(self, context, data, property):
        rows = getattr(data, property)
        if not self.filter_name:
            return [], []
        wanted = self.filter_name.casefold()
        flags = [self.bitflag_filter_item if wanted in f"{r.camera} {r.why}".casefold() else 0 for r in rows]
        return flags, []


class MCSL_PT_shots(TimelinePanel, bpy.types.Panel):
    bl_label = "Shots"
    bl_idname = "MCSL_PT_shots"
    bl_order = 2

    def draw(self, context):
        layout, state = self.layout, context.window_manager.mcsl_state
        scene = sequencer_scene(context)
        if state.problem:
            box = layout.box()
            box.alert = True
            wrapped(box, state.problem, "ERROR")
        layout.template_list("MCSL_UL_shots", "", state, "shots", state, "active_shot", rows=6)
        if 0 <= state.active_shot < len(state.shots):
            _draw_shot(layout, state.shots[state.active_shot], scene)
        column = layout.column(align=True)
        column.label(text="Camera from the playhead on")
        flow = column.grid_flow(row_major=True, columns=5, even_columns=True, align=True)
        for number, name in enumerate(_camera_names(scene), 1):
            button = flow.operator("mcsl.switch_camera", text=name, translate=False)
            button.number, button.camera = number, name
        layout.operator("mcsl.angles", icon="VIEW_CAMERA")
        if count := state.short_shots:
            text = shown("{count} shots under {frames} frames")
            wrapped(layout, text.format(count=count, frames=shot_list.SHORT_FRAMES), "ERROR")
        row = layout.row(align=True)
        row.operator("mcsl.go_to_cut", text="", icon="TRIA_LEFT_BAR").direction = "BACK"
        row.operator("mcsl.join")
        row.operator("mcsl.go_to_cut", text="", icon="TRIA_RIGHT_BAR").direction = "NEXT"
        row = layout.row(align=True)
        row.operator("mcsl.go_to_override", text="", icon="PREV_KEYFRAME").direction = "BACK"
        middle = row.row()
        middle.alignment = "CENTER"
        middle.label(text=shown("Overrides: {count}").format(count=state.overrides), translate=False)
        row.operator("mcsl.go_to_override", text="", icon="NEXT_KEYFRAME").direction = "NEXT"
        row = layout.row(align=True)
        row.operator("mcsl.revert", icon="LOOP_BACK").everything = False
        row.operator("mcsl.revert", text="All", icon="LOOP_BACK").everything = True
        row = layout.row(align=True)
        row.operator("mcsl.remove", icon="REMOVE")
        row.operator("mcsl.bring_back", icon="LOOP_BACK")
        if state.removals:
            text = shown("Removed: {seconds} in {count} places")
            wrapped(layout, text.format(seconds=shot_list.seconds_text(state.removed_s), count=state.removals))
        layout.operator("mcsl.pull_overrides", icon="IMPORT")


def _draw_shot(layout, item, scene) -> None:
    """Why a shot is what it is."""
    box = layout.box()
    length = (item.stop - item.start) * scene.render.fps_base / scene.render.fps
    text = shown("{camera}, {length}").format(camera=item.camera, length=shot_list.seconds_text(length))
    if item.overridden:
        box.label(text=text, icon="DECORATE_OVERRIDE", translate=False)
        if item.camera != item.automatic:
            wrapped(box, shown("By hand; the analysis chose {camera}").format(camera=item.automatic))
        else:
            box.label(text="Decided by hand")
    else:
        box.label(text=text, icon="VIEW_CAMERA", translate=False)
    if item.why:
        wrapped(box, item.why)


def _camera_names(scene) -> list[str]:
    try:
        return scene_properties.camera_names(scene)
    except McslError:
        return []


CLASSES = (MCSL_UL_shots, MCSL_PT_shots)
