# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel edits: with the scene, the recording to analyse and the delivery; with the window, the list of shots.

No `from __future__ import annotations` here: Blender reads the properties from the annotations themselves.
"""

from pathlib import Path

import bpy  # pyright: ignore[reportMissingImports]

from ..core import presets
from ..core.camera_files import STAGES, as_text, plugin_number
from ..sequencer.compat import sequencer_scene
from . import job_runner
from .translations.lookup import shown

DEFAULT = "DEFAULT"

_kept: dict = {}  # Blender does not keep the texts of dynamic enums: somebody must


def _numbers(stage: str) -> dict[int, str]:
    """A number for every plugin of a stage that does not change when others come and go; 0 is the default."""
    names = [row.name for row in job_runner.desk.offers.get(stage, ())]
    return {0: "", **{plugin_number(name): name for name in names}}


def _stage_items(stage: str):
    def items(self, context):
        rows = job_runner.desk.offers.get(stage, ())
        default = next((row.name for row in rows if row.default), "")
        label = shown("Default ({name})").format(name=as_text(default)) if default else shown("Default")
        found = [(DEFAULT, label, shown("What mcsl takes by itself"), "NONE", 0)]
        for row in rows:
            name, text = as_text(row.name), as_text(f"{row.summary} ({row.package} {row.version})")
            found.append((name, name, text, "NONE", plugin_number(row.name)))
        _kept[stage] = found
        return found

    return items


def _stage_get(stage: str):
    def get(self):
        name = self.get(f"plugin_{stage}", "")
        return next((number for number, known in _numbers(stage).items() if known == name), 0)

    return get


def _stage_set(stage: str):
    def set_(self, number):
        self[f"plugin_{stage}"] = _numbers(stage).get(number, "")

    return set_


def _preset_items(self, context):
    if "presets" not in _kept:
        found = presets.load_all().items()
        _kept["presets"] = [(name, p.title, p.description, "NONE", i) for i, (name, p) in enumerate(found)]
    return _kept["presets"]


class MCSL_Camera(bpy.types.PropertyGroup):
    """A camera of the recording to analyse; `name` is its name, `files` its files, one a line."""

    files: bpy.props.StringProperty(name="Files", description="The camera's files, played one after another")

    def paths(self) -> list[str]:
        return [str(Path(bpy.path.abspath(line))) for line in self.files.splitlines()]


class MCSL_Work(bpy.types.PropertyGroup):
    """Saved with the scene."""

    cameras: bpy.props.CollectionProperty(type=MCSL_Camera)
    active_camera: bpy.props.IntProperty(name="Camera", description="What the buttons beside the list act on")
    reference: bpy.props.StringProperty(
        name="Reference", description="The camera whose perspective the programme keeps. Empty: the first"
    )
    edl: bpy.props.StringProperty(
        name="EDL",
        description="The file that takes all decisions. Empty: edl.json beside the first camera file",
        subtype="FILE_PATH",
        options={"PATH_SUPPORTS_BLEND_RELATIVE"},
    )
    preset: bpy.props.EnumProperty(name="Preset", description="What is delivered", items=_preset_items)
    video: bpy.props.StringProperty(
        name="Output",
        description="The video. Empty: beside the .blend, under its name",
        subtype="FILE_PATH",
        options={"PATH_SUPPORTS_BLEND_RELATIVE"},
    )

    def plugin(self, stage: str) -> str:
        """The plugin chosen for a stage; '' for the default."""
        return self.get(f"plugin_{stage}", "")


for _stage, _label in STAGES.items():
    MCSL_Work.__annotations__[_stage] = bpy.props.EnumProperty(
        name=_label,
        description="The plugin that does this stage",
        items=_stage_items(_stage),
        get=_stage_get(_stage),
        set=_stage_set(_stage),
    )


class MCSL_Shot(bpy.types.PropertyGroup):
    """A row of the list of shots; see `shot_list.ShotRow`. Frames are the programme's."""

    start: bpy.props.IntProperty()
    stop: bpy.props.IntProperty()
    camera: bpy.props.StringProperty()
    automatic: bpy.props.StringProperty()
    score: bpy.props.FloatProperty()
    why: bpy.props.StringProperty()
    overridden: bpy.props.BoolProperty()
    time: bpy.props.StringProperty()


def _go_there(self, context):
    """A click on a row: the playhead goes to the shot's beginning."""
    if 0 <= self.active_shot < len(self.shots):
        sequencer_scene(context).frame_set(self.shots[self.active_shot].start + 1)


class MCSL_State(bpy.types.PropertyGroup):
    """Follows the timeline while the window is open; not saved."""

    shots: bpy.props.CollectionProperty(type=MCSL_Shot)
    active_shot: bpy.props.IntProperty(
        name="Shot", description="Click to go to the shot", update=_go_there, options={"SKIP_SAVE"}
    )
    overrides: bpy.props.IntProperty()
    short_shots: bpy.props.IntProperty()
    outstanding_s: bpy.props.FloatProperty()
    lost_s: bpy.props.FloatProperty()
    removed_s: bpy.props.FloatProperty()
    removals: bpy.props.IntProperty()
    problem: bpy.props.StringProperty()
    notices: bpy.props.StringProperty()


CLASSES = (MCSL_Camera, MCSL_Work, MCSL_Shot, MCSL_State)


def register() -> None:
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Scene.mcsl_work = bpy.props.PointerProperty(type=MCSL_Work)
    bpy.types.WindowManager.mcsl_state = bpy.props.PointerProperty(type=MCSL_State)


def unregister() -> None:
    del bpy.types.WindowManager.mcsl_state
    del bpy.types.Scene.mcsl_work
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
