# SPDX-License-Identifier: GPL-3.0-or-later
"""Which files are cameras, in which order, and whose perspective the programme keeps.

No `from __future__ import annotations` here: Blender reads the properties from the annotations themselves.
"""

from pathlib import Path
from typing import ClassVar

import bpy  # pyright: ignore[reportMissingImports]

from ...core import camera_files as recordings
from ...sequencer.compat import sequencer_scene
from ..translations.lookup import told


def work_of(context):
    """The recording and delivery of the scene that the sequencer shows."""
    return sequencer_scene(context).mcsl_work


class _NeedsCamera:
    @classmethod
    def poll(cls, context):
        return bool(work_of(context).cameras)


class MCSL_OT_add_cameras(bpy.types.Operator):
    """Choose camera files; files named like cam1_000, cam1_001 are parts of one camera"""

    bl_idname = "mcsl.add_cameras"
    bl_label = "Add Camera Files..."
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    directory: bpy.props.StringProperty(subtype="DIR_PATH", options={"HIDDEN"})
    files: bpy.props.CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})
    filter_movie: bpy.props.BoolProperty(default=True, options={"HIDDEN"})
    filter_folder: bpy.props.BoolProperty(default=True, options={"HIDDEN"})

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        work = work_of(context)
        paths = [str(Path(bpy.path.abspath(self.directory)) / file.name) for file in self.files if file.name]
        known = {path for camera in work.cameras for path in camera.paths()}
        new = [path for path in paths if path not in known]
        if not new:
            self.report({"WARNING"}, told("No new camera file was chosen"))
            return {"CANCELLED"}
        names = {camera.name for camera in work.cameras}
        for picked in recordings.cameras_of(new):
            if picked.name in names:
                text = told("There is a camera {name} already: rename the file").format(name=picked.name)
                self.report({"WARNING"}, text)
                continue
            camera = work.cameras.add()
            camera.name, camera.files = picked.name, "\n".join(picked.files)
            names.add(picked.name)
        work.active_camera = len(work.cameras) - 1
        return {"FINISHED"}


class MCSL_OT_remove_camera(_NeedsCamera, bpy.types.Operator):
    """Take the chosen camera off the list; its files stay where they are"""

    bl_idname = "mcsl.remove_camera"
    bl_label = "Remove Camera"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    def execute(self, context):
        work = work_of(context)
        if work.cameras[work.active_camera].name == work.reference:
            work.reference = ""
        work.cameras.remove(work.active_camera)
        work.active_camera = max(0, min(work.active_camera, len(work.cameras) - 1))
        return {"FINISHED"}


class MCSL_OT_move_camera(_NeedsCamera, bpy.types.Operator):
    """Move the chosen camera in the list; the order is that of the number keys"""

    bl_idname = "mcsl.move_camera"
    bl_label = "Move Camera"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    direction: bpy.props.EnumProperty(
        name="Direction", items=[("UP", "Up", "Towards the first"), ("DOWN", "Down", "Towards the last")]
    )

    def execute(self, context):
        work = work_of(context)
        to = work.active_camera + (-1 if self.direction == "UP" else 1)
        if not 0 <= to < len(work.cameras):
            return {"CANCELLED"}
        work.cameras.move(work.active_camera, to)
        work.active_camera = to
        return {"FINISHED"}


class MCSL_OT_set_reference(_NeedsCamera, bpy.types.Operator):
    """Keep this camera's perspective in the programme"""

    bl_idname = "mcsl.set_reference"
    bl_label = "Set Reference Camera"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    camera: bpy.props.StringProperty(name="Camera", description="Its name; empty: the chosen one")

    def execute(self, context):
        work = work_of(context)
        work.reference = self.camera or work.cameras[work.active_camera].name
        return {"FINISHED"}


CLASSES = (MCSL_OT_add_cameras, MCSL_OT_remove_camera, MCSL_OT_move_camera, MCSL_OT_set_reference)
