# SPDX-License-Identifier: GPL-3.0-or-later
"""What operators on a timeline share: when they can be pressed, and how a refusal is told."""

from collections.abc import Callable

from mcsl_core.errors import McslError

from ...sequencer.compat import sequencer_scene
from ...sequencer.scene_properties import has_timeline


class OnTimeline:
    """An operator on the timeline that the sequencer shows. What it does is ``change(context, scene)``.

    That returns what `execute` does; a McslError out of it is reported, and the operator cancelled.
    """

    change: Callable[..., set[str]]
    report: Callable[[set[str], str], None]  # Blender's own

    @classmethod
    def poll(cls, context):
        return has_timeline(sequencer_scene(context))

    def execute(self, context):
        try:
            return self.change(context, sequencer_scene(context))
        except McslError as error:
            return self.leave(str(error), "ERROR")

    def leave(self, text, level="INFO"):
        """Nothing is done, and this is why."""
        self.report({level}, text)
        return {"CANCELLED"}
