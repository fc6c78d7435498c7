# SPDX-License-Identifier: GPL-3.0-or-later
"""A bright line below everything in the Programme that an editor decided, however far the timeline is zoomed out."""

from __future__ import annotations

import bpy  # pyright: ignore[reportMissingImports]

from ..core.overview import marks
from ..core.strip_plan import FIRST_CAMERA_CHANNEL
from ..sequencer.compat import sequencer_scene
from ..sequencer.scene_properties import camera_names, has_timeline
from . import refresh

COLOUR = (1.0, 0.85, 0.1, 1.0)
HEIGHT_PX = 5

_drawn = []  # the handler while we are registered


def _draw() -> None:
    context = bpy.context
    scene, space, region = sequencer_scene(context), context.space_data, context.region
    if not has_timeline(scene) or scene != refresh.shown_scene() or not space.show_overlays:
        return
    channel = FIRST_CAMERA_CHANNEL + len(camera_names(scene))
    left, bottom = region.view2d.view_to_region(1, channel + 0.1, clip=False)  # Blender's frame 1 is our 0
    far, _ = region.view2d.view_to_region(100_001, channel, clip=False)
    pieces = [row.range for row in refresh.listed() if row.overridden]
    spans = marks(pieces, left, (far - left) / 100_000, region.width)
    if spans:
        _lines(spans, bottom)


def _lines(spans: list[tuple[float, float]], bottom: float) -> None:
    import gpu  # pyright: ignore[reportMissingImports] - there is none without a window
    from gpu_extras.batch import batch_for_shader  # pyright: ignore[reportMissingImports]

    corners, triangles = [], []
    for begin, end in spans:
        n = len(corners)
        top = bottom + HEIGHT_PX
        corners += [(begin, top), (end, top), (end, bottom), (begin, bottom)]
        triangles += [(n, n + 1, n + 2), (n, n + 2, n + 3)]
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    shader.bind()
    shader.uniform_float("color", COLOUR)
    batch_for_shader(shader, "TRIS", {"pos": corners}, indices=triangles).draw(shader)


def register() -> None:
    if not bpy.app.background:
        _drawn.append(bpy.types.SpaceSequenceEditor.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    while _drawn:
        bpy.types.SpaceSequenceEditor.draw_handler_remove(_drawn.pop(), "WINDOW")
