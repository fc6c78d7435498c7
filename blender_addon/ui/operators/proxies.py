# SPDX-License-Identifier: GPL-3.0-or-later
"""Proxies of the camera files by one click, built by Blender itself while work goes on."""

from typing import ClassVar

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.errors import InputError, McslError

from ...sequencer import proxies
from ...sequencer.compat import sequencer_scene
from ...sequencer.scene_properties import has_timeline
from ..translations.lookup import told


class MCSL_OT_build_proxies(bpy.types.Operator):
    """Let the preview play smoothly, by small copies of the camera files beside the .blend; renders do not use them"""

    bl_idname = "mcsl.build_proxies"
    bl_label = "Build Proxies"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return has_timeline(sequencer_scene(context))

    def execute(self, context):
        scene = sequencer_scene(context)
        try:
            if not bpy.data.filepath:
                raise InputError(told("the file has no name yet"), remedy=told("Save it: proxies lie beside it"))
            films = proxies.attach(scene)
        except McslError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        # in a window it runs beside the work, with a bar and a cross in the status bar
        how = "EXEC_DEFAULT" if bpy.app.background else "INVOKE_DEFAULT"
        with proxies.selected(scene, films):
            bpy.ops.sequencer.rebuild_proxy(how)
        proxies.show(context.window_manager)
        self.report({"INFO"}, told("proxies of {count} camera files").format(count=len(films)))
        return {"FINISHED"}


CLASSES = (MCSL_OT_build_proxies,)
