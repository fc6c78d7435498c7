# SPDX-License-Identifier: GPL-3.0-or-later
"""The surgical field drawn by hand, corner by corner in the preview.

No `from __future__ import annotations` here: Blender reads the properties from the annotations themselves.
"""

from typing import ClassVar

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.errors import Fault, McslError

from ...core.field import with_field, without_field
from ...core.preview import moves_view
from ...core.read_overrides import read_edl
from ...sequencer.compat import sequencer_scene
from ...sequencer.edit import keep_drawing
from ...sequencer.read import read_timeline
from ...sequencer.scene_properties import edl_of, has_timeline
from .. import refresh
from ..translations.lookup import told
from .on_timeline import OnTimeline
from .preview import ClicksInPreview, redraw

CLOSE_PX = 12  # a click this near the first corner closes the outline


class MCSL_OT_draw_field(ClicksInPreview, bpy.types.Operator):
    """Click the corners of the surgical field in the preview; the next analysis aligns, scores and centres by it"""

    bl_idname = "mcsl.draw_field"
    bl_label = "Draw Field by Hand"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    corners: bpy.props.StringProperty(
        name="Corners", description="Pixels of the picture shown: x,y x,y x,y", options={"SKIP_SAVE"}
    )
    frame: bpy.props.IntProperty(
        name="Frame", description="Programme frame that the corners were seen in", options={"SKIP_SAVE", "HIDDEN"}
    )
    more: bpy.props.BoolProperty(name="One More", description="Beside what is drawn already, not in its place")

    @classmethod
    def poll(cls, context):
        return has_timeline(sequencer_scene(context))

    def invoke(self, context, event):
        self._clicked = []
        text = told("Click the corners of the field; Enter: done; Backspace: take the last back; Esc: leave it")
        return self.begin(context, text, _draw, self._clicked)

    def modal(self, context, event):
        if moves_view(event.type):
            return {"PASS_THROUGH"}
        if event.type in {"ESC", "RIGHTMOUSE"}:
            self.cancel(context)
            return {"CANCELLED"}
        if event.value != "PRESS" or event.type not in {"BACK_SPACE", "LEFTMOUSE", "RET", "NUMPAD_ENTER"}:
            return {"RUNNING_MODAL"}
        if event.type in {"RET", "NUMPAD_ENTER"}:
            return self._done(context)
        if event.type == "BACK_SPACE":
            del self._clicked[-1:]
        elif (point := self.point(context, event)) is not None:
            if self._closes(point):
                return self._done(context)
            if not self._clicked:
                self.frame = sequencer_scene(context).frame_current - 1
            self._clicked.append(point)
        redraw(context)
        return {"RUNNING_MODAL"}

    def _closes(self, point):
        if len(self._clicked) < 3:
            return False
        x, y = self._clicked[0]
        return abs(point[0] - x) + abs(point[1] - y) < CLOSE_PX

    def _done(self, context):
        self.cancel(context)
        redraw(context)
        self.corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in self._clicked)
        return self.execute(context)

    def execute(self, context):
        scene = sequencer_scene(context)
        try:
            corners = [(float(x), float(y)) for x, y in (corner.split(",") for corner in self.corners.split())]
            edl = edl_of(scene)
            seen = self.frame if self.properties.is_property_set("frame") else scene.frame_current - 1
            new = with_field(read_edl(edl, read_timeline(scene)), seen, corners, more=self.more)
        except McslError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        except (Fault, ValueError):
            self.report({"WARNING"}, told("Three corners or more make a field, in the picture and not in a line"))
            return {"CANCELLED"}
        keep_drawing(scene, new.drawn_fields, edl.drawn_fields)
        refresh.refresh_timeline(scene)
        self.report({"INFO"}, told("The field is drawn: analyse again to use it"))
        return {"FINISHED"}


def _draw(clicked):
    """What was clicked so far, over the preview."""
    import gpu  # pyright: ignore[reportMissingImports] - there is none without a window
    from gpu_extras.batch import batch_for_shader  # pyright: ignore[reportMissingImports]

    scene, view = sequencer_scene(bpy.context), bpy.context.region.view2d
    middle = ((scene.render.resolution_x - 1) / 2, (scene.render.resolution_y - 1) / 2)
    points = [view.view_to_region(x - middle[0], middle[1] - y, clip=False) for x, y in clicked]
    if not points:
        return
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    shader.uniform_float("color", (1.0, 1.0, 0.3, 1.0))
    gpu.state.line_width_set(2.0)
    gpu.state.point_size_set(6.0)
    for kind, places in (("LINE_STRIP", [*points, points[0]]), ("POINTS", points)):
        batch_for_shader(shader, kind, {"pos": places}).draw(shader)


class MCSL_OT_clear_field(OnTimeline, bpy.types.Operator):
    """Take the field that is drawn away: the next analysis finds it in the pictures again"""

    bl_idname = "mcsl.clear_field"
    bl_label = "Find Field Automatically"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    def change(self, context, scene):
        edl = edl_of(scene)
        new = without_field(read_edl(edl, read_timeline(scene)), scene.frame_current - 1)
        keep_drawing(scene, new.drawn_fields, edl.drawn_fields)
        refresh.refresh_timeline(scene)
        return {"FINISHED"}


CLASSES = (MCSL_OT_draw_field, MCSL_OT_clear_field)
