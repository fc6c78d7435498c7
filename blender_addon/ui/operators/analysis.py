# SPDX-License-Identifier: GPL-3.0-or-later
"""Analysing from the panel: `mcsl analyse` in a child process, then its timeline.

No `from __future__ import annotations` here: Blender reads the properties from the annotations themselves.
"""

from pathlib import Path
from typing import ClassVar

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.edl import Edl
from mcsl_core.errors import InputError, McslError

from ...core import camera_files
from ...core.camera_files import STAGES
from ...core.read_overrides import read_edl
from ...sequencer.compat import sequencer_scene
from ...sequencer.read import read_timeline
from ...sequencer.scene_properties import EDL_PATH, edl_path, has_timeline
from .. import job_runner, preferences
from ..translations.lookup import told
from .recording import work_of
from .timeline import build_into, pull


class MCSL_OT_analyse(bpy.types.Operator):
    """Let mcsl decide: alignment, movements of the lamp, shots and centering; then build the timeline"""

    bl_idname = "mcsl.analyse"
    bl_label = "Analyse"
    bl_options: ClassVar = {"REGISTER"}

    @classmethod
    def poll(cls, context):
        if job_runner.busy():
            return False
        if not work_of(context).cameras:
            cls.poll_message_set("Add camera files first")
            return False
        return True

    def execute(self, context):
        scene = sequencer_scene(context)
        try:
            command, edl = _command(scene)
            began: Edl | None = None
            if has_timeline(scene):
                began, _ = pull(scene, self.report)  # what was decided by hand goes through the analysis with the EDL
            elif scene.sequence_editor is not None and scene.sequence_editor.strips:
                raise InputError(
                    told("this scene's sequencer is not empty"), remedy=told("Add a new scene and analyse there")
                )
            name = scene.name

            def follow(_result):
                if (target := bpy.data.scenes.get(name)) is None:
                    raise InputError(
                        told("the scene {name} is gone").format(name=name),
                        remedy=told("Build the timeline of {edl} by hand").format(edl=edl),
                    )
                if began is not None:
                    _keep_decisions(target, began)
                for note in build_into(target, edl):
                    job_runner.say(note, "INFO", told("Analysis"))

            job_runner.start(told("Analysis"), command, follow, cwd=edl.parent)
        except (McslError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


def _keep_decisions(scene, began: Edl) -> None:
    """What was decided in the timeline since an analysis of ``began`` goes into its EDL, before it is built anew.

    McslError where that cannot be: the timeline then has to stay as it is.
    """
    if read_edl(began, read_timeline(scene)) != began:
        pull(scene, lambda _, note: job_runner.say(note, "WARNING", told("Analysis")))


def edl_of_work(work) -> Path:
    """Where the EDL goes: as named, else edl.json beside the first camera file."""
    if work.edl:
        path = Path(bpy.path.abspath(work.edl))
        return path if path.suffix == ".json" else path.with_suffix(".json")
    return Path(work.cameras[0].paths()[0]).parent / "edl.json"


def _command(scene) -> tuple[list[str], Path]:
    """The command and the EDL it writes; InputError for what can be seen before it starts."""
    work = scene.mcsl_work
    files = [path for camera in work.cameras for path in camera.paths()]
    for path in files:
        if not Path(path).is_file():
            raise InputError(
                told("is missing"), where=path, remedy=told("Put it back, or take the camera off the list")
            )
    edl = edl_of_work(work)
    if has_timeline(scene) and work.edl == scene.get(EDL_PATH):
        edl = edl_path(scene, Path(bpy.data.filepath))  # a copied project's own, not the one that it was copied from
    if not edl.parent.is_dir():
        raise InputError(
            told("is not a folder"), where=str(edl.parent), remedy=told("Choose another place for the EDL")
        )
    stages = {stage: work.plugin(stage) for stage in STAGES}
    reference = work.reference or work.cameras[0].name
    return (
        camera_files.analyse_command(preferences.mcsl(), files, str(edl), reference=reference, stages=stages),
        edl,
    )


class MCSL_OT_cancel(bpy.types.Operator):
    """Stop; nothing half-written is left, and started again it carries on where it was"""

    bl_idname = "mcsl.cancel"
    bl_label = "Cancel"
    bl_options: ClassVar = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        return job_runner.desk.running is not None and not job_runner.desk.running.job.stopping

    def execute(self, context):
        job_runner.cancel()
        return {"FINISHED"}


class MCSL_OT_read_plugins(bpy.types.Operator):
    """Ask mcsl which plugins there are for each stage"""

    bl_idname = "mcsl.read_plugins"
    bl_label = "Show Plugins"
    bl_options: ClassVar = {"INTERNAL"}

    def execute(self, context):
        try:
            job_runner.read_plugins(preferences.mcsl())
        except McslError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


CLASSES = (MCSL_OT_analyse, MCSL_OT_cancel, MCSL_OT_read_plugins)
