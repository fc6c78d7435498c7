# SPDX-License-Identifier: GPL-3.0-or-later
"""A video that the panel renders bears its name only once it is whole: a stopped one would play too, and deceive.

Blender writes it beside its place under a hidden name; complete, it takes the place of what was there.
"""

from __future__ import annotations

import atexit
import shutil
import tempfile
from pathlib import Path
from typing import Any

import bpy  # pyright: ignore[reportMissingImports]
from attrs import define

from mcsl_core.edl import Edl
from mcsl_core.edl.removal import delivered

from ..sequencer.delivered import delivered_scene, drop_delivered
from ..sequencer.sound import has_sound
from . import job_runner
from .translations.lookup import told


@define
class Pending:
    """A render that runs: which scene, to what file, how many frames it has and how many are done."""

    scene: str
    target: Path
    part: Path
    frames: int
    done: int = 0


_SOON_S = 0.5
_pending: Pending | None = None
_folders: list[Path] = []  # of sound that was made to be rendered


def busy() -> bool:
    """Whether a render runs."""
    return _pending is not None or bpy.app.is_job_running("RENDER")


def begin(scene: Any, edl: Edl, target: Path) -> Any:
    """What is delivered of the scene is about to be rendered to ``target``; returns the scene that is to be rendered.

    Until the video is whole it is written under another name.
    """
    global _pending
    tidy()
    if edl.removed:
        _folders.append(Path(tempfile.mkdtemp(prefix="mcsl-render-")))
        scene = delivered_scene(scene, delivered(edl), _folders[-1], sound=has_sound(scene))
    part = target.with_name(f".{target.stem}.part{target.suffix}")
    part.unlink(missing_ok=True)
    frames = len(range(scene.frame_start, scene.frame_end + 1, scene.frame_step))
    _pending = Pending(scene.name, target, part, frames)
    scene.render.filepath = str(part)
    return scene


def drop() -> None:
    """The render was stopped, or failed: what it wrote goes, what was there before stays."""
    if (pending := _take()) is not None:
        pending.part.unlink(missing_ok=True)
        text = told("rendering stopped: nothing was written to {path}")
        job_runner.say(text.format(path=pending.target), "WARNING")


def before_saving() -> None:
    """A file that is saved meanwhile names the video, not its part: the render has its own name already."""
    if _pending is not None and (scene := bpy.data.scenes.get(_pending.scene)) is not None:
        scene.render.filepath = str(_pending.target)


def _take() -> Pending | None:
    global _pending
    pending, _pending = _pending, None
    if pending is not None and (scene := bpy.data.scenes.get(pending.scene)) is not None:
        scene.render.filepath = str(pending.target)
    bpy.app.timers.register(tidy, first_interval=_SOON_S)
    return pending


def tidy() -> float | None:
    """What was made to be rendered goes, once Blender has done with it; returns in how many seconds to look again."""
    if busy():
        return _SOON_S
    drop_delivered()
    _drop_folders()
    return None


@atexit.register
def _drop_folders() -> None:
    """The sound of an operation is left nowhere, also where Blender is quit."""
    while _folders:
        shutil.rmtree(_folders.pop(), ignore_errors=True)


@bpy.app.handlers.persistent
def _frame(*_: Any) -> None:
    if _pending is not None:
        _pending.done += 1


@bpy.app.handlers.persistent
def _complete(*_: Any) -> None:
    if _pending is None:
        return
    if _pending.done < _pending.frames or not _pending.part.is_file():
        drop()
        return
    pending = _take()
    assert pending is not None
    try:
        pending.part.replace(pending.target)
    except OSError as error:
        text = told("the video cannot take its name ({reason}); it lies at {path}")
        job_runner.say(text.format(reason=error.strerror or error, path=pending.part), "ERROR")


@bpy.app.handlers.persistent
def _cancelled(*_: Any) -> None:
    drop()


@bpy.app.handlers.persistent
def _loaded(*_: Any) -> None:
    drop_delivered()


HANDLERS = {"render_write": _frame, "render_complete": _complete, "render_cancel": _cancelled, "load_post": _loaded}


def register() -> None:
    for name, handler in HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    for name, handler in HANDLERS.items():
        getattr(bpy.app.handlers, name).remove(handler)
