# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person sees first of a recording: the sidebar on its tab mcsl, and all of the timeline.

A sidebar that was shut has no tabs before it is drawn, so a timer does it. Without a window nothing is to be seen.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy  # pyright: ignore[reportMissingImports]

TAB = "mcsl"
TRY_S, TRIES = 0.1, 20


def open_tab() -> None:
    """The sidebar beside the strips is open on our tab."""
    _later(frame=False)


def show_timeline() -> None:
    """As `open_tab`, and the timeline is framed."""
    _later(frame=True)


def _later(*, frame: bool) -> None:
    if bpy.app.background:
        return
    steps = _steps(frame)
    bpy.app.timers.register(lambda: next(steps, None), first_interval=TRY_S)


def _steps(frame: bool) -> Iterator[float]:
    for _, area in _sequencers():
        area.spaces.active.show_region_ui = True
    for _ in range(TRIES):
        yield TRY_S
        if all([_on_tab(area) for _, area in _sequencers()]):
            break
    for window, area in _sequencers() if frame else ():
        region = next(r for r in area.regions if r.type == "WINDOW")
        with bpy.context.temp_override(window=window, area=area, region=region):
            bpy.ops.sequencer.view_all()


def _on_tab(area: Any) -> bool:
    """Turns the sidebar to our tab; whether that was possible yet."""
    region = next(r for r in area.regions if r.type == "UI")
    try:
        region.active_panel_category = TAB
    except (TypeError, AttributeError):  # not drawn yet; before 4.2 nobody may set it
        return False
    area.tag_redraw()
    return True


def _sequencers() -> list[tuple[Any, Any]]:
    """The areas that show strips, with their windows."""
    return [
        (window, area)
        for window in bpy.context.window_manager.windows
        for area in window.screen.areas
        if area.type == "SEQUENCE_EDITOR" and area.spaces.active.view_type != "PREVIEW"
    ]
