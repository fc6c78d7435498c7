# SPDX-License-Identifier: GPL-3.0-or-later
"""The visual aids, for all and for one shot, and the centre by hand.

No `from __future__ import annotations` here: Blender reads the properties from the annotations themselves.
"""

from typing import ClassVar

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.edl.resolve import resolve, shift_at

from ...core import multicam
from ...core.preview import moves_view
from ...core.read_overrides import AUTOMATIC
from ...sequencer.read import read_timeline
from ...sequencer.scene_properties import CENTRE, LOOK_FOR_ALL, LOOK_OF_SHOT
from .. import refresh
from ..translations.lookup import told
from .on_timeline import OnTimeline
from .preview import ClicksInPreview

AIDS = [
    ("centering", "Centering", "Shift the surgical field to the middle of the picture"),
    ("fill", "Fill", "Fill what the camera does not see from the other cameras"),
    ("colour", "Colour", "Match each camera's colours to the reference camera's"),
    ("surface", "Surface", "Align the cameras by the relief of the field, not by a plane"),
    ("see_through", "See Through", "Show what another camera sees under heads and arms"),
]


def shot_at_playhead(scene):
    """The Multicam strip that decides at the playhead, or None."""
    found = multicam.deciding(read_timeline(scene).strips, scene.frame_current - 1)
    return None if found is None else scene.sequence_editor.strips[found.name]


class MCSL_OT_set_look(OnTimeline, bpy.types.Operator):
    """Switch a visual aid on or off"""

    bl_idname = "mcsl.set_look"
    bl_label = "Set Look"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    aid: bpy.props.EnumProperty(name="Aid", items=AIDS)
    on: bpy.props.BoolProperty(name="On", description="Switch it on, or off", default=True)
    whole: bpy.props.BoolProperty(name="All", description="For the whole programme, not the shot at the playhead")

    @classmethod
    def description(cls, context, properties):
        about = told(next(text for name, _, text in AIDS if name == properties.aid))
        where = told("for the whole programme") if properties.whole else told("for the shot at the playhead")
        return f"{about} ({where})"

    def change(self, context, scene):
        if self.whole:
            scene[LOOK_FOR_ALL[self.aid]] = self.on
        else:
            strip = shot_at_playhead(scene)
            if strip is None:
                return self.leave(told("There is no shot at the playhead"), "WARNING")
            strip[LOOK_OF_SHOT[self.aid]] = self.on
        refresh.refresh_timeline(scene)
        return {"FINISHED"}


class MCSL_OT_set_centre(OnTimeline, ClicksInPreview, bpy.types.Operator):
    """Click the middle of the field in the preview: the shot at the playhead is centred on it"""

    bl_idname = "mcsl.set_centre"
    bl_label = "Set Centre by Hand"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    x: bpy.props.FloatProperty(name="X", description="Pixels from the left of the picture", options={"SKIP_SAVE"})
    y: bpy.props.FloatProperty(name="Y", description="Pixels from the top of the picture", options={"SKIP_SAVE"})

    def invoke(self, context, event):
        return self.begin(context, told("Click the middle of the field in the preview; Esc: leave it"))

    def modal(self, context, event):
        if moves_view(event.type):
            return {"PASS_THROUGH"}
        if event.type in {"ESC", "RIGHTMOUSE"}:
            self.cancel(context)
            return {"CANCELLED"}
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"RUNNING_MODAL"}
        point = self.point(context, event)
        self.cancel(context)
        if point is None:
            return {"CANCELLED"}
        self.x, self.y = point
        return self.execute(context)

    def change(self, context, scene):
        edl = refresh.decided(scene)
        frame = scene.frame_current - 1
        decision = next((d for stretch, d in resolve(edl) if frame in stretch), None)
        strip = shot_at_playhead(scene)
        if strip is None or decision is None:
            return self.leave(told("There is no shot at the playhead"), "WARNING")
        now = shift_at(edl, decision, frame)
        middle = ((edl.size[0] - 1) / 2, (edl.size[1] - 1) / 2)
        strip[CENTRE] = [round(m - (p - s), 3) for m, p, s in zip(middle, (self.x, self.y), now, strict=True)]
        if not decision.centering:
            strip[LOOK_OF_SHOT["centering"]] = True
        refresh.refresh_timeline(scene)
        return {"FINISHED"}


class MCSL_OT_clear_centre(OnTimeline, bpy.types.Operator):
    """Centre the shot at the playhead by the analysis again"""

    bl_idname = "mcsl.clear_centre"
    bl_label = "Centre Automatically"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    def change(self, context, scene):
        strip = shot_at_playhead(scene)
        if strip is None:
            return self.leave(told("There is no shot at the playhead"), "WARNING")
        strip[CENTRE] = AUTOMATIC
        refresh.refresh_timeline(scene)
        return {"FINISHED"}


CLASSES = (MCSL_OT_set_look, MCSL_OT_set_centre, MCSL_OT_clear_centre)
