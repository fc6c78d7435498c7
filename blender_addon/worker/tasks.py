# SPDX-License-Identifier: GPL-3.0-or-later
"""What the child process can do: make a timeline, read one, bring one up to date, render one.

Each task takes its request and a progress, and returns its answer (mcsl_core/blender/messages.py). Paths in requests
are absolute; in the .blend they are relative to it, so that the folder can move. A .blend is saved under a hidden name
beside its own and renamed: the old one or the whole new one, never a part.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import attrs
import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core import edl as edls
from mcsl_core.blender.messages import (
    BuiltTimeline,
    ReadDecisions,
    ReadRequest,
    RefreshRequest,
    RenderedVideo,
    RenderRequest,
    TimelineRequest,
    structure,
    to_json,
)
from mcsl_core.errors import BlenderError, InputError
from mcsl_core.progress import JsonLines
from mcsl_core.temporary import temporary_beside, temporary_folder

from ..core.field import take_drawing
from ..core.overruled import overruled
from ..core.read_overrides import read_edl
from ..core.strip_plan import StripPlan, make_plan
from ..sequencer import conformed, output, scene_properties
from ..sequencer.build import build_timeline
from ..sequencer.compat import use_sequencer_scene
from ..sequencer.delivered import delivered_scene
from ..sequencer.edit import drop_drawing
from ..sequencer.notices import notices
from ..sequencer.read import read_drawing, read_timeline
from ..sequencer.renew import rebuild_timeline
from ..sequencer.sound import has_sound, keep_silent
from .confine import confine


def timeline(request: TimelineRequest, progress: JsonLines) -> BuiltTimeline:
    """A new .blend with the timeline of an EDL."""
    edl = edls.load(request.edl)
    plan = make_plan(edl, request.conformed, request.sound)
    if request.silent:
        plan = attrs.evolve(plan, sound=())
    progress.stage("timeline", None)
    bpy.ops.wm.read_homefile(app_template="Video_Editing", use_factory_startup=True)
    scene = bpy.context.scene
    scene.name = "Programme"
    use_sequencer_scene(scene)
    notes = build_timeline(scene, plan, request.edl.parent)
    if request.silent:
        keep_silent(scene, plan)
    output.apply(scene, request.preset, "//" + request.output, sound=True)  # the editor may lay some later
    return _finished(scene, edl, plan, request, notes, progress)


def refresh(request: RefreshRequest, progress: JsonLines) -> BuiltTimeline:
    """Programme, Centering, Conformed and sound of an existing .blend from its EDL."""
    edl = edls.load(request.edl)
    progress.stage("timeline", None)
    scene = _open(request.blend)
    use_sequencer_scene(scene)
    plan = make_plan(edl, request.conformed, request.sound)
    notes = rebuild_timeline(scene, plan, request.edl.parent)
    if take_drawing(edl, read_drawing(scene)).fields == edl.drawn_fields:
        drop_drawing(scene)  # pulled: kept, it would come back over what is written into the EDL from now on
    return _finished(scene, edl, plan, request, notes, progress)


def read(request: ReadRequest, progress: JsonLines) -> ReadDecisions:
    """The overrides, corrections, look and drawn fields of the EDL that the .blend names, after the editor's work.

    The .blend stays as it is, but for conformed pictures that no longer show what was decided: they fall away.
    """
    scene = _open(request.blend)
    edl_path, edl = scene_properties.linked_edl(scene, request.blend, request.instead)
    state = read_timeline(scene)
    new = read_edl(edl, state)
    since = overruled(edl, new, scene.get(scene_properties.OVERRIDE_COUNT))
    for note in (*since, *notices(scene, edl, state)):
        progress.note(note)
    if new.drawn_fields != edl.drawn_fields:
        progress.note("the surgical field is taken as it is drawn in this timeline")
    if conformed.any_there(scene) and conformed.keep_true(scene, new).changed:
        try:
            _save(request.blend)
            progress.note(
                "conformed pictures that no longer show what was decided fell away: `mcsl conform` makes others"
            )
        except InputError as error:  # what was decided can be read all the same
            progress.note(f"conformed pictures no longer show what was decided, and {error}")
    decided = (new.overrides, new.corrections, new.look, new.drawn_fields, new.removed, new.audio_from)
    return ReadDecisions(edl_path, *decided, changed=new != edl)


def render(request: RenderRequest, progress: JsonLines) -> RenderedVideo:
    """The .blend as it stands, to a video."""
    scene = _open(request.blend)
    for note in confine(scene):
        progress.note(note)
    sound = has_sound(scene)
    output.apply(scene, request.preset, str(request.output), sound=sound)
    with temporary_folder("sound") as folder:
        if request.delivered:
            scene = delivered_scene(scene, request.delivered, folder, sound=sound)
            use_sequencer_scene(scene)
        return _rendered(scene, request.output, progress)


def _rendered(scene: Any, path: Path, progress: JsonLines) -> RenderedVideo:
    total = len(range(scene.frame_start, scene.frame_end + 1, scene.frame_step))
    progress.stage("render", total, "frames")
    done = 0

    def written(*_: Any) -> None:
        nonlocal done
        done += 1
        progress.advance(done)

    bpy.app.handlers.render_write.append(written)  # render_post also comes for the scenes of scene strips
    bpy.ops.render.render(animation=True, scene=scene.name)
    if done != total or not path.is_file():
        raise BlenderError(f"wrote {done} of {total} frames", where=str(path), remedy="See the end of its log above")
    return RenderedVideo(path, done)


TASKS: dict[str, tuple[type[Any], Callable[[Any, JsonLines], Any]]] = {
    TimelineRequest.task: (TimelineRequest, timeline),
    RefreshRequest.task: (RefreshRequest, refresh),
    ReadRequest.task: (ReadRequest, read),
    RenderRequest.task: (RenderRequest, render),
}


def carry_out(task: str, request: Any, progress: JsonLines) -> Any:
    """The answer to a request, both as JSON values. Raises as the task does, DocumentError for a wrong request."""
    kind, work = TASKS[task]
    return to_json(work(structure(request, kind, where=f"the request of the task {task}"), progress))


def _finished(
    scene: Any,
    edl: edls.Edl,
    plan: StripPlan,
    request: TimelineRequest | RefreshRequest,
    notes: list[str],
    progress: JsonLines,
) -> BuiltTimeline:
    """The basis of the conformed pictures, ids, the save; then what there is to say."""
    conformed.note_basis(scene, edl)
    scene_properties.set_ids(scene, edl, request.edl, request.blend.parent)
    _save(request.blend)
    for note in notes:
        progress.note(note)
    return BuiltTimeline(request.blend, len(plan.programme), plan.frames, len(plan.conformed))


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
    return scene_properties.timeline_scene(blend)


def _save(blend: Path) -> None:
    """The open file, whole or not at all, with relative paths."""
    part = temporary_beside(blend, ".blend")
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
