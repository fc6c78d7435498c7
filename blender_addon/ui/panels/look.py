# SPDX-License-Identifier: GPL-3.0-or-later
"""Centering, fill, colour, surface and seeing through, for all and for the shot at the playhead."""

from __future__ import annotations

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.edl.field import HAND, MIDDLE, awaits_analysis, fields_now
from mcsl_core.edl.resolve import resolve
from mcsl_core.errors import McslError

from ...sequencer.compat import sequencer_scene
from .. import refresh
from ..operators.look import AIDS
from ..translations.lookup import shown
from .drawing import TimelinePanel, wrapped


class MCSL_PT_look(TimelinePanel, bpy.types.Panel):
    bl_label = "Look"
    bl_idname = "MCSL_PT_look"
    bl_order = 3

    def draw(self, context):
        layout = self.layout
        scene = sequencer_scene(context)
        try:
            edl = refresh.last(scene)
        except McslError as error:
            wrapped(layout, str(error), "ERROR")
            return
        frame = scene.frame_current - 1
        decision = next((d for stretch, d in resolve(edl) if frame in stretch), None)
        column = layout.column(align=True)
        heads = column.row(align=True)
        for text in ("", "All", "Shot"):
            heads.label(text=text)
        for aid, label, _ in AIDS:
            row = column.row(align=True)
            row.label(text=label)
            for whole, on in ((True, getattr(edl.look, aid)), (False, decision is not None and getattr(decision, aid))):
                cell = row.row(align=True)
                cell.enabled = whole or decision is not None
                button = cell.operator(
                    "mcsl.set_look",
                    text="On" if on else "Off",
                    icon="CHECKBOX_HLT" if on else "CHECKBOX_DEHLT",
                    depress=on,
                )
                button.aid, button.on, button.whole = aid, not on, whole
        row = layout.row(align=True)
        row.operator("mcsl.set_centre", icon="PIVOT_CURSOR")
        if decision is not None and decision.offset is not None:
            row.operator("mcsl.clear_centre", text="", icon="X")
            x, y = decision.offset
            layout.label(text=shown("Centre by hand: {x:+.0f}, {y:+.0f} pixels").format(x=x, y=y), translate=False)
        _draw_field(layout, edl, frame)
        layout.operator("mcsl.reset_alignment", icon="LOOP_BACK")


def _draw_field(layout, edl, frame):
    """Where the surgical field lies at the playhead, and the way to draw it."""
    held = next((stretch.by for stretch in fields_now(edl) if frame in stretch.range), "")
    if held == HAND:
        layout.label(text="Field: drawn by hand")
    elif held == MIDDLE:
        layout.label(text="Field: nothing shows it, the middle is taken")
    row = layout.row(align=True)
    row.operator("mcsl.draw_field", icon="GREASEPENCIL").more = False
    if held == HAND:
        row.operator("mcsl.draw_field", text="", icon="ADD").more = True
        row.operator("mcsl.clear_field", text="", icon="X")
    if awaits_analysis(edl):
        layout.label(text="Analyse again to use the field", icon="INFO")


CLASSES = (MCSL_PT_look,)
