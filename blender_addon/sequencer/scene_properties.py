# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene knows about its timeline: the EDL it was built from, the schema, how many overrides there were.

The EDL's path is kept relative to the .blend (//) wherever there is a way, so that their folder can move.
"""

from __future__ import annotations

import json
import os
from functools import lru_cache
from pathlib import Path
from typing import Any

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core import edl as edls
from mcsl_core.edl import Edl
from mcsl_core.errors import InputError

from ..core.strip_plan import TIMELINE_SCHEMA


def timeline_scene(blend: Path) -> Any:
    """The scene of the open file that an EDL was built into, whatever it is called now."""
    scenes = [scene for scene in bpy.data.scenes if scene.get("mcsl_edl")]
    if len(scenes) != 1:
        count = "no scene" if not scenes else f"{len(scenes)} scenes ({', '.join(s.name for s in scenes)})"
        raise InputError(
            f"holds {count} with an mcsl timeline", where=str(blend), remedy="One is needed; see `mcsl timeline`"
        )
    _check_schema(scenes[0], blend)
    return scenes[0]


def _check_schema(scene: Any, blend: Path) -> None:
    if (found := scene.get("mcsl")) != TIMELINE_SCHEMA:
        raise InputError(
            f"has a timeline of schema {found!r}, this mcsl reads {TIMELINE_SCHEMA!r}",
            where=str(blend),
            remedy="Build it again with `mcsl timeline`, or install the mcsl that made it",
        )


def edl_path(scene: Any, blend: Path) -> Path:
    """The EDL the scene names, as an absolute path; InputError when it is not there."""
    name = scene["mcsl_edl"]
    path = Path(os.path.normpath(blend.parent / name.removeprefix("//")))
    if not path.is_file():
        raise InputError(
            f"names the EDL {name}, which is not there",
            where=str(blend),
            remedy="Keep the .blend and its EDL where they lay to each other",
        )
    return path


def set_ids(scene: Any, edl: Edl, path: Path, folder: Path | None) -> None:
    """Notes in the scene what it was built from. folder: the .blend's; None while it has no name yet."""
    scene["mcsl"] = TIMELINE_SCHEMA
    scene["mcsl_edl"] = relative(path, folder)
    scene["mcsl_overrides"] = len(edl.overrides)
    scene["mcsl_cameras"] = json.dumps([camera.name for camera in edl.cameras], ensure_ascii=False)


def camera_names(scene: Any) -> list[str]:
    """The EDL's cameras in its order, as the timeline was built from it: key n is the n-th."""
    if text := scene.get("mcsl_cameras"):
        return json.loads(text)
    return [camera.name for camera in edl_of(scene).cameras]  # a timeline older than the property


@lru_cache(maxsize=2)
def _loaded(path: Path, _changed_ns: int, _size: int) -> Edl:
    return edls.load(path)


def edl_of(scene: Any) -> Edl:
    """The scene's EDL as it lies on disk now, read again only when it changed. Raises as `edl_path` and `load`."""
    path = edl_path(scene, Path(bpy.data.filepath))
    state = path.stat()
    return _loaded(path, state.st_mtime_ns, state.st_size)


def relative(path: Path, folder: Path | None) -> str:
    """// and the way from ``folder``; the whole path where there is none (no folder yet, another drive)."""
    if folder is None:
        return path.as_posix()
    try:
        return "//" + Path(os.path.relpath(path, folder)).as_posix()
    except ValueError:
        return path.as_posix()


ROLE = "mcsl"
PLANNED = "mcsl_planned"  # of a camera strip: its transform without any correction
NAME = "mcsl_name"  # of a Programme strip: the name it was given here; another one is the editor's
TRACKS = "mcsl_tracks"  # of the scene: what the camera strips were made from
LOOK = "mcsl_look_"  # of the scene, with the aid's name after it: switched for the whole programme
KEYS = "mcsl_keys"  # of the scene: the Centering strip's keys as they were written
AIDS = ("centering", "fill", "colour")


def role_of(strip: Any) -> str:
    return strip.get(ROLE, "")
