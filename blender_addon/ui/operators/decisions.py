# SPDX-License-Identifier: GPL-3.0-or-later
"""From shot to shot, and back to the automatic choice. Choosing a camera is multicam.py's.

No `from __future__ import annotations` here: Blender reads the properties from the annotations themselves.
"""

from collections.abc import Callable
from typing import ClassVar

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.timing import FrameRange

from ...core import multicam, shot_list
from ...core.revert import revert
from ...core.strip_plan import make_plan
from ...sequencer import scene_properties
from ...sequencer.compat import strips_of
from ...sequencer.edit import apply_settings, join
from ...sequencer.read import read_timeline
from ...sequencer.renew import lay_missing
from ...sequencer.touched import Work
from .. import refresh
from ..translations.lookup import told
from .on_timeline import OnTimeline

NAMED = 3  # stretches that show no shot


class GoTo(OnTimeline):
    """Goes to the row of the list of shots that ``find`` finds before or after the playhead; about: what it says."""

    find: Callable[..., int]
    about: Callable[..., dict[str, str]]

    direction: bpy.props.EnumProperty(
        name="Direction",
        items=[("NEXT", "Next", "Later than the playhead"), ("BACK", "Previous", "Before the playhead")],
    )

    @classmethod
    def description(cls, context, properties):
        return cls.about()[properties.direction]

    def change(self, context, scene):
        index = self.find(refresh.rows(), scene.frame_current - 1, back=self.direction == "BACK")
        if index < 0:
            return self.leave(self.about()["NONE"])
        context.window_manager.mcsl_state.active_shot = index
        return {"FINISHED"}


class MCSL_OT_go_to_override(GoTo, bpy.types.Operator):
    """Go to the next stretch that an editor decided"""

    bl_idname = "mcsl.go_to_override"
    bl_label = "Go to Override"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    find = staticmethod(shot_list.next_override)

    @staticmethod
    def about():
        return {
            "NEXT": told("Go to the next stretch that an editor decided"),
            "BACK": told("Go to the previous stretch that an editor decided"),
            "NONE": told("There is no other override"),
        }


class MCSL_OT_go_to_cut(GoTo, bpy.types.Operator):
    """Go to the next cut of the programme"""

    bl_idname = "mcsl.go_to_cut"
    bl_label = "Go to Cut"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    find = staticmethod(shot_list.next_cut)

    @staticmethod
    def about():
        return {
            "NEXT": told("Go to the next cut of the programme"),
            "BACK": told("Go to the previous cut of the programme"),
            "NONE": told("There is no other cut"),
        }


class MCSL_OT_join(OnTimeline, bpy.types.Operator):
    """Take away cuts that nobody sees: between neighbouring strips of one camera that say the same"""

    bl_idname = "mcsl.join"
    bl_label = "Join Through-Edits"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    def change(self, context, scene):
        state, work = read_timeline(scene), Work(scene)
        touched = {strip.name for strip in strips_of(scene, "MULTICAM") if work.on(strip)}
        count = join(scene, multicam.through_edits(state.strips, touched))
        if not count:
            return self.leave(told("There is no such cut"))
        refresh.refresh_timeline(scene)
        self.report({"INFO"}, told("{count} cuts taken away").format(count=count))
        return {"FINISHED"}


class MCSL_OT_revert(OnTimeline, bpy.types.Operator):
    """Set the shot at the playhead back to the automatic camera, look and centre"""

    bl_idname = "mcsl.revert"
    bl_label = "Revert to Automatic"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    everything: bpy.props.BoolProperty(name="Everything", description="All shots, not the one at the playhead")

    @classmethod
    def description(cls, context, properties):
        if properties.everything:
            return told("Set all shots back to the automatic cameras, looks and centres")
        return told("Set the shot at the playhead back to the automatic camera, look and centre")

    def invoke(self, context, event):
        if self.everything:
            return context.window_manager.invoke_confirm(self, event)
        return self.execute(context)

    def change(self, context, scene):
        edl = refresh.decided(scene)
        rows = shot_list.rows_of(edl)
        index = shot_list.row_at(rows, scene.frame_current - 1)
        if index < 0 and not self.everything:
            return self.leave(told("The playhead is outside the programme"), "WARNING")
        piece = FrameRange(0, edl.frames) if self.everything else rows[index].range
        original = scene_properties.edl_of(scene)
        settings = revert(original, read_timeline(scene), piece)
        apply_settings(scene, settings, original.look)
        lay_missing(scene, make_plan(refresh.decided(scene)), piece)
        refresh.refresh_timeline(scene)
        left = sum(row.overridden for row in refresh.rows())
        self.report({"INFO"}, told("automatic again; {count} overrides left").format(count=left))
        for span, name in multicam.muted_over(read_timeline(scene).strips, [piece])[:NAMED]:
            text = told("frames {first} to {last} show no shot: {strip} is muted there. Unmute it, or delete it first")
            self.report({"WARNING"}, text.format(first=span.start + 1, last=span.stop, strip=name))
        return {"FINISHED"}


CLASSES = (MCSL_OT_go_to_override, MCSL_OT_go_to_cut, MCSL_OT_join, MCSL_OT_revert)
