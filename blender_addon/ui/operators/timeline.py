# SPDX-License-Identifier: GPL-3.0-or-later
"""An EDL's timeline into this scene, and the editor's decisions back into the EDL.

Everything is decided in core/strip_plan.py and core/read_overrides.py; here stand the file dialogue, the messages and
the order. No `from __future__ import annotations` here: Blender reads the properties from the annotations themselves.
"""

from pathlib import Path
from typing import ClassVar

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core import edl as edls
from mcsl_core.edl import Edl
from mcsl_core.errors import InputError, McslError
from mcsl_core.outputs.locks import changing

from ...core.field import remarks_on_drawing
from ...core.overruled import overruled
from ...core.strip_plan import make_plan
from ...sequencer import conformed, scene_properties
from ...sequencer.build import build_timeline
from ...sequencer.compat import sequencer_scene, use_sequencer_scene
from ...sequencer.edit import clear_strip_decisions
from ...sequencer.marks import lay_marks
from ...sequencer.proxies import attach_again
from ...sequencer.read import read_drawing, read_timeline
from ...sequencer.renew import rebuild_timeline
from .. import first_view, refresh
from ..translations.lookup import told
from .on_timeline import OnTimeline

PATIENCE_S = 5.0  # the window stands still meanwhile


def build_into(scene, path: Path) -> list[str]:
    """The timeline of an EDL into a scene whose sequencer is empty or holds one already; notes for a person.

    McslError leaves the scene as it was: what is there already is first built anew in a scene of its own.
    """
    edl = edls.load(path)
    plan = make_plan(edl)
    use_sequencer_scene(scene)
    new = not scene_properties.has_timeline(scene)
    if not new:
        trial = bpy.data.scenes.new("mcsl trial")
        try:
            build_timeline(trial, plan, path.parent)
        finally:
            bpy.data.scenes.remove(trial)
        notes = rebuild_timeline(scene, plan, path.parent, exact=conformed.all_hold(scene, edl))
        attach_again(scene)
    else:
        try:
            notes = build_timeline(scene, plan, path.parent)
        except McslError:
            if scene.sequence_editor is not None:
                scene.sequence_editor_clear()  # it was empty: leave it so
            raise
    folder = Path(bpy.data.filepath).parent if bpy.data.filepath else None
    scene_properties.set_ids(scene, edl, path.resolve(), folder)
    refresh.show_recording(scene)
    if folder is not None:
        bpy.ops.file.make_paths_relative()
    refresh.refresh_timeline(scene)
    _push_undo("mcsl: timeline")
    if new:
        first_view.show_timeline()
    else:
        first_view.open_tab()
    return notes


def _push_undo(message: str) -> None:
    """A step of its own where no operator makes one; without a window there is no undo."""
    if not bpy.app.background:
        bpy.ops.ed.undo_push(message=message)


def pull(scene, tell=None) -> tuple[Edl, bool]:
    """Writes the timeline's decisions into the scene's EDL; the EDL as it is then, and whether it was changed.

    tell: an operator's ``report``, for what others had decided and the timeline takes back.

    What other programs write into it meanwhile stays. McslError, for a folder that cannot be written to as well: then
    nothing has changed.
    """
    blend = Path(bpy.data.filepath)
    path = scene_properties.edl_path(scene, blend)
    old, new = scene_properties.edl_of(scene), refresh.decided(scene)
    if new != old:
        with changing(path, PATIENCE_S):
            old, new = scene_properties.edl_of(scene), refresh.decided(scene)  # on what is there now
            if new != old:
                edls.save(new, path)
        if tell is not None:
            for note in overruled(old, new, scene.get(scene_properties.OVERRIDE_COUNT)):
                tell({"WARNING"}, note)
    if tell is not None:
        for note in remarks_on_drawing(old, read_drawing(scene)):
            tell({"WARNING"}, note)
    scene_properties.note_home(scene, path, blend.parent if bpy.data.filepath else None)
    clear_strip_decisions(scene)
    lay_marks(scene, new.removed)
    scene[scene_properties.OVERRIDE_COUNT] = len(new.overrides)
    return new, new != old


class MCSL_OT_build_timeline(bpy.types.Operator):
    """Build the timeline of an EDL that mcsl made into this scene's empty sequencer"""

    bl_idname = "mcsl.build_timeline"
    bl_label = "Build Timeline from EDL..."
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    filepath: bpy.props.StringProperty(subtype="FILE_PATH", name="EDL")
    filter_glob: bpy.props.StringProperty(default="*.json", options={"HIDDEN"})

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        scene = sequencer_scene(context)
        try:
            if scene.sequence_editor is not None and scene.sequence_editor.strips:
                raise InputError(
                    told("this scene's sequencer is not empty"), remedy=told("Add a new scene and build there")
                )
            notes = build_into(scene, Path(bpy.path.abspath(self.filepath)))
        except McslError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for note in notes:
            self.report({"INFO"}, note)
        edl = scene_properties.edl_of(scene)
        text = told("{shots} shots, {overrides} overrides")
        self.report({"INFO"}, text.format(shots=len(edl.shots), overrides=len(edl.overrides)))
        return {"FINISHED"}


class MCSL_OT_pull_overrides(OnTimeline, bpy.types.Operator):
    """Write what you decided in the timeline into the EDL, as overrides that analysis never touches"""

    bl_idname = "mcsl.pull_overrides"
    bl_label = "Pull Overrides into EDL"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    def change(self, context, scene):
        edl, written = pull(scene, self.report)
        notes = read_timeline(scene).notes
        for note in notes:
            self.report({"WARNING"}, note)
        text = told("{count} overrides written") if written else told("{count} overrides, as they were")
        self.report({"INFO"}, text.format(count=len(edl.overrides)))
        return {"FINISHED"}


CLASSES = (MCSL_OT_build_timeline, MCSL_OT_pull_overrides)
