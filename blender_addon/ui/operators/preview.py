# SPDX-License-Identifier: GPL-3.0-or-later
"""Clicks in the preview: how an operator that takes them begins, finds their pixels, and ends, whatever ends it."""

from __future__ import annotations

import bpy  # pyright: ignore[reportMissingImports]

from ...core.preview import Shows, shows
from ...sequencer.compat import sequencer_scene
from ...sequencer.scene_properties import role_of
from ..translations.lookup import told

_lines = []  # the handlers that draw over previews now: one at most


class ClicksInPreview:
    """The part that operators share which take clicks in the preview."""

    def begin(self, context, text, draw=None, *arguments):
        """What `invoke` returns. draw: called with the arguments wherever a preview is drawn."""
        seen = {found for _, found in _previews(context)}
        if Shows.PROGRAMME not in seen:
            self._warn_of(Shows.CHANNEL if Shows.CHANNEL in seen else Shows.NOTHING)
            return {"CANCELLED"}
        remove_lines()
        if draw is not None:
            _lines.append(bpy.types.SpaceSequenceEditor.draw_handler_add(draw, arguments, "PREVIEW", "POST_PIXEL"))
        context.window.cursor_modal_set("CROSSHAIR")
        context.workspace.status_text_set(text)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def cancel(self, context):
        """Called by Blender where it ends the operator: its window was closed, or a file is loaded."""
        remove_lines()
        if context.window is not None:
            context.window.cursor_modal_restore()
        if context.workspace is not None:
            context.workspace.status_text_set(None)

    def point(self, context, event):
        """The programme pixel under the mouse, or None where no preview shows the programme; told of another."""
        scene = sequencer_scene(context)
        for region, found in _previews(context):
            x, y = event.mouse_x - region.x, event.mouse_y - region.y
            if not (0 <= x < region.width and 0 <= y < region.height):
                continue
            if found is not Shows.PROGRAMME:
                self._warn_of(found)
                return None
            x, y = region.view2d.region_to_view(x, y)
            return (scene.render.resolution_x - 1) / 2 + x, (scene.render.resolution_y - 1) / 2 - y
        return None

    def _warn_of(self, found):
        if found is Shows.CHANNEL:
            text = told("The preview shows one channel: set its channel to 0 to see the programme")
        else:
            text = told("Open a preview beside the sequencer")
        self.report({"WARNING"}, text)  # pyright: ignore[reportAttributeAccessIssue] - the operator's


def remove_lines():
    """Nothing is drawn over previews any more."""
    while _lines:
        bpy.types.SpaceSequenceEditor.draw_handler_remove(_lines.pop(), "PREVIEW")


def redraw(context):
    """Previews are drawn anew."""
    for region, _ in _previews(context):
        region.tag_redraw()


def _previews(context):
    """The preview regions that can be seen, with what they show."""
    editor = sequencer_scene(context).sequence_editor
    strips = editor.strips if editor is not None else ()
    centering = min((s.channel for s in strips if role_of(s) == "centering"), default=None)
    for area in context.screen.areas:
        space = area.spaces.active
        for region in area.regions if area.type == "SEQUENCE_EDITOR" else ():
            if region.type != "PREVIEW":
                continue
            found = shows(space.view_type, (region.width, region.height), space.display_channel, centering)
            if found is not Shows.NOTHING:
                yield region, found
