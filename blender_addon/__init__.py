# SPDX-License-Identifier: GPL-3.0-or-later
"""mcsl in Blender's sequencer: the timeline of an EDL, and the editor's decisions back into it.

`plan`, `similarity` and `readback` hold the decisions and import no bpy; `strips` is the only user of the strip API;
`background` and `tasks` run in a child process. Of mcsl_core only timing, errors, progress, documents and edl are used.
"""


def register() -> None:
    """Called by Blender when the extension is switched on. bpy is imported here, so that tests can do without."""
    from . import by_hand, operators, panels

    operators.register()
    by_hand.register()
    panels.register()


def unregister() -> None:
    """Called by Blender when it is switched off: in reverse."""
    from . import by_hand, operators, panels

    panels.unregister()
    by_hand.unregister()
    operators.unregister()
