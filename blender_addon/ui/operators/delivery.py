# SPDX-License-Identifier: GPL-3.0-or-later
"""Exact pictures into the timeline, and the video out of it.

No `from __future__ import annotations` here: Blender reads the properties from the annotations themselves.
"""

from pathlib import Path
from typing import ClassVar

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.blender.messages import ConformedMedia, structure
from mcsl_core.errors import InputError, McslError

from ...core import camera_files, presets, shot_list
from ...sequencer import conformed, output, scene_properties
from ...sequencer.compat import sequencer_scene
from ...sequencer.sound import has_sound
from .. import job_runner, preferences, refresh, render_guard
from ..translations.lookup import told
from .recording import work_of
from .timeline import pull


class MCSL_OT_conform(bpy.types.Operator):
    """Make the exact pictures of all that is outstanding, from the original files, and put them in place"""

    bl_idname = "mcsl.conform"
    bl_label = "Conform"
    bl_options: ClassVar = {"REGISTER"}

    @classmethod
    def poll(cls, context):
        return scene_properties.has_timeline(sequencer_scene(context)) and not job_runner.busy()

    def execute(self, context):
        scene = sequencer_scene(context)
        try:
            edl, _ = pull(scene, self.report)
            path = scene_properties.edl_path(scene, Path(bpy.data.filepath))
            name = scene.name

            def follow(result):
                if (target := bpy.data.scenes.get(name)) is None or target.sequence_editor is None:
                    raise InputError(told("the scene {name} is gone").format(name=name))
                media = structure(result, ConformedMedia, where="mcsl conform")
                yield from conformed.insert(target, edl, media.pieces, media.sound, path.parent)
                refresh.refresh_timeline(target)
                if bpy.data.filepath:
                    bpy.ops.file.make_paths_relative()
                if not bpy.app.background:
                    bpy.ops.ed.undo_push(message="mcsl: conformed pictures")

            command = camera_files.conform_command(preferences.mcsl(), str(path))
            job_runner.start(told("Conforming"), command, follow, cwd=path.parent)
        except McslError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class MCSL_OT_render(bpy.types.Operator):
    """Render the programme to a video with the chosen preset, by Blender's own Render Animation"""

    bl_idname = "mcsl.render"
    bl_label = "Render"
    bl_options: ClassVar = {"REGISTER"}

    @classmethod
    def poll(cls, context):
        idle = not (job_runner.busy() or render_guard.busy())
        return idle and scene_properties.has_timeline(sequencer_scene(context))

    def execute(self, context):
        scene = sequencer_scene(context)
        work = work_of(context)
        try:
            target = set_output(scene, work)
            problem = refresh.refresh_timeline(scene)
        except McslError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if problem:
            self.report({"ERROR"}, problem)  # what would be rendered is not what the editor sees
            return {"CANCELLED"}
        for notice in context.window_manager.mcsl_state.notices.splitlines():
            self.report({"WARNING"}, notice)
        left = context.window_manager.mcsl_state.outstanding_s
        if left > 0:
            text = told("{seconds} show the preview, not the exact pictures: conform first for those")
            self.report({"WARNING"}, text.format(seconds=shot_list.seconds_text(left)))
        how = "EXEC_DEFAULT" if bpy.app.background else "INVOKE_DEFAULT"
        try:
            rendered = render_guard.begin(scene, refresh.last(scene), target)
            bpy.ops.render.render(how, animation=True, scene=rendered.name)
        except (RuntimeError, OSError, McslError) as error:
            render_guard.drop()
            self.report({"ERROR"}, f"{target}: {str(error).strip()}")
            return {"CANCELLED"}
        finally:
            if bpy.app.background:
                render_guard.tidy()  # where there are no timers
        self.report({"INFO"}, told("rendering to {path}").format(path=target))
        return {"FINISHED"}


class MCSL_OT_apply_preset(bpy.types.Operator):
    """Set this scene's output as the preset says, for Blender's own rendering and for blender -b FILE -a"""

    bl_idname = "mcsl.apply_preset"
    bl_label = "Set Output"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return scene_properties.has_timeline(sequencer_scene(context))

    def execute(self, context):
        try:
            target = set_output(sequencer_scene(context), work_of(context))
        except McslError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, str(target))
        return {"FINISHED"}


def set_output(scene, work) -> Path:
    """The scene's output from the panel's preset and file; the file it will write. InputError without a folder."""
    preset = presets.load_all()[work.preset]
    if work.video:
        target = Path(bpy.path.abspath(work.video))
        if not target.suffix:
            target = target.with_suffix(f".{preset.container}")
    elif bpy.data.filepath:
        target = Path(bpy.data.filepath).with_suffix(f".{preset.container}")
    else:
        raise InputError(told("there is no name for the video"), remedy=told("Save the file, or choose an output"))
    if target.suffix != f".{preset.container}":
        raise InputError(
            told("the preset writes .{container} files").format(container=preset.container),
            where=str(target),
            remedy=told("Name it so, or take another preset"),
        )
    if not target.parent.is_dir():
        raise InputError(told("is not a folder"), where=str(target.parent), remedy=told("Choose another output"))
    size = scene_properties.edl_of(scene).size  # the programme's own: a preset before may have made the scene's even
    scene.render.resolution_x, scene.render.resolution_y = size
    output.apply(scene, preset, str(target), sound=has_sound(scene))
    return target


CLASSES = (MCSL_OT_conform, MCSL_OT_render, MCSL_OT_apply_preset)
