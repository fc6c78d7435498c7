# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps what follows from decisions in line with them: the list of shots, conformed pictures, the centering preview.

When that happens is `handlers`' to say.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import attrs
import bpy  # pyright: ignore[reportMissingImports]
from attrs import frozen

from mcsl_core.edl import Edl
from mcsl_core.edl.resolve import Decisions, DecisionsByPose, resolve, resolve_by_pose
from mcsl_core.errors import McslError
from mcsl_core.timing import FrameRange

from ..core import multicam, shot_list
from ..core.corrections import FoundCamera
from ..core.moving import followed_ranges
from ..core.read_overrides import FoundStrip, SequencerState, read_edl
from ..core.strip_plan import camera_tracks, centred, key_numbers, offset_keys
from ..sequencer import conformed, scene_properties
from ..sequencer.build import deselect
from ..sequencer.camera_keys import follow_movements
from ..sequencer.centering_keys import keyed_by_hand, set_centering_keys
from ..sequencer.compat import sequencer_scene, strips_of
from ..sequencer.edit import label_strips
from ..sequencer.marks import keep_marks
from ..sequencer.notices import notices
from ..sequencer.read import read_shot, read_timeline
from ..sequencer.read_times import read_films
from ..sequencer.sound import follow_choice
from . import job_runner

_busy = False  # what we change ourselves is no news
_last: dict[str, _Refreshed] = {}  # scene -> what was found when it was last refreshed
_listed: tuple[Fraction, tuple[shot_list.ShotRow, ...]] = Fraction(0), ()  # as the panel's list of shots was filled


@frozen
class _Refreshed:
    """What a refresh found and left: the EDL that the timeline decides, the one on disk it was read against, and how.

    state: None where nothing was brought in line. centred: what the keys of the Centering strip were made from.
    """

    edl: Edl
    source: Edl
    state: SequencerState | None = None
    centred: tuple[Any, ...] = ()


def timelines() -> list[Any]:
    """The scenes of this file that hold a timeline."""
    return [s for s in bpy.data.scenes if scene_properties.has_timeline(s)]


def decided(scene: Any) -> Edl:
    """The scene's EDL with the decisions that its timeline shows now. McslError where either cannot be read."""
    return read_edl(scene_properties.edl_of(scene), read_timeline(scene))


def last(scene: Any) -> Edl:
    """As `decided`, when the timeline was last refreshed: for drawing, which happens many times a second."""
    if scene.name not in _last:
        source = scene_properties.edl_of(scene)
        _last[scene.name] = _Refreshed(read_edl(source, read_timeline(scene)), source)
    return _last[scene.name].edl


def cameras(scene: Any) -> tuple[FoundCamera, ...]:
    """Where the cameras' strips lie, as `last`; none where the timeline could not be read."""
    found = _last.get(scene.name)
    return found.state.cameras if found is not None and found.state is not None else ()


def refresh_timeline(scene: Any) -> str:
    """Brings everything in line with the timeline of ``scene``; returns '' or, in a line, why that is not possible.

    Where the EDL or the timeline cannot be read, nothing is changed.
    """
    problem = _bring_in_line(scene)
    if not problem:
        _notice(scene)
    return problem


def refresh_shot(scene: Any, was: FoundStrip, parts: Sequence[Any]) -> str:
    """As `refresh_timeline`, after nothing but this happened: the strip ``was`` has become the strips ``parts``.

    The rest is taken to be as it was last read. What else has changed since is read in the next quiet, as ever.
    """
    return _bring_in_line(scene, (was, parts))


def _bring_in_line(scene: Any, cut: tuple[FoundStrip, Sequence[Any]] | None = None) -> str:
    global _busy
    was, _busy = _busy, True
    try:
        before = _last.pop(scene.name, None)
        state = _after(before, *cut) if cut is not None else None
        source = scene_properties.edl_of(scene)
        if state is None:
            keep_marks(scene, source.removed)
            cut, state = None, read_timeline(scene)
        edl = read_edl(source, state)
        decisions = resolve(edl)
        by_pose = resolve_by_pose(edl, decisions)
        held = conformed.keep_true(scene, edl, by_pose)
        centring = _centre(scene, edl, by_pose, before.centred if before is not None else ())
        if _hear(scene, edl) | _follow(scene, edl):
            state = read_timeline(scene)
        elif held.changed:
            state = attrs.evolve(state, films=read_films(scene))
        state = multicam.with_names(state, _label(scene, edl, state, decisions, None if cut is None else cut[1]))
        _last[scene.name] = _Refreshed(edl, source, state, centring)
    except McslError as error:
        _tell(scene, problem=str(error))
        return str(error)
    finally:
        _busy = was
    seconds = [float(sum(map(len, pieces)) / edl.rate) for pieces in (held.outstanding, held.lost)]
    _tell(scene, edl=edl, decisions=decisions, outstanding_s=seconds[0], lost_s=seconds[1])
    return ""


def _after(last: _Refreshed | None, was: FoundStrip, parts: Sequence[Any]) -> SequencerState | None:
    """The timeline as last read, after a cut; None where that is not known."""
    if last is None or last.state is None:
        return None
    return multicam.replaced(last.state, was, [read_shot(part) for part in parts])


def _label(
    scene: Any, edl: Edl, state: SequencerState, decisions: Decisions, only: Sequence[Any] | None
) -> dict[str, str]:
    """Colours and names follow the decisions, of ``only`` those strips where that is enough; old name -> new."""
    strips = strips_of(scene, "MULTICAM") if only is None else only
    names = {strip.name for strip in strips}
    found = [strip for strip in state.strips if strip.name in names]
    shown = multicam.shown_cameras(attrs.evolve(state, strips=tuple(found)))
    return label_strips(strips, multicam.overridden(decisions, found), shown, key_numbers(edl))


def _notice(scene: Any) -> None:
    """What there is to know before pictures are made, where the panel shows it."""
    last = _last[scene.name]
    if scene == shown_scene() and last.state is not None:
        bpy.context.window_manager.mcsl_state.notices = "\n".join(notices(scene, last.edl, last.state))


def refresh_changed() -> None:
    """Brings in line what timelines have changed since the last time."""
    for scene in timelines():
        if _is_as_it_was(scene):
            _notice(scene)
            job_runner.redraw()
        else:
            refresh_timeline(scene)


def busy() -> bool:
    """Whether what changes now is our own doing."""
    return _busy


def forget() -> None:
    """Another file is open: nothing is known of its timelines."""
    state = bpy.context.window_manager.mcsl_state
    _last.clear()
    state.shots.clear()
    state.notices = ""
    for name in ("problem", "outstanding_s", "lost_s", "removed_s", "removals", "overrides", "short_shots"):
        state.property_unset(name)


def _is_as_it_was(scene: Any) -> bool:
    """Whether nothing that decides has changed since the last refresh: it was our own change that was heard of."""
    last = _last.get(scene.name)
    try:
        return (
            last is not None
            and last.state is not None
            and scene_properties.edl_of(scene) is last.source
            and read_timeline(scene) == last.state
        )
    except McslError:
        return False


def _centre(scene: Any, edl: Edl, by_pose: DecisionsByPose, before: tuple[Any, ...]) -> tuple[Any, ...]:
    """The Centering strip follows the decisions, unless an editor has keyed it by hand; what its keys are made from."""
    made_from = edl.centering, centred(edl, by_pose)
    if made_from == before:
        return made_from
    keys = offset_keys(edl)
    text = hashlib.sha256(repr(keys).encode()).hexdigest()[:16]
    if scene.get(scene_properties.CENTERING_PLAN_HASH) != text and not keyed_by_hand(scene):
        set_centering_keys(scene, keys)
        scene[scene_properties.CENTERING_PLAN_HASH] = text
    return made_from


def _follow(scene: Any, edl: Edl) -> bool:
    """Camera strips over movements go along with what was corrected by hand before and after them; whether they did."""
    text = hashlib.sha256(repr(edl.corrections).encode()).hexdigest()[:16] if edl.corrections else ""
    if scene.get(scene_properties.FOLLOWED_FOR, "") != text and followed_ranges(edl):
        follow_movements(scene, camera_tracks(edl))
        scene[scene_properties.FOLLOWED_FOR] = text
        return True
    return False


def _hear(scene: Any, edl: Edl) -> bool:
    """The sound follows the EDL; whether another's had to be laid."""
    notes = follow_choice(scene, edl, scene_properties.edl_path(scene, Path(bpy.data.filepath)).parent)
    if notes is None:
        return False
    deselect(scene)
    if notes:
        job_runner.say(". ".join(notes), "WARNING")
    return True


def _tell(
    scene: Any,
    edl: Edl | None = None,
    decisions: Decisions | None = None,
    problem: str = "",
    outstanding_s: float = 0.0,
    lost_s: float = 0.0,
) -> None:
    """The panel's state, where ``scene`` is the one it shows."""
    if scene != shown_scene():
        return
    state = bpy.context.window_manager.mcsl_state
    state.problem = problem
    if edl is None:
        return
    state.outstanding_s, state.lost_s = outstanding_s, lost_s
    state.removed_s, state.removals = float(sum(map(len, edl.removed)) / edl.rate), len(edl.removed)
    rows = shot_list.rows_of(edl, decisions)
    state.overrides, state.short_shots = sum(row.overridden for row in rows), len(shot_list.short(rows))
    _list(state.shots, rows, edl.rate)
    job_runner.redraw()


def _list(shots: Any, rows: tuple[shot_list.ShotRow, ...], rate: Fraction) -> None:
    """Fills the panel's list, of which only the rows between those that stay are touched."""
    global _listed
    was = _listed[1] if _listed[0] == rate and len(_listed[1]) == len(shots) else ()
    first, after = shot_list.unchanged(was, rows)
    for index in range(len(was) - after - 1, first - 1, -1):
        shots.remove(index)
    if not was:
        shots.clear()
    for index in range(first, len(rows) - after):
        item, row = shots.add(), rows[index]
        item.start, item.stop = row.range.start, row.range.stop
        item.camera, item.automatic, item.why = row.camera, row.automatic, row.why
        item.score, item.overridden = row.score, row.overridden
        item.time = shot_list.time_text(row.range.start, rate)
        shots.move(len(shots) - 1, index)
    _listed = rate, rows


def show_recording(scene: Any) -> None:
    """The panel's list of cameras from the EDL, where it is still empty: to analyse again needs no picking."""
    work = scene.mcsl_work
    if work.cameras:
        return
    try:
        edl = scene_properties.edl_of(scene)
    except McslError:
        return
    base = scene_properties.edl_path(scene, Path(bpy.data.filepath))
    for camera in edl.cameras:
        item = work.cameras.add()
        item.name = camera.name
        item.files = "\n".join(str(base.parent / media.path) for media in camera.media)
    work.reference, work.edl = edl.reference, scene[scene_properties.EDL_PATH]


def listed() -> tuple[shot_list.ShotRow, ...]:
    """The list of shots as the panel was last filled: for drawing, which must not read it from there every time."""
    return _listed[1]


def rows() -> tuple[shot_list.ShotRow, ...]:
    """The list of shots as the panel has it."""
    return tuple(
        shot_list.ShotRow(FrameRange(i.start, i.stop), i.camera, i.automatic, i.score, i.why, i.overridden)
        for i in bpy.context.window_manager.mcsl_state.shots
    )


def shown_scene() -> Any:
    """The scene that the sequencer shows; where it has no timeline, the file's only one."""
    scene = sequencer_scene(bpy.context)
    found = timelines()
    if scene in found or len(found) != 1:
        return scene
    return found[0]
