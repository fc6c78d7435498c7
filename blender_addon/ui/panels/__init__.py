# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels in the sequencer's sidebar, tab mcsl, in the order of the work. They only show; operators do."""

from __future__ import annotations

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.edl.resolve import resolve
from mcsl_core.errors import McslError

from ...core import shot_list as shots
from ...core.camera_files import STAGES
from ...sequencer import conformed
from ...sequencer import scene_properties as scenes
from ...sequencer.compat import sequencer_scene
from .. import job_runner as running
from .. import preferences
from .. import refresh as watching
from ..operators.look import AIDS
from ..operators.recording import work_of
from ..translations.lookup import shown, told

WIDTH = 44  # letters of a line where there is no sidebar to measure
LETTER_PX = 6.2  # at a scale of 1; what stands beside the text takes 70 pixels


class _Panel:
    bl_space_type = "SEQUENCE_EDITOR"
    bl_region_type = "UI"
    bl_category = "mcsl"


class _TimelinePanel(_Panel):
    @classmethod
    def poll(cls, context):
        scene = sequencer_scene(context)
        return scene is not None and bool(scene.get("mcsl_edl")) and scene.sequence_editor is not None


def wrapped(layout, text: str, icon: str = "NONE") -> None:
    """A text of several lines: a label has but one. Japanese letters count double and break anywhere."""
    region, width = bpy.context.region, WIDTH
    if region is not None and region.type == "UI":
        scale = bpy.context.preferences.system.ui_scale
        width = max(20, int((region.width / scale - 70) / LETTER_PX))
    column = layout.column(align=True)
    column.scale_y = 0.85
    for index, line in enumerate(lines_of(text, width)):
        column.label(text=line, icon=icon if index == 0 else ("NONE" if icon == "NONE" else "BLANK1"), translate=False)


def lines_of(text: str, width: int) -> list[str]:
    """``text`` in lines of at most ``width`` columns, broken at spaces, or anywhere in a word that is longer."""
    lines, line, used = [], "", 0
    for word in text.split(" "):
        size = _columns(word)
        if line and used + 1 + size > width:
            lines.append(line)
            line, used = "", 0
        if line:
            line, used = f"{line} ", used + 1
        for letter in word:
            step = _columns(letter)
            if used + step > width:
                lines.append(line)
                line, used = "", 0
            line, used = line + letter, used + step
    return [*lines, line]


def _columns(text: str) -> int:
    return sum(2 if ord(letter) > 0x2E7F else 1 for letter in text)


def draw_job(layout, title: str) -> bool:
    """The bar and the cancel button of the job of that title; whether it runs."""
    run = running.desk.running
    if run is None or run.title != title:
        return False
    row = layout.row(align=True)
    row.progress(factor=running.fraction(run), text=running.describe(run))
    row.operator("mcsl.cancel", text="", icon="X")
    return True


class MCSL_UL_cameras(bpy.types.UIList):
    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index=0, flt_flag=0):
        row = layout.row(align=True)
        row.label(text=f"{index + 1}  {item.name}", icon="VIEW_CAMERA", translate=False)
        count = len(item.files.splitlines())
        if count > 1:
            row.label(text=shown("{count} files").format(count=count), translate=False)
        first = data.cameras[0].name if data.cameras else ""
        is_reference = item.name == (data.reference or first)
        button = row.operator(
            "mcsl.set_reference", text="", icon="SOLO_ON" if is_reference else "SOLO_OFF", emboss=False
        )
        button.camera = item.name


class MCSL_PT_recording(_Panel, bpy.types.Panel):
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
        if not _has_timeline(context):
            layout.operator("mcsl.build_timeline", icon="SEQ_SEQUENCER")


class MCSL_PT_analyse(_Panel, bpy.types.Panel):
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
        try:
            preferences.mcsl()
        except McslError:
            preferences.draw_state(layout)
            layout.operator("mcsl.open_preferences", icon="PREFERENCES")


class MCSL_PT_stages(_Panel, bpy.types.Panel):
    bl_label = "Stages"
    bl_idname = "MCSL_PT_stages"
    bl_parent_id = "MCSL_PT_analyse"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    def draw(self, context):
        layout, work = self.layout, work_of(context)
        if not running.desk.offers:
            layout.operator("mcsl.read_plugins", icon="PLUGIN")
            return
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column()
        for stage in STAGES:
            column.prop(work, stage)


def draw_message(layout, *about: str) -> None:
    """The last message, if it is about one of these jobs, until the next one starts."""
    if running.desk.message and running.desk.about in about and not running.busy():
        icon = {"ERROR": "ERROR", "WARNING": "INFO"}.get(running.desk.level, "CHECKMARK")
        box = layout.box()
        box.alert = running.desk.level == "ERROR"
        wrapped(box, running.desk.message, icon)


class MCSL_UL_shots(bpy.types.UIList):
    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index=0, flt_flag=0):
        row = layout.row(align=True)
        split = row.split(factor=0.4, align=True)
        here = item.start < sequencer_scene(context).frame_current <= item.stop
        split.label(text=item.time, icon="TRIA_RIGHT" if here else "BLANK1", translate=False)
        split = split.split(factor=0.65, align=True)
        split.label(text=item.camera, translate=False)
        right = split.row()
        right.alignment = "RIGHT"
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


class MCSL_PT_shots(_TimelinePanel, bpy.types.Panel):
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
            draw_shot(layout, state.shots[state.active_shot], scene)
        column = layout.column(align=True)
        column.label(text="Camera from the playhead on")
        flow = column.grid_flow(row_major=True, columns=5, even_columns=True, align=True)
        for number, name in enumerate(_camera_names(scene), 1):
            button = flow.operator("mcsl.switch_camera", text=name, translate=False)
            button.number, button.camera = number, name
        row = layout.row(align=True)
        row.operator("mcsl.go_to_override", text="", icon="PREV_KEYFRAME").direction = "BACK"
        middle = row.row()
        middle.alignment = "CENTER"
        middle.label(text=shown("Overrides: {count}").format(count=state.overrides), translate=False)
        row.operator("mcsl.go_to_override", text="", icon="NEXT_KEYFRAME").direction = "NEXT"
        row = layout.row(align=True)
        row.operator("mcsl.revert", icon="LOOP_BACK").everything = False
        row.operator("mcsl.revert", text="All", icon="LOOP_BACK").everything = True
        layout.operator("mcsl.pull_overrides", icon="IMPORT")


def draw_shot(layout, item, scene) -> None:
    """Why a shot is what it is."""
    box = layout.box()
    length = (item.stop - item.start) * scene.render.fps_base / scene.render.fps
    text = shown("{camera}, {length}").format(camera=item.camera, length=shots.seconds_text(length))
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


class MCSL_PT_look(_TimelinePanel, bpy.types.Panel):
    bl_label = "Look"
    bl_idname = "MCSL_PT_look"
    bl_order = 3

    def draw(self, context):
        layout = self.layout
        scene = sequencer_scene(context)
        try:
            edl = watching.last(scene)
        except McslError as error:
            wrapped(layout, str(error), "ERROR")
            return
        frame = scene.frame_current - 1
        decision = next((d for stretch, d in resolve(edl) if frame in stretch), None)
        column = layout.column(align=True)
        heads = column.row(align=True)
        for text in ("", "All", "Shot"):
            heads.label(text=text)
        for aid, label, _ in AIDS:
            row = column.row(align=True)
            row.label(text=label)
            for whole, on in ((True, getattr(edl.look, aid)), (False, decision is not None and getattr(decision, aid))):
                cell = row.row(align=True)
                cell.enabled = whole or decision is not None
                button = cell.operator(
                    "mcsl.set_look",
                    text="On" if on else "Off",
                    icon="CHECKBOX_HLT" if on else "CHECKBOX_DEHLT",
                    depress=on,
                )
                button.aid, button.on, button.whole = aid, not on, whole
        row = layout.row(align=True)
        row.operator("mcsl.set_centre", icon="PIVOT_CURSOR")
        if decision is not None and decision.offset is not None:
            row.operator("mcsl.clear_centre", text="", icon="X")
            x, y = decision.offset
            layout.label(text=shown("Centre by hand: {x:+.0f}, {y:+.0f} pixels").format(x=x, y=y), translate=False)
        layout.operator("mcsl.reset_alignment", icon="LOOP_BACK")


class MCSL_PT_conform(_TimelinePanel, bpy.types.Panel):
    bl_label = "Conform"
    bl_idname = "MCSL_PT_conform"
    bl_order = 4

    def draw(self, context):
        layout, state = self.layout, context.window_manager.mcsl_state
        scene = sequencer_scene(context)
        if state.outstanding_s > 0:
            text = shown("{seconds} outstanding: the preview is shown there")
            wrapped(layout, text.format(seconds=shots.seconds_text(state.outstanding_s)), "TIME")
            if state.lost_s > 0:
                box = layout.box()
                box.alert = True
                text = shown("{seconds} of exact pictures fell away, because their decisions changed")
                wrapped(box, text.format(seconds=shots.seconds_text(state.lost_s)), "ERROR")
        elif conformed.any_there(scene):
            layout.label(text="All pictures are exact", icon="CHECKMARK")
        if not draw_job(layout, told("Conforming")):
            layout.operator("mcsl.conform", icon="RENDER_RESULT")
        draw_message(layout, told("Conforming"))


class MCSL_PT_render(_TimelinePanel, bpy.types.Panel):
    bl_label = "Render"
    bl_idname = "MCSL_PT_render"
    bl_order = 5

    def draw(self, context):
        layout, work = self.layout, work_of(context)
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(work, "preset")
        layout.prop(work, "video")
        if context.window_manager.mcsl_state.outstanding_s > 0:
            layout.label(text="Conform first for exact pictures", icon="INFO")
        row = layout.row(align=True)
        row.operator("mcsl.render", icon="RENDER_ANIMATION")
        row.operator("mcsl.apply_preset", icon="OUTPUT")


def _has_timeline(context) -> bool:
    return bool(sequencer_scene(context).get("mcsl_edl"))


def _camera_names(scene) -> list[str]:
    try:
        return scenes.camera_names(scene)
    except McslError:
        return []


CLASSES = (
    MCSL_UL_cameras,
    MCSL_UL_shots,
    MCSL_PT_recording,
    MCSL_PT_analyse,
    MCSL_PT_stages,
    MCSL_PT_shots,
    MCSL_PT_look,
    MCSL_PT_conform,
    MCSL_PT_render,
)


def register() -> None:
    for kind in CLASSES:
        bpy.utils.register_class(kind)


def unregister() -> None:
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
