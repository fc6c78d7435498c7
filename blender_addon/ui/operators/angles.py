# SPDX-License-Identifier: GPL-3.0-or-later
"""All cameras at once beside the programme: the preview is divided into one area a camera, and again made one.

An angle is a preview of a camera's channel. Nothing is remembered: a saved window knows its angles by that.
"""

from typing import ClassVar

import bpy  # pyright: ignore[reportMissingImports]

from ...core.angles import rows_of
from ...sequencer import scene_properties
from ...sequencer.compat import sequencer_scene
from ..angle_marks import camera_channels, names_of

EDGE_PX = 8  # between two areas
STEP_S = 0.02  # until an area that was made is drawn
PROGRAMME_PART = 0.6  # of the preview's width stays the programme's


def _previews(screen):
    return [a for a in screen.areas if a.type == "SEQUENCE_EDITOR" and a.spaces.active.view_type == "PREVIEW"]


class MCSL_OT_angles(bpy.types.Operator):
    """Show all cameras at once beside the programme, the chosen one framed; again: the programme alone"""

    bl_idname = "mcsl.angles"
    bl_label = "Angles"
    bl_options: ClassVar = {"REGISTER"}

    @classmethod
    def poll(cls, context):
        scene = sequencer_scene(context)
        if not scene_properties.has_timeline(scene):
            cls.poll_message_set("Build a timeline first")
            return False
        if bpy.app.background or context.window is None or not _previews(context.window.screen):
            cls.poll_message_set("Open a preview beside the sequencer")
            return False
        return True

    def execute(self, context):
        scene, window = sequencer_scene(context), context.window
        channels = camera_channels(scene)
        previews = _previews(window.screen)
        angles = [area for area in previews if area.spaces.active.display_channel in channels]
        if angles and len(angles) < len(previews):
            steps = _join(window, channels)
            bpy.app.timers.register(lambda: next(steps, None), first_interval=0.0)
            return {"FINISHED"}
        programme = max(previews, key=lambda area: area.width * area.height)
        programme.spaces.active.display_channel = 0
        steps = _build(context.window, programme, _in_order(scene, channels))
        bpy.app.timers.register(lambda: next(steps, None), first_interval=0.0)
        return {"FINISHED"}


def _build(window, programme, channels):
    """Divides the preview, a cut a step: an area that was made can be cut, and says where it lies, once it is drawn."""
    _, side = yield from _split(window, programme, "VERTICAL", PROGRAMME_PART)
    rows = rows_of(side.width, side.height, len(channels))
    wanted = iter(channels)
    lines = yield from _divide(window, side, "HORIZONTAL", len(rows))
    for line, count in zip(lines, rows, strict=True):
        for area in (yield from _divide(window, line, "VERTICAL", count)):
            _show(area.spaces.active, next(wanted))


def _join(window, channels):
    """Makes the preview one again, a join a step: angles with angles, and what they have become with the programme."""
    while True:
        previews = _previews(window.screen)
        angles = [area for area in previews if area.spaces.active.display_channel in channels]
        others = [area for area in previews if area not in angles]
        pair = next(((a, b) for some in (angles, others) for a in some for b in angles if _side_by_side(a, b)), None)
        if pair is None:
            return
        keep, gone = ((area.x + area.width // 2, area.y + area.height // 2) for area in pair)
        with bpy.context.temp_override(window=window):
            bpy.ops.screen.area_join(source_xy=keep, target_xy=gone)
        yield STEP_S


def _side_by_side(one, other) -> bool:
    """Whether two areas share a whole edge, so that they can be made one."""
    places = [(a.x, a.x + a.width, a.y, a.y + a.height) for a in (one, other)]
    (l1, r1, b1, t1), (l2, r2, b2, t2) = places

    def near(x, y):
        return abs(x - y) <= EDGE_PX

    beside = near(b1, b2) and near(t1, t2) and (near(r1, l2) or near(r2, l1))
    above = near(l1, l2) and near(r1, r2) and (near(t1, b2) or near(t2, b1))
    return one != other and (beside or above)


def _show(space, channel: int) -> None:
    """An angle: the pictures of one channel and nothing else."""
    space.display_channel = channel
    space.show_region_header = space.show_region_ui = space.show_region_toolbar = False
    space.show_region_tool_header = space.show_gizmo = False


def _divide(window, area, direction: str, count: int):
    """An area in ``count`` equal parts, from the left or from above."""
    parts = []
    for left in range(count, 1, -1):
        part, area = yield from _split(window, area, direction, 1 / left)
        parts.append(part)
    return [*parts, area]


def _split(window, area, direction: str, part: float):
    """The left or upper ``part`` of an area, and the rest."""
    before = {a.as_pointer() for a in window.screen.areas}
    factor = part if direction == "VERTICAL" else 1 - part  # from the left, from below
    with bpy.context.temp_override(window=window, area=area, region=area.regions[-1]):
        bpy.ops.screen.area_split(direction=direction, factor=factor)
    yield STEP_S
    new = [a for a in window.screen.areas if a.as_pointer() not in before]
    return sorted((area, *new), key=lambda a: a.x if direction == "VERTICAL" else -a.y)


def _in_order(scene, channels) -> list[int]:
    """The channels in the order of the cameras' keys."""
    names = names_of(scene)
    return sorted(channels, key=lambda c: (names.index(channels[c]) if channels[c] in names else len(names), c))


CLASSES = (MCSL_OT_angles,)
