# SPDX-License-Identifier: GPL-3.0-or-later
"""Stretches left out of what is delivered, and brought back: marks on the timeline, which are the editor's.

No `from __future__ import annotations` here: Blender reads the properties from the annotations themselves.
"""

from collections.abc import Sequence
from typing import ClassVar

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.edl import Edl
from mcsl_core.errors import InputError
from mcsl_core.timing import FrameRange, without

from ...core import shot_list
from ...core.removal import FoundRemoval, chosen, take_removal
from ...sequencer.compat import ends, strips_of
from ...sequencer.marks import mark, read_marks, unmark
from .. import refresh
from ..translations.lookup import told
from .on_timeline import OnTimeline


class MCSL_OT_remove(OnTimeline, bpy.types.Operator):
    """Leave the preview range (P) out of the video; without one the selected shots, or the one at the playhead"""

    bl_idname = "mcsl.remove"
    bl_label = "Remove"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    def change(self, context, scene):
        edl = refresh.decided(scene)
        found = read_marks(scene)
        pieces = without(_chosen(scene, edl), found.marks)
        if not pieces:
            return self.leave(told("That is removed already"))
        take_removal(edl, FoundRemoval((*found.marks, *pieces), found.upon))  # something must be left
        for piece in pieces:
            mark(scene, piece)
        refresh.refresh_timeline(scene)
        self.report({"INFO"}, told("{seconds} removed from the delivery").format(seconds=_seconds(edl, pieces)))
        return {"FINISHED"}


class MCSL_OT_bring_back(OnTimeline, bpy.types.Operator):
    """Deliver again what was removed of the preview range (P), or of the selected shots, or at the playhead"""

    bl_idname = "mcsl.bring_back"
    bl_label = "Bring Back"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    def change(self, context, scene):
        edl = refresh.decided(scene)
        if not any([unmark(scene, piece) for piece in _chosen(scene, edl)]):
            return self.leave(told("Nothing is removed there"))
        refresh.refresh_timeline(scene)
        back = without(edl.removed, refresh.last(scene).removed)
        self.report({"INFO"}, told("{seconds} delivered again").format(seconds=_seconds(edl, back)))
        return {"FINISHED"}


def _chosen(scene, edl: Edl) -> Sequence[FrameRange]:
    """What the editor means, in programme frames. InputError where that is nothing."""
    preview = (scene.frame_preview_start - 1, scene.frame_preview_end) if scene.use_preview_range else None
    selected = [ends(strip) for strip in strips_of(scene, "MULTICAM") if strip.select and not strip.mute]
    pieces = chosen(edl, scene.frame_current - 1, preview, selected)
    if not pieces:
        raise InputError(
            told("no frame of the programme is chosen"),
            remedy=told("Set a preview range (P), select shots, or move the playhead"),
        )
    return pieces


def _seconds(edl: Edl, pieces: Sequence[FrameRange]) -> str:
    return shot_list.seconds_text(float(sum(map(len, pieces)) / edl.rate))


CLASSES = (MCSL_OT_remove, MCSL_OT_bring_back)
