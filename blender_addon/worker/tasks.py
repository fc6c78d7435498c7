# SPDX-License-Identifier: GPL-3.0-or-later
"""What the child process can do: make a timeline, read one, bring one up to date, render one.

Each task takes the request and a progress, and returns the result as plain JSON. Paths in requests are absolute; in
the .blend they are relative to it, so that the folder can move. A .blend is saved under a hidden name beside its own
and renamed: the old one or the whole new one, never a part.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core import edl as edls
from mcsl_core.errors import BlenderError, InputError
from mcsl_core.progress import JsonLines
from mcsl_core.timing import FrameRange

from ..core.read_overrides import read_edl
from ..core.strip_plan import ConformedPiece, StripPlan, make_plan
from ..sequencer import conformed, output
from ..sequencer import scene_properties as scenes
from ..sequencer.build import build_timeline, has_sound, rebuild_timeline
from ..sequencer.compat import use_sequencer_scene
from ..sequencer.read import read_timeline

Request = Mapping[str, Any]


def timeline(request: Request, progress: JsonLines) -> dict[str, Any]:
    """request: edl, blend, conformed [{range, path}], sound or null, preset, output."""
    edl_path, blend = Path(request["edl"]), Path(request["blend"])
    edl = edls.load(edl_path)
    plan = _plan(edl, request)
    progress.stage("timeline", None)
    bpy.ops.wm.read_homefile(app_template="Video_Editing", use_factory_startup=True)
    scene = bpy.context.scene
    scene.name = "Programme"
    use_sequencer_scene(scene)
    notes = build_timeline(scene, plan, edl_path.parent)
    conformed.note_basis(scene, edl)
    _finish(scene, edl, edl_path, blend, request)
    for note in notes:
        progress.note(note)
    return {"blend": str(blend), "strips": len(plan.programme), "frames": plan.frames}


def read(request: Request, progress: JsonLines) -> dict[str, Any]:
    """request: blend. Result: the EDL it names, and that EDL's overrides, corrections and look after the editor's work.

    The .blend stays as it is, but for conformed pictures that no longer show what was decided: they fall away.
    """
    blend = Path(request["blend"])
    scene = _open(blend)
    edl_path = scenes.edl_path(scene, blend)
    edl = edls.load(edl_path)
    state = read_timeline(scene)
    new = read_edl(edl, state)
    for note in state.notes:
        progress.note(note)
    value = edls.to_json(new)
    decided = {
        name: value.get(name, []) for name in ("overrides", "corrections")
    }  # the document leaves out an empty one
    decided["look"] = value["look"]
    if conformed.any_there(scene) and conformed.keep_true(scene, new).changed:
        try:
            _save(blend)
            progress.note(
                "conformed pictures that no longer show what was decided fell away: `mcsl conform` makes others"
            )
        except InputError as error:  # what was decided can be read all the same
            progress.note(f"conformed pictures no longer show what was decided, and {error}")
    return {"edl": str(edl_path), **decided, "changed": new != edl}


def refresh(request: Request, progress: JsonLines) -> dict[str, Any]:
    """request: as of `timeline`. Programme, Centering, Conformed and sound of an existing .blend from its EDL."""
    edl_path, blend = Path(request["edl"]), Path(request["blend"])
    edl = edls.load(edl_path)
    progress.stage("timeline", None)
    scene = _open(blend)
    use_sequencer_scene(scene)
    plan = _plan(edl, request)
    for note in rebuild_timeline(scene, plan, edl_path.parent):
        progress.note(note)
    conformed.note_basis(scene, edl)
    _finish(scene, edl, edl_path, blend, request)
    return {"blend": str(blend), "strips": len(plan.programme), "frames": plan.frames}


def render(request: Request, progress: JsonLines) -> dict[str, Any]:
    """request: blend, preset or null (the .blend's own), output. Renders to ``output`` as it stands."""
    blend, target = Path(request["blend"]), Path(request["output"])
    scene = _open(blend)
    if request.get("preset"):
        output.apply(scene, request["preset"], str(target), sound=has_sound(scene))
    scene.render.filepath = str(target)
    total = len(range(scene.frame_start, scene.frame_end + 1, scene.frame_step))
    progress.stage("render", total, "frames")
    done = 0

    def written(*_: Any) -> None:
        nonlocal done
        done += 1
        progress.advance(done)

    bpy.app.handlers.render_post.append(written)
    bpy.ops.render.render(animation=True, scene=scene.name)
    if done != total or not target.is_file():
        raise BlenderError(f"wrote {done} of {total} frames", where=str(target), remedy="See the end of its log above")
    return {"output": str(target), "frames": done}


TASKS: dict[str, Callable[[Request, JsonLines], dict[str, Any]]] = {
    "timeline": timeline,
    "read": read,
    "refresh": refresh,
    "render": render,
}


def _plan(edl: edls.Edl, request: Request) -> StripPlan:
    pieces = [ConformedPiece(FrameRange(*piece["range"]), piece["path"]) for piece in request["conformed"]]
    return make_plan(edl, pieces, request["sound"])


def _open(blend: Path) -> Any:
    """The scene of a .blend that an EDL was built into, whatever it is called now."""
    if not blend.is_file():
        raise InputError("is missing", where=str(blend), remedy="Build it with `mcsl timeline`")
    try:
        bpy.ops.wm.open_mainfile(filepath=str(blend), load_ui=True, use_scripts=False)
    except RuntimeError as error:
        raise InputError(
            f"Blender cannot open it ({str(error).strip()})", where=str(blend), remedy="Restore it or build it again"
        ) from error
    return scenes.timeline_scene(blend)


def _finish(scene: Any, edl: edls.Edl, edl_path: Path, blend: Path, request: Request) -> None:
    """Output settings, ids, relative paths, and the save."""
    if request.get("preset"):
        output.apply(scene, request["preset"], "//" + request["output"], sound=has_sound(scene))
    scenes.set_ids(scene, edl, edl_path, blend.parent)
    _save(blend)


def _save(blend: Path) -> None:
    """The open file, whole or not at all, with relative paths."""
    part = blend.with_name(f".{blend.name}.part.blend")
    try:
        bpy.context.preferences.filepaths.save_version = 0
        bpy.ops.wm.save_as_mainfile(filepath=str(part), check_existing=False, relative_remap=True)
        bpy.ops.file.make_paths_relative()
        bpy.ops.wm.save_as_mainfile(filepath=str(part), check_existing=False, relative_remap=True)
        part.replace(blend)
    except (RuntimeError, OSError) as error:
        raise InputError(
            f"cannot be written ({str(error).strip()})", where=str(blend), remedy="Choose a folder you may write to"
        ) from error
    finally:
        part.unlink(missing_ok=True)
