# SPDX-License-Identifier: GPL-3.0-or-later
"""Whose sound the programme has: any camera's microphone, or none.

No `from __future__ import annotations` here: Blender reads the properties from the annotations themselves.
"""

from pathlib import Path
from typing import ClassVar

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.edl.checks import NO_SOUND
from mcsl_core.errors import McslError

from ...core.strip_plan import make_plan
from ...sequencer import scene_properties
from ...sequencer.build import deselect
from ...sequencer.compat import sequencer_scene
from ...sequencer.sound import choose_sound
from .. import refresh
from ..translations.lookup import shown, told

_items_kept: list[tuple[str, str, str]] = []  # Blender keeps no copy of what a callback returns


def _sources(_self, context):
    scene = sequencer_scene(context) if context is not None else None
    names = scene_properties.camera_names(scene) if scene_properties.has_timeline(scene) else []
    _items_kept[:] = [
        ("AUTOMATIC", shown("Automatic"), told("The reference camera's")),
        *((f"CAMERA {name}", name, told("This camera's microphone, in time with the pictures")) for name in names),
        ("NONE", shown("None"), told("A silent programme")),
    ]
    return _items_kept


class MCSL_OT_sound_from(bpy.types.Operator):
    """Choose the camera whose sound the programme has; sound that you changed yourself keeps your changes"""

    bl_idname = "mcsl.sound_from"
    bl_label = "Sound"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    source: bpy.props.EnumProperty(name="Sound", description="Whose sound the programme has", items=_sources)

    @classmethod
    def poll(cls, context):
        return scene_properties.has_timeline(sequencer_scene(context))

    def execute(self, context):
        scene = sequencer_scene(context)
        chosen = {"AUTOMATIC": "", "NONE": NO_SOUND}.get(self.source, self.source.removeprefix("CAMERA "))
        was = scene.get(scene_properties.SOUND_FROM)
        try:
            scene[scene_properties.SOUND_FROM] = chosen
            edl = refresh.decided(scene)
            base = scene_properties.edl_path(scene, Path(bpy.data.filepath)).parent
            notes = choose_sound(scene, make_plan(edl), base)
        except (McslError, RuntimeError) as error:
            if was is None:
                del scene[scene_properties.SOUND_FROM]
            else:
                scene[scene_properties.SOUND_FROM] = was
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        scene[scene_properties.SOUND_OF] = chosen
        deselect(scene)
        for note in notes:
            self.report({"WARNING"}, note)
        refresh.refresh_timeline(scene)
        return {"FINISHED"}


CLASSES = (MCSL_OT_sound_from,)
