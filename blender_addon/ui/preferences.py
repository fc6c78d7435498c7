# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's preferences: which `mcsl` runs, a button that tries it, and what to do where there is none.

No `from __future__ import annotations` here: Blender reads the properties from the annotations themselves.
"""

from pathlib import Path
from typing import ClassVar

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core import __version__
from mcsl_core.errors import McslError

from ..process import find_mcsl as finding
from . import job_runner as running
from .translations.lookup import told

ADDON = (__package__ or "mcsl.ui").removesuffix(".ui")  # what Blender knows the extension by


class MCSL_OT_test_mcsl(bpy.types.Operator):
    """Look for mcsl, run it once and show its version"""

    bl_idname = "mcsl.test_mcsl"
    bl_label = "Test"
    bl_options: ClassVar = {"INTERNAL"}

    def execute(self, context):
        try:
            found = finding.find(preferred())
            version = finding.version_of(found.path)
        except McslError as error:
            running.desk.mcsl = str(error)
            self.report({"WARNING"}, str(error))
            return {"CANCELLED"}
        running.desk.mcsl = told("mcsl {version} at {path}").format(version=version, path=found.path)
        if version.split(".")[:2] != __version__.split(".")[:2]:
            running.desk.mcsl += told("; this extension belongs to {version}").format(version=__version__)
        running.read_plugins(str(found.path))
        self.report({"INFO"}, running.desk.mcsl)
        return {"FINISHED"}


class MCSL_OT_copy_install_command(bpy.types.Operator):
    """Copy the command that installs mcsl, to be run in the folder of its source"""

    bl_idname = "mcsl.copy_install_command"
    bl_label = "Copy Command"
    bl_options: ClassVar = {"INTERNAL"}

    def execute(self, context):
        context.window_manager.clipboard = finding.INSTALL
        self.report({"INFO"}, told("copied: {command}").format(command=finding.INSTALL))
        return {"FINISHED"}


class MCSL_OT_open_preferences(bpy.types.Operator):
    """Show this extension's preferences, where the path of mcsl is set"""

    bl_idname = "mcsl.open_preferences"
    bl_label = "Set Up mcsl..."
    bl_options: ClassVar = {"INTERNAL"}

    def execute(self, context):
        bpy.ops.preferences.addon_show(module=ADDON)
        return {"FINISHED"}


class MCSL_Preferences(bpy.types.AddonPreferences):
    bl_idname = ADDON

    mcsl_path: bpy.props.StringProperty(
        name="mcsl",
        description="The mcsl program. Empty: found by itself on PATH and where pip, pipx and uv install",
        subtype="FILE_PATH",
    )

    def draw(self, context):
        row = self.layout.row(align=True)
        row.prop(self, "mcsl_path")
        row.operator("mcsl.test_mcsl", icon="PLAY")
        draw_state(self.layout)


def draw_state(layout) -> None:
    """What is known of mcsl: its version, or the one command that installs it."""
    try:
        path = finding.find(preferred()).path
    except McslError as error:
        column = layout.column(align=True)
        if error.what != finding.NEEDED:
            column.label(text=str(error), icon="ERROR", translate=False)
            return
        column.label(text="mcsl is not installed here", icon="ERROR")
        column.label(text="In the folder of its source run:")
        row = column.row(align=True)
        row.label(text=finding.INSTALL, icon="CONSOLE", translate=False)
        row.operator("mcsl.copy_install_command", icon="COPYDOWN")
        return
    layout.label(text=running.desk.mcsl or str(path), icon="CHECKMARK", translate=False)


def preferred() -> str:
    """The path in the preferences; '' where none is set, or the add-on runs without being installed."""
    addon = bpy.context.preferences.addons.get(ADDON)
    path = getattr(addon.preferences, "mcsl_path", "") if addon is not None and addon.preferences else ""
    return bpy.path.abspath(path) if path else ""


def mcsl() -> str:
    """The `mcsl` to run. McslError with what to do where there is none."""
    return str(Path(finding.find(preferred()).path))


CLASSES = (MCSL_OT_test_mcsl, MCSL_OT_copy_install_command, MCSL_OT_open_preferences, MCSL_Preferences)


def register() -> None:
    for kind in CLASSES:
        bpy.utils.register_class(kind)


def unregister() -> None:
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
