# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene and its strips know about their timeline, as Blender's custom properties, and the EDL behind it.

The names stand here alone; saved .blend files hold them. The EDL's path is kept relative to the .blend (//) wherever
there is a way, so that their folder can move.
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

TIMELINE_SCHEMA = "mcsl.timeline/1"

MARK = "mcsl"  # of the scene: the timeline's schema; of a strip: its role, and what has none is the editor's

# Of the scene.
EDL_PATH = "mcsl_edl"  # the EDL it was built from; a scene that has it holds a timeline
OVERRIDE_COUNT = "mcsl_overrides"  # how many overrides the EDL had when it was last read or written
CAMERA_NAMES = "mcsl_cameras"  # the EDL's cameras in its order, as JSON: key n is the n-th
TRACKS_HASH = "mcsl_tracks"  # what the camera strips were made from
CENTERING_KEYS_HASH = "mcsl_keys"  # the Centering strip's keys as they were written: others are the editor's
CENTERING_PLAN_HASH = "mcsl_centered"  # the plan that those keys were written from
CONFORMED_BASIS = "mcsl_conformed_for"  # what its conformed pictures were made from, by time
LOOK_FOR_ALL = {  # a part of the look that was switched for the whole programme
    "centering": "mcsl_look_centering",
    "fill": "mcsl_look_fill",
    "colour": "mcsl_look_colour",
}

# Of a strip.
CAMERA = "mcsl_camera"  # camera strip: whose file it plays
PLANNED_TRANSFORM = "mcsl_planned"  # camera strip: its transform without any correction
SHOT_ID = "mcsl_id"  # Programme strip
GIVEN_NAME = "mcsl_name"  # Programme strip: the name it was given here; another one is the editor's
LOOK_OF_SHOT = {  # Programme strip: a part of the look that was switched for this shot
    "centering": "mcsl_centering",
    "fill": "mcsl_fill",
    "colour": "mcsl_colour",
}
CENTRE = "mcsl_offset"  # Programme strip: the centre by hand, [dx, dy] in programme pixels, or "automatic"
FALLEN = "mcsl_fallen"  # conformed strip: muted because its pictures no longer hold

# Of the scene: the analysis' choice by time, as text. Of a Programme strip: its choice where the strip begins.
AUTOMATIC_CAMERA = "mcsl_automatic"


def role_of(strip: Any) -> str:
    """What a strip is to the timeline: camera, programme, centering, conformed, sound, or '' for the editor's own."""
    return strip.get(MARK, "")


def has_timeline(scene: Any) -> bool:
    """Whether an EDL was built into the scene; a window may show no scene at all."""
    return scene is not None and bool(scene.get(EDL_PATH)) and scene.sequence_editor is not None


def timeline_scene(blend: Path) -> Any:
    """The scene of the open file that an EDL was built into, whatever it is called now."""
    scenes = [scene for scene in bpy.data.scenes if scene.get(EDL_PATH)]
    if len(scenes) != 1:
        count = "no scene" if not scenes else f"{len(scenes)} scenes ({', '.join(s.name for s in scenes)})"
        raise InputError(
            f"holds {count} with an mcsl timeline", where=str(blend), remedy="One is needed; see `mcsl timeline`"
        )
    _check_schema(scenes[0], blend)
    return scenes[0]


def _check_schema(scene: Any, blend: Path) -> None:
    if (found := scene.get(MARK)) != TIMELINE_SCHEMA:
        raise InputError(
            f"has a timeline of schema {found!r}, this mcsl reads {TIMELINE_SCHEMA!r}",
            where=str(blend),
            remedy="Build it again with `mcsl timeline`, or install the mcsl that made it",
        )


def edl_path(scene: Any, blend: Path) -> Path:
    """The EDL the scene names, as an absolute path; InputError when it is not there."""
    name = scene[EDL_PATH]
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
    scene[MARK] = TIMELINE_SCHEMA
    scene[EDL_PATH] = relative(path, folder)
    scene[OVERRIDE_COUNT] = len(edl.overrides)
    scene[CAMERA_NAMES] = json.dumps([camera.name for camera in edl.cameras], ensure_ascii=False)


def camera_names(scene: Any) -> list[str]:
    """The EDL's cameras in its order, as the timeline was built from it: key n is the n-th."""
    if text := scene.get(CAMERA_NAMES):
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
