# SPDX-License-Identifier: GPL-3.0-or-later
"""Over a preview of a camera's channel: its key and name, and a frame where it is the programme's."""

from __future__ import annotations

from typing import Any

import blf  # pyright: ignore[reportMissingImports]
import bpy  # pyright: ignore[reportMissingImports]
import gpu  # pyright: ignore[reportMissingImports]
from gpu_extras.batch import batch_for_shader  # pyright: ignore[reportMissingImports]

from mcsl_core.errors import McslError

from ..core import shot_list
from ..sequencer import scene_properties
from ..sequencer.compat import sequencer_scene
from . import refresh

CHOSEN, OTHER = (0.95, 0.55, 0.1, 1.0), (0.9, 0.9, 0.9, 1.0)
FRAME_PX, LETTERS_PX = 4, 14  # at a scale of 1
_drawn: list[Any] = []


def camera_channels(scene: Any) -> dict[int, str]:
    """The channels that hold cameras' strips, with the cameras' names, as the timeline was last read."""
    return {camera.channel: camera.camera for camera in sorted(refresh.cameras(scene), key=lambda c: c.channel)}


def names_of(scene: Any) -> list[str]:
    """The cameras in the order of their keys; none where that cannot be read."""
    try:
        return scene_properties.camera_names(scene)
    except McslError:
        return []


def _draw() -> None:
    context = bpy.context
    scene, region = sequencer_scene(context), context.region
    channel = context.space_data.display_channel
    if not channel or not scene_properties.has_timeline(scene) or (name := camera_channels(scene).get(channel)) is None:
        return
    rows, scale = refresh.listed(), context.preferences.system.ui_scale
    index = shot_list.row_at(rows, scene.frame_current - 1)
    chosen = index >= 0 and rows[index].camera == name
    colour, names = CHOSEN if chosen else OTHER, names_of(scene)
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


def _frame(width: int, height: int, thick: int, colour: tuple[float, ...]) -> None:
    sides = [(0, 0, width, thick), (0, height - thick, width, height), (0, 0, thick, height)]
    _boxes([*sides, (width - thick, 0, width, height)], colour)


def _boxes(boxes: list[tuple[float, ...]], colour: tuple[float, ...]) -> None:
    """Filled rectangles (left, bottom, right, top) in pixels of the region."""
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    places = [p for a, b, c, d in boxes for p in ((a, b), (c, b), (c, d), (a, b), (c, d), (a, d))]
    batch = batch_for_shader(shader, "TRIS", {"pos": places})
    gpu.state.blend_set("ALPHA")
    shader.bind()
    shader.uniform_float("color", colour)
    batch.draw(shader)
    gpu.state.blend_set("NONE")


def register() -> None:
    if not bpy.app.background:
        _drawn.append(bpy.types.SpaceSequenceEditor.draw_handler_add(_draw, (), "PREVIEW", "POST_PIXEL"))


def unregister() -> None:
    while _drawn:
        bpy.types.SpaceSequenceEditor.draw_handler_remove(_drawn.pop(), "PREVIEW")
