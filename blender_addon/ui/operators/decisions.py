# SPDX-License-Identifier: GPL-3.0-or-later
"""From shot to shot, and back to the automatic choice. Choosing a camera is by_hand.py's.

No `from __future__ import annotations` here: Blender reads the properties from the annotations themselves.
"""

from typing import ClassVar

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.errors import McslError
from mcsl_core.timing import FrameRange

from ...core import revert as reverting
from ...core import shot_list as shots
from ...sequencer import scene_properties as scenes
from ...sequencer.compat import sequencer_scene
from ...sequencer.edit import apply_settings
from ...sequencer.read import read_timeline
from .. import refresh as watching
from ..translations.lookup import told


def has_timeline(context) -> bool:
    scene = sequencer_scene(context)
    return scene is not None and bool(scene.get("mcsl_edl")) and scene.sequence_editor is not None


class MCSL_OT_go_to_override(bpy.types.Operator):
    """Go to the next stretch that an editor decided"""

    bl_idname = "mcsl.go_to_override"
    bl_label = "Go to Override"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    direction: bpy.props.EnumProperty(
        name="Direction",
        items=[("NEXT", "Next", "Later than the playhead"), ("BACK", "Previous", "Before the playhead")],
    )

    @classmethod
    def poll(cls, context):
        return has_timeline(context)

    @classmethod
    def description(cls, context, properties):
        if properties.direction == "BACK":
            return told("Go to the previous stretch that an editor decided")
        return told("Go to the next stretch that an editor decided")

    def execute(self, context):
        scene = sequencer_scene(context)
        rows = watching.rows()
        index = shots.next_override(rows, scene.frame_current - 1, back=self.direction == "BACK")
        if index < 0:
            self.report({"INFO"}, told("There is no other override"))
            return {"CANCELLED"}
        context.window_manager.mcsl_state.active_shot = index
        return {"FINISHED"}


class MCSL_OT_revert(bpy.types.Operator):
    """Set the shot at the playhead back to the automatic camera, look and centre"""

    bl_idname = "mcsl.revert"
    bl_label = "Revert to Automatic"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    everything: bpy.props.BoolProperty(name="Everything", description="All shots, not the one at the playhead")

    @classmethod
    def poll(cls, context):
        return has_timeline(context)

    @classmethod
    def description(cls, context, properties):
        if properties.everything:
            return told("Set all shots back to the automatic cameras, looks and centres")
        return told("Set the shot at the playhead back to the automatic camera, look and centre")

    def invoke(self, context, event):
        if self.everything:
            return context.window_manager.invoke_confirm(self, event)
        return self.execute(context)

    def execute(self, context):
        scene = sequencer_scene(context)
        try:
            edl = watching.decided(scene)
            rows = shots.rows_of(edl)
            index = shots.row_at(rows, scene.frame_current - 1)
            if self.everything:
                piece = FrameRange(0, edl.frames)
            elif index >= 0:
                piece = rows[index].range
            else:
                self.report({"WARNING"}, told("The playhead is outside the programme"))
                return {"CANCELLED"}
            original = scenes.edl_of(scene)
            settings = reverting.revert(original, read_timeline(scene), piece)
        except McslError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        apply_settings(scene, settings, original.look)
        watching.look(scene)
        left = sum(row.overridden for row in watching.rows())
        self.report({"INFO"}, told("automatic again; {count} overrides left").format(count=left))
        return {"FINISHED"}


CLASSES = (MCSL_OT_go_to_override, MCSL_OT_revert)
