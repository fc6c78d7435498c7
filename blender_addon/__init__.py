# SPDX-License-Identifier: GPL-3.0-or-later
"""mcsl in Blender's sequencer: the timeline of an EDL, and the editor's decisions back into it.

What is decided stands in `core`, plain Python without bpy. `sequencer` touches the strips, `ui` is a thin skin.
`process` runs mcsl as a child process; `worker` runs in the child that mcsl starts. Of mcsl_core only documents,
timing, progress and the EDL are used.
"""

_MODULES = (
    "ui.translations.lookup",
    "ui.preferences",
    "ui.properties",
    "ui.job_runner",
    "ui.operators",
    "ui.operators.multicam",
    "ui.panels",
    "ui.handlers",
    "ui.angle_marks",
    "ui.override_marks",
    "ui.render_guard",
)


def _modules() -> list:
    """bpy is imported here, not above, so that tests can do without."""
    from importlib import import_module

    return [import_module(f".{name}", __package__) for name in _MODULES]


def register() -> None:
    """Called by Blender when the extension is switched on."""
    for module in _modules():
        module.register()


def unregister() -> None:
    """Called by Blender when it is switched off: in reverse."""
    for module in reversed(_modules()):
        module.unregister()
