# SPDX-License-Identifier: GPL-3.0-or-later
"""The cut for other editors.

No `from __future__ import annotations` here: Blender reads the properties from the annotations themselves.
"""

from pathlib import Path
from typing import ClassVar

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.errors import McslError

from ...core import camera_files
from ...sequencer import scene_properties
from ...sequencer.compat import sequencer_scene
from .. import job_runner, preferences
from ..translations.lookup import told
from .timeline import pull


class MCSL_OT_export(bpy.types.Operator):
    """Write the cut for another editor; `mcsl pull` reads back what is changed there"""

    bl_idname = "mcsl.export"
    bl_label = "Export for Another Editor..."
    bl_options: ClassVar = {"REGISTER"}

    filepath: bpy.props.StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE"})
    kind: bpy.props.EnumProperty(
        name="Format",
        items=[
            (".fcpxml", "FCPXML", "For Final Cut Pro and DaVinci Resolve"),
            (".xml", "Final Cut Pro 7 XML", "For Premiere Pro and DaVinci Resolve"),
            (".otio", "OpenTimelineIO", "For DaVinci Resolve, Premiere Pro and others"),
            (".edl", "EDL (CMX3600)", "For everything else: one track of pictures"),
        ],
    )
    exact: bpy.props.BoolProperty(
        name="Exact Pictures",
        description="The conformed programme, a clip a shot; else the cameras' own files, roughly aligned",
    )

    @classmethod
    def poll(cls, context):
        return scene_properties.has_timeline(sequencer_scene(context)) and not job_runner.busy()

    def invoke(self, context, event):
        if not self.filepath:
            edl = scene_properties.edl_path(sequencer_scene(context), Path(bpy.data.filepath))
            self.filepath = str(edl.with_name("cut.fcpxml"))
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        scene = sequencer_scene(context)
        try:
            pull(scene, self.report)
            path = scene_properties.edl_path(scene, Path(bpy.data.filepath))
            out = Path(bpy.path.abspath(self.filepath)).with_suffix(self.kind)
            command = camera_files.export_command(preferences.mcsl(), str(path), str(out), exact=self.exact)
            job_runner.start(told("Exporting"), command, cwd=path.parent)
        except McslError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


CLASSES = (MCSL_OT_export,)
