# SPDX-License-Identifier: GPL-3.0-or-later
"""All cameras at once beside the programme: the preview is divided into one area a camera, and again made one.

An angle is a preview of a camera's channel. Nothing is remembered: a saved window knows its angles by that.
"""

from typing import ClassVar

import blf  # pyright: ignore[reportMissingImports]
import bpy  # pyright: ignore[reportMissingImports]
import gpu  # pyright: ignore[reportMissingImports]
from gpu_extras.batch import batch_for_shader  # pyright: ignore[reportMissingImports]

from mcsl_core.errors import McslError

from ...core.angles import rows_of
from ...sequencer import scene_properties
from ...sequencer.compat import sequencer_scene
from .. import refresh

EDGE_PX = 8  # between two areas
STEP_S = 0.02  # until an area that was made is drawn
PROGRAMME_PART = 0.6  # of the preview's width stays the programme's
CHOSEN, OTHER = (0.95, 0.55, 0.1, 1.0), (0.9, 0.9, 0.9, 1.0)
FRAME_PX, LETTERS_PX = 4, 14  # at a scale of 1
_drawn = []


def camera_channels(scene) -> dict[int, str]:
    """The channels that hold cameras' strips, with the cameras' names."""
    strips = scene.sequence_editor.strips
    found = {s.channel: s.get(scene_properties.CAMERA) for s in strips if scene_properties.role_of(s) == "camera"}
    return {channel: name for channel, name in sorted(found.items()) if isinstance(name, str)}


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
    names = _names(scene)
    return sorted(channels, key=lambda c: (names.index(channels[c]) if channels[c] in names else len(names), c))


def _names(scene) -> list[str]:
    try:
        return scene_properties.camera_names(scene)
    except McslError:
        return []


def _draw() -> None:
    """Over an angle: the camera's key and name, and a frame where it is the programme's."""
    context = bpy.context
    scene, region = sequencer_scene(context), context.region
    channel = context.space_data.display_channel
    if not channel or not scene_properties.has_timeline(scene) or (name := camera_channels(scene).get(channel)) is None:
        return
    at, scale = scene.frame_current - 1, context.preferences.system.ui_scale
    chosen = any(name == row.camera for row in refresh.listed() if at in row.range)
    colour, names = CHOSEN if chosen else OTHER, _names(scene)
    if chosen:
        _frame(region.width, region.height, round(FRAME_PX * scale), colour)
    text = f"{names.index(name) + 1}  {name}" if name in names else name
    left, bottom, pad = 12 * scale, 12 * scale, 6 * scale
    blf.size(0, LETTERS_PX * scale)
    width, height = blf.dimensions(0, text)
    _boxes([(left - pad, bottom - pad, left + width + pad, bottom + height + pad)], (0.0, 0.0, 0.0, 0.65))
    blf.color(0, *colour)
    blf.position(0, left, bottom, 0)
    blf.draw(0, text)


def _frame(width: int, height: int, thick: int, colour) -> None:
    sides = ((0, 0, width, thick), (0, height - thick, width, height), (0, 0, thick, height))
    _boxes([*sides, (width - thick, 0, width, height)], colour)


def _boxes(boxes, colour) -> None:
    """Filled rectangles (left, bottom, right, top) in pixels of the region."""
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    places = [p for a, b, c, d in boxes for p in ((a, b), (c, b), (c, d), (a, b), (c, d), (a, d))]
    batch = batch_for_shader(shader, "TRIS", {"pos": places})
    gpu.state.blend_set("ALPHA")
    shader.bind()
    shader.uniform_float("color", colour)
    batch.draw(shader)
    gpu.state.blend_set("NONE")


CLASSES = (MCSL_OT_angles,)


def register() -> None:
    """Angles are marked wherever a preview shows a camera's channel; without a window nothing is drawn."""
    if not bpy.app.background:
        _drawn.append(bpy.types.SpaceSequenceEditor.draw_handler_add(_draw, (), "PREVIEW", "POST_PIXEL"))


def unregister() -> None:
    while _drawn:
        bpy.types.SpaceSequenceEditor.draw_handler_remove(_drawn.pop(), "PREVIEW")
