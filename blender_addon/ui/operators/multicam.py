# SPDX-License-Identifier: GPL-3.0-or-later
"""Cutting by hand: a key or click for each camera, and strips set back to their automatic place.

What a press means is decided in core/multicam.py. Blender's own multicam keys take the number of a channel,
and ours have the sound on channel 1 and the reference camera last; so in an mcsl timeline key n is the EDL's n-th
camera. In every other scene the operator does not answer, and Blender's own gets the key. No `from __future__ import
annotations` here: Blender reads the properties from the annotations themselves.
"""

from typing import ClassVar

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.errors import InputError, McslError

from ...core import multicam
from ...sequencer import scene_properties
from ...sequencer.compat import sequencer_scene
from ...sequencer.edit import apply_switch
from ...sequencer.read import read_about
from ...sequencer.transforms import can_be_reset, reset_transform
from .. import refresh
from ..translations.lookup import told

KEYS = ("ONE", "TWO", "THREE", "FOUR", "FIVE", "SIX", "SEVEN", "EIGHT", "NINE")


class MCSL_OT_switch_camera(bpy.types.Operator):
    """Show this camera from the playhead to the end of the shot; Whole Shot: from its beginning"""

    bl_idname = "mcsl.switch_camera"
    bl_label = "Switch Camera"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    # SKIP_SAVE: without it a click on "whole shot" would hold for the next key as well
    number: bpy.props.IntProperty(
        name="Camera",
        description="Which of the EDL's cameras, counted from 1",
        min=0,
        max=32,
        default=0,
        options={"SKIP_SAVE"},
    )
    camera: bpy.props.StringProperty(
        name="Name", description="The camera's name, in place of its number", options={"SKIP_SAVE"}
    )
    whole: bpy.props.BoolProperty(
        name="Whole Shot", description="Change the whole shot in place of cutting it", options={"SKIP_SAVE"}
    )

    @classmethod
    def poll(cls, context):
        return scene_properties.has_timeline(sequencer_scene(context))

    def execute(self, context):
        scene = sequencer_scene(context)
        try:
            camera = self.camera or _nth_camera(scene, self.number)
            frame = scene.frame_current - 1
            about = read_about(scene, frame)
            change = multicam.switch(about, frame, camera, whole=self.whole)
        except McslError as error:
            self.report({"WARNING"}, str(error))
            return {"CANCELLED"}
        if change is None:
            self.report({"INFO"}, told("{camera} is shown already").format(camera=camera))
            return {"CANCELLED"}
        was = next(strip for strip in about.strips if strip.name == change.name)
        refresh.refresh_shot(scene, was, apply_switch(scene, change))
        text = told("{camera} from frame {frame}") if change.split is not None else "{camera}"
        self.report({"INFO"}, text.format(camera=camera, frame=scene.frame_current))
        return {"FINISHED"}


class MCSL_OT_reset_alignment(bpy.types.Operator):
    """Set the selected camera strips back to where the analysis placed them"""

    bl_idname = "mcsl.reset_alignment"
    bl_label = "Reset Alignment"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        scene = sequencer_scene(context)
        return scene is not None and any(can_be_reset(s) for s in _selected(scene))

    def execute(self, context):
        chosen = [s for s in _selected(sequencer_scene(context)) if can_be_reset(s)]
        for strip in chosen:
            reset_transform(strip)
        self.report({"INFO"}, told("Strips set back: {count}").format(count=len(chosen)))
        return {"FINISHED"}


def _selected(scene):
    return [] if scene.sequence_editor is None else [s for s in scene.sequence_editor.strips if s.select]


def _nth_camera(scene, number: int) -> str:
    names = scene_properties.camera_names(scene)
    if not 1 <= number <= len(names):
        raise InputError(
            told("there is no camera {number}").format(number=number),
            remedy=told("There are {count}: {names}").format(count=len(names), names=", ".join(names)),
        )
    return names[number - 1]


CLASSES = (MCSL_OT_switch_camera, MCSL_OT_reset_alignment)
_keys: list = []


def register() -> None:
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    configuration = bpy.context.window_manager.keyconfigs.addon
    if configuration is None:  # without a window there are no keys
        return
    keymap = configuration.keymaps.new(name="Sequencer", space_type="SEQUENCE_EDITOR")
    for number, key in enumerate(KEYS, 1):
        item = keymap.keymap_items.new(MCSL_OT_switch_camera.bl_idname, key, "PRESS")
        item.properties.number = number
        _keys.append((keymap, item))


def unregister() -> None:
    for keymap, item in _keys:
        keymap.keymap_items.remove(item)
    _keys.clear()
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
