# SPDX-License-Identifier: GPL-3.0-or-later
"""The two buttons: an EDL's timeline into this scene, and the editor's decisions back into the EDL.

Everything is decided in plan.py and readback.py; here stand the file dialogue, the messages and the order. No
`from __future__ import annotations` here: Blender reads the properties from the annotations themselves.
"""

from pathlib import Path
from typing import ClassVar

import attrs
import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core import edl as edls
from mcsl_core.errors import McslError

from . import scenes, strips
from .plan import make_plan
from .readback import read_overrides


class MCSL_OT_build_timeline(bpy.types.Operator):
    """Build the timeline of an EDL that mcsl made into this scene's empty sequencer"""

    bl_idname = "mcsl.build_timeline"
    bl_label = "Build Timeline from EDL..."
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    filepath: bpy.props.StringProperty(subtype="FILE_PATH", name="EDL")
    filter_glob: bpy.props.StringProperty(default="*.json", options={"HIDDEN"})

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        scene = _scene(context)
        if scene.sequence_editor is not None and scene.sequence_editor.strips:
            self.report({"ERROR"}, "This scene's sequencer is not empty. Add a new scene and build there")
            return {"CANCELLED"}
        path = Path(bpy.path.abspath(self.filepath))
        try:
            edl = edls.load(path)
            strips.use_sequencer_scene(scene)
            notes = strips.build(scene, make_plan(edl), path.parent)
        except McslError as error:
            if scene.sequence_editor is not None:
                scene.sequence_editor_clear()  # it was empty: leave it so
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        folder = Path(bpy.data.filepath).parent if bpy.data.filepath else None
        scenes.set_ids(scene, edl, path.resolve(), folder)
        if folder is not None:
            bpy.ops.file.make_paths_relative()
        for note in notes:
            self.report({"WARNING"}, note)
        self.report({"INFO"}, f"{len(edl.shots)} shots, {len(edl.overrides)} overrides")
        return {"FINISHED"}


class MCSL_OT_pull_overrides(bpy.types.Operator):
    """Write what you changed in the Programme strips into the EDL, as overrides that analysis never touches"""

    bl_idname = "mcsl.pull_overrides"
    bl_label = "Pull Overrides into EDL"

    @classmethod
    def poll(cls, context):
        return bool(_scene(context).get("mcsl_edl"))

    def execute(self, context):
        scene = _scene(context)
        try:
            path = scenes.edl_path(scene, Path(bpy.data.filepath))
            edl = edls.load(path)
            overrides = read_overrides(edl, strips.read(scene))
            if overrides != edl.overrides:
                edls.save(attrs.evolve(edl, overrides=overrides), path)
        except McslError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        scene["mcsl_overrides"] = len(overrides)
        changed = "written" if overrides != edl.overrides else "as they were"
        self.report({"INFO"}, f"{len(overrides)} override{'s' * (len(overrides) != 1)}, {changed}")
        return {"FINISHED"}


def _scene(context):
    """The scene the sequencer cuts; from 5.0 the workspace names it."""
    return getattr(context, "sequencer_scene", None) or context.scene


CLASSES = (MCSL_OT_build_timeline, MCSL_OT_pull_overrides)


def register() -> None:
    for kind in CLASSES:
        bpy.utils.register_class(kind)


def unregister() -> None:
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
