# SPDX-License-Identifier: GPL-3.0-or-later
"""When timelines are brought in line: once they have been quiet after a change, before saving, after loading.

A change marks the timeline; a timer refreshes it once it has been quiet for `QUIET_S`, so that dragging a cut stays
smooth (2,000 shots take some tenths of a second). Before saving it is refreshed in any case, so that a file never says
one thing and shows another, wherever it is rendered; after loading as well. Without a window the log takes the warning.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.errors import McslError

from ..core import identity, shot_list
from ..sequencer import conformed, scene_properties
from . import first_view, refresh, render_guard
from .translations.lookup import told

QUIET_S = 0.4

_before_saving: dict[str, dict[str, Any]] = {}  # scene -> its way to the EDL, where saving elsewhere changes it


def mark() -> None:
    """The timeline may have changed: refresh it when it is quiet."""
    if bpy.app.timers.is_registered(_quiet):
        bpy.app.timers.unregister(_quiet)
    bpy.app.timers.register(_quiet, first_interval=QUIET_S)


def _quiet() -> None:
    refresh.refresh_changed()


@bpy.app.handlers.persistent
def _changed(_scene: Any, depsgraph: Any = None) -> None:
    if refresh.busy() or bpy.app.background or (depsgraph is not None and not depsgraph.id_type_updated("SCENE")):
        return
    mark()


@bpy.app.handlers.persistent
def _saving(target: Any = "", *_: Any) -> None:
    render_guard.before_saving()
    new = target if isinstance(target, str) and target else bpy.data.filepath
    for scene in refresh.timelines():
        refresh.refresh_timeline(scene)
        if new:
            old = Path(bpy.data.filepath).parent if bpy.data.filepath else None
            _note_saving(scene, old, Path(new).parent)


def _note_saving(scene: Any, old: Path | None, new: Path) -> None:
    """The way to the EDL goes along with the file; so does the panel's, which is the same unless another was named."""
    noted = {name: scene.get(name) for name in (scene_properties.EDL_PATH, scene_properties.HOME)}
    try:
        scene_properties.note_saving(scene, old, new)
    except McslError:
        return  # it is not found where it is now either
    _follow_panel(scene, noted[scene_properties.EDL_PATH])
    if old is not None and scene.get(scene_properties.EDL_PATH) != noted[scene_properties.EDL_PATH]:
        _before_saving[scene.name] = noted


def _follow_panel(scene: Any, was: Any) -> None:
    if scene.mcsl_work.edl == was:
        scene.mcsl_work.edl = scene[scene_properties.EDL_PATH]


@bpy.app.handlers.persistent
def _saved(*_: Any) -> None:
    """Where a copy was saved, or nothing could be, the open file stays where it is: so does its way to the EDL."""
    folder = Path(bpy.data.filepath).parent
    for name, noted in _before_saving.items():
        scene = bpy.data.scenes.get(name)
        if scene is not None and scene.get(scene_properties.HOME) != identity.home_of(folder):
            was = scene.get(scene_properties.EDL_PATH)
            for key, value in noted.items():
                scene[key] = value
            _follow_panel(scene, was)
    _before_saving.clear()


@bpy.app.handlers.persistent
def _loaded(*_: Any) -> None:
    refresh.forget()
    state = bpy.context.window_manager.mcsl_state
    if refresh.timelines():
        first_view.open_tab()
    for scene in refresh.timelines():
        refresh.show_recording(scene)
        problem = refresh.refresh_timeline(scene)
        if not bpy.app.background:
            continue
        if problem:
            print(f"mcsl: warning: {Path(bpy.data.filepath).name}: {problem}", flush=True)
        elif conformed.conformed_strips(scene) and state.outstanding_s > 0:
            text = told("{seconds} of the programme show the preview, not the exact pictures. Conform before rendering")
            print(f"mcsl: warning: {text.format(seconds=shot_list.seconds_text(state.outstanding_s))}", flush=True)


HANDLERS = {
    "depsgraph_update_post": _changed,
    "undo_post": _changed,
    "redo_post": _changed,
    "save_pre": _saving,
    "save_post": _saved,
    "save_post_fail": _saved,
    "load_post": _loaded,
}


def register() -> None:
    for name, handler in HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)
    if not bpy.app.background:
        mark()


def unregister() -> None:
    if bpy.app.timers.is_registered(_quiet):
        bpy.app.timers.unregister(_quiet)
    for name, handler in HANDLERS.items():
        getattr(bpy.app.handlers, name).remove(handler)
