# SPDX-License-Identifier: GPL-3.0-or-later
"""Stretches left out of what is delivered, and brought back: marks on the timeline, which are the editor's.

No `from __future__ import annotations` here: Blender reads the properties from the annotations themselves.
"""

from collections.abc import Sequence
from typing import ClassVar

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.edl import Edl
from mcsl_core.errors import InputError, McslError
from mcsl_core.timing import FrameRange, joined

from ...core import shot_list
from ...core.removal import FoundRemoval, take_removal
from ...core.stale import without
from ...sequencer import scene_properties
from ...sequencer.compat import ends, sequencer_scene, strips_of
from ...sequencer.marks import mark, read_marks, unmark
from .. import refresh
from ..translations.lookup import told


class MCSL_OT_remove(bpy.types.Operator):
    """Leave the preview range (P) out of the video; without one the selected shots, or the one at the playhead"""

    bl_idname = "mcsl.remove"
    bl_label = "Remove"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return scene_properties.has_timeline(sequencer_scene(context))

    def execute(self, context):
        scene = sequencer_scene(context)
        try:
            edl = refresh.decided(scene)
            found = read_marks(scene)
            pieces = without(_chosen(scene, edl), found.marks)
            if not pieces:
                self.report({"INFO"}, told("That is removed already"))
                return {"CANCELLED"}
            take_removal(edl, FoundRemoval((*found.marks, *pieces), found.upon))  # something must be left
            for piece in pieces:
                mark(scene, piece)
        except McslError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        refresh.refresh_timeline(scene)
        text = told("{seconds} removed from the delivery")
        self.report({"INFO"}, text.format(seconds=_seconds(edl, pieces)))
        return {"FINISHED"}


class MCSL_OT_bring_back(bpy.types.Operator):
    """Deliver again what was removed of the preview range (P), or of the selected shots, or at the playhead"""

    bl_idname = "mcsl.bring_back"
    bl_label = "Bring Back"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return scene_properties.has_timeline(sequencer_scene(context))

    def execute(self, context):
        scene = sequencer_scene(context)
        try:
            edl = refresh.decided(scene)
            was = sum(map(len, edl.removed))
            found = [unmark(scene, piece) for piece in _chosen(scene, edl)]
        except McslError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if not any(found):
            self.report({"INFO"}, told("Nothing is removed there"))
            return {"CANCELLED"}
        refresh.refresh_timeline(scene)
        back = was - sum(map(len, refresh.last(scene).removed))
        text = told("{seconds} delivered again")
        self.report({"INFO"}, text.format(seconds=shot_list.seconds_text(float(back / edl.rate))))
        return {"FINISHED"}


def _chosen(scene, edl: Edl) -> list[FrameRange]:
    """What the editor means, in programme frames. InputError where that is nothing."""
    if scene.use_preview_range:
        spans = [(scene.frame_preview_start - 1, scene.frame_preview_end)]
    else:
        spans = [ends(strip) for strip in strips_of(scene, "MULTICAM") if strip.select and not strip.mute]
    if not spans:
        rows = shot_list.rows_of(edl)
        index = shot_list.row_at(rows, scene.frame_current - 1)
        spans = [(rows[index].range.start, rows[index].range.stop)] if index >= 0 else []
    inside = [(max(start, 0), min(stop, edl.frames)) for start, stop in spans]
    pieces = joined(FrameRange(start, stop) for start, stop in inside if start < stop)
    if not pieces:
        raise InputError(
            told("no frame of the programme is chosen"),
            remedy=told("Set a preview range (P), select shots, or move the playhead"),
        )
    return pieces


def _seconds(edl: Edl, pieces: Sequence[FrameRange]) -> str:
    return shot_list.seconds_text(float(sum(map(len, pieces)) / edl.rate))


CLASSES = (MCSL_OT_remove, MCSL_OT_bring_back)
