# SPDX-License-Identifier: GPL-3.0-or-later
"""mcsl in Blender's sequencer: the timeline of an EDL, and the editor's decisions back into it.

What is decided stands in plain modules that import no bpy (`plan`, `readback`, `nudges`, `switching`, `outstanding`,
`shots`, ...); `strips` and `conformed` touch the sequencer; `operators` and `panels` are a thin skin. `jobs` runs mcsl
as a child process; `background` and `tasks` run in the one that mcsl starts. Of mcsl_core only floor 0 is used.
"""

_MODULES = ("translations", "preferences", "properties", "running", "operators", "by_hand", "panels", "watching")


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
