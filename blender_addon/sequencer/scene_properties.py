# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene and its strips know about their timeline, as Blender's custom properties, and the EDL behind it.

The names stand here alone; saved .blend files hold them. The EDL's path is kept relative to the .blend (//) wherever
there is a way, so that their folder can move.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core import edl as edls
from mcsl_core.edl import Edl
from mcsl_core.errors import InputError

from ..core import identity

TIMELINE_SCHEMA = "mcsl.timeline/1"

MARK = "mcsl"  # of the scene: the timeline's schema; of a strip: its role, and what has none is the editor's

ROLES = ("camera", "programme", "centering", "conformed", "sound", "removed")

# Of the scene.
EDL_PATH = "mcsl_edl"  # the EDL it was built from; a scene that has it holds a timeline
HOME = "mcsl_home"  # the folder it lay in when the way to the EDL was noted, as a hash; '' before its first save
RECORDING = "mcsl_recording"  # what tells the recording it was built from, as JSON
OVERRIDE_COUNT = "mcsl_overrides"  # how many overrides the EDL had when it was last read or written
CAMERA_NAMES = "mcsl_cameras"  # the EDL's cameras in its order, as JSON: key n is the n-th
TRACKS_HASH = "mcsl_tracks"  # what the camera strips were made from
CENTERING_KEYS_HASH = "mcsl_keys"  # the Centering strip's keys as they were written: others are the editor's
FOLLOWED_FOR = "mcsl_followed_for"  # the corrections that the keys of camera strips over movements were made for
CENTERING_PLAN_HASH = "mcsl_centered"  # the plan that those keys were written from
CONFORMED_BASIS = "mcsl_conformed_for"  # what its conformed pictures were made from, by time
SOUND_LAID = "mcsl_sound"  # where sound was laid, as JSON [[start, stop], ...]: what is missing there was taken out
SILENT = "mcsl_silent"  # it was built without sound, as was asked
PROXIES = "mcsl_proxies"  # the camera strips take their preview from proxies
DELIVERED = "mcsl_delivered"  # no timeline, but what is delivered of one, made to be rendered
SOUND_OF = "mcsl_sound_of"  # whose sound was laid, as the EDL names it, or "": automatic
SOUND_FROM = "mcsl_sound_from"  # the camera whose sound was chosen since the EDL was written, none, or "": automatic
DRAWN_FIELDS = "mcsl_drawn_fields"  # the surgical field drawn by hand since the EDL was written last, as text
REMOVED_UPON = "mcsl_removed_upon"  # what the EDL had removed when the marks were laid, as JSON [[start, stop], ...]
DRAWN_UPON = "mcsl_drawn_upon"  # what the EDL had drawn when that was, as text
LOOK_FOR_ALL = {  # a part of the look that was switched for the whole programme
    "centering": "mcsl_look_centering",
    "fill": "mcsl_look_fill",
    "colour": "mcsl_look_colour",
    "surface": "mcsl_look_surface",
    "see_through": "mcsl_look_see_through",
}

# Of a strip.
CAMERA = "mcsl_camera"  # camera strip: whose file it plays
PLANNED_TRANSFORM = "mcsl_planned"  # camera strip: its transform without any correction
FOLLOWS = "mcsl_follows"  # camera strip over a movement: a hash of the keys it was given; others are the editor's
SHOT_ID = "mcsl_id"  # Programme strip
GIVEN_COLOUR = "mcsl_tag"  # camera, Programme strip: the colour it was given here; another one is the editor's
GIVEN_NAME = "mcsl_name"  # Programme strip: the name it was given here; another one is the editor's
LOOK_OF_SHOT = {  # Programme strip: a part of the look that was switched for this shot
    "centering": "mcsl_centering",
    "fill": "mcsl_fill",
    "colour": "mcsl_colour",
    "surface": "mcsl_surface",
    "see_through": "mcsl_see_through",
}
CENTRE = "mcsl_offset"  # Programme strip: the centre by hand, [dx, dy] in programme pixels, or "automatic"
FALLEN = "mcsl_fallen"  # conformed strip: muted by us, as one of the two below; what the editor mutes has none
NO_LONGER_HOLDS, AWAITS_PICTURES = 1, 2  # other decisions now; made of an editor's strip whose file is gone
PLACED = "mcsl_placed"  # camera, conformed, sound strip: where its file was laid, and which, as "40 cam1_b.mp4"

# Of the scene: the analysis' choice by time, as text. Of a Programme strip: its choice where the strip begins.
AUTOMATIC_CAMERA = "mcsl_automatic"


def role_of(strip: Any) -> str:
    """What a strip is to the timeline, one of `ROLES`; '' for the editor's own."""
    role = strip.get(MARK, "")
    return role if role in ROLES else ""


def given_name(strip: Any) -> str:
    """The name that a Programme strip was given here; '' for none, or where something else stands there."""
    name = strip.get(GIVEN_NAME)
    return name if isinstance(name, str) else ""


def note_placed(strip: Any, start: int, name: str) -> None:
    """Notes where the strip's file was laid: its first picture or sample at programme frame ``start``."""
    strip[PLACED] = f"{start} {name}"


def placed_of(strip: Any) -> tuple[int, str] | None:
    """As `note_placed` noted it; None for strips of older timelines, or where the note is not of its making."""
    start, space, name = str(strip.get(PLACED, "")).partition(" ")
    try:
        return (int(start), name) if space else None
    except ValueError:
        return None


_NEEDED = object()


def text_of(owner: Any, name: str, what: str | Callable[[Any], str], default: Any = _NEEDED) -> Any:
    """A property that is a text. InputError, naming it, where it is something else: another mcsl, or another add-on.

    what: what the owner is, or a function of it that says so.
    """
    value = owner.get(name)
    if value is None and default is not _NEEDED:
        return default
    if not isinstance(value, str):
        raise odd(name, value, "a text", what if isinstance(what, str) else what(owner))
    return value


def odd(name: str, value: Any, expected: str, where: str) -> InputError:
    """The error for a property that cannot be what this mcsl wrote."""
    shown = repr(list(value) if hasattr(value, "typecode") or hasattr(value, "to_list") else value)
    return InputError(
        f"has the custom property {name} {shown[:60]}, where {expected} is expected",
        where=where,
        remedy="Another version of mcsl may have made it: remove the property, or build the timeline again",
    )


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


def linked_edl(scene: Any, blend: Path, instead: Path | None = None) -> tuple[Path, Edl]:
    """The scene's EDL: where it lies, absolute, and as it is on disk now, read again only when it changed.

    Parameters
    ----------
    scene
        The scene that holds the timeline.
    blend
        Where its file lies.
    instead
        The EDL that a person named to take the decisions, where there is one: it must be of the same recording, no
        more, and is used where the scene's own cannot be.

    Raises
    ------
    InputError
        It is missing, or what lies there is not this timeline's: see core/identity.py.
    """
    noted = text_of(scene, EDL_PATH, "the scene")
    home = text_of(scene, HOME, "the scene", "")
    facts = identity.facts_from_text(text_of(scene, RECORDING, "the scene", ""))
    automatic = text_of(scene, AUTOMATIC_CAMERA, "the scene", "")
    reason = InputError(f"names the EDL {noted}, which is not there", where=str(blend))
    for place in identity.candidates(noted, blend.parent, home=home):
        path = Path(os.path.normpath(place))
        if not path.is_file():
            continue
        edl = _read(path)
        moved = bool(home) and home != identity.home_of(blend.parent)
        copied = not home and not noted.startswith("//") and str(path) != os.path.normpath(noted)
        try:
            strict = (moved or copied) and (instead is None or instead.is_file())
            identity.check_belongs(edl, path, facts, automatic=automatic, moved=strict)
        except InputError as error:
            reason = InputError(f"names the EDL {noted}, which {error.what}", where=str(blend))
            continue
        return path, edl
    if instead is not None and instead.is_file():
        edl = _read(instead)
        identity.check_belongs(edl, instead, facts, automatic="", moved=True)
        return instead, edl
    raise InputError(
        reason.what,
        where=reason.where,
        remedy="Open it where it was made, keep the .blend and its EDL where they lay to each other, or say which EDL "
        f"of this recording takes the decisions: mcsl pull {blend.name} -o EDL.json",
    )


def edl_path(scene: Any, blend: Path) -> Path:
    """Where the scene's EDL lies; raises as `linked_edl`."""
    return linked_edl(scene, blend)[0]


def set_ids(scene: Any, edl: Edl, path: Path, folder: Path | None) -> None:
    """Notes in the scene what it was built from. folder: the .blend's; None while it has no name yet."""
    scene[MARK] = TIMELINE_SCHEMA
    scene[OVERRIDE_COUNT] = len(edl.overrides)
    scene[SOUND_OF] = edl.audio_from or ""
    scene[CAMERA_NAMES] = json.dumps([camera.name for camera in edl.cameras], ensure_ascii=False)
    scene[RECORDING] = identity.facts_to_text(identity.facts_of(edl))
    note_home(scene, path, folder)


def note_home(scene: Any, path: Path, folder: Path | None) -> None:
    """Notes the way to the EDL at ``path`` from the .blend's ``folder``, and that it lies there."""
    scene[EDL_PATH] = relative(path, folder)
    scene[HOME] = "" if folder is None else identity.home_of(folder)


def note_saving(scene: Any, old: Path | None, new: Path) -> None:
    """The .blend is about to be saved in the folder ``new``, having lain in ``old``; None: it had no name yet.

    The way to the EDL becomes one from its folder when it is first saved. Saved elsewhere later it leads back to the
    same EDL, unless one lies where it leads to from there: that is a copy's own, or another project's.
    """
    noted = scene.get(EDL_PATH)
    if not isinstance(noted, str):
        return
    if scene.get(HOME):
        if old is None or old.resolve() == new.resolve():
            return
        if not any(place.is_file() for place in identity.candidates(noted, new, home=scene[HOME])):
            note_home(scene, edl_path(scene, old / "its.blend"), new)
    elif old is None:
        note_home(scene, Path(noted), new)
    elif noted.startswith("//"):
        scene[HOME] = identity.home_of(old)


def camera_names(scene: Any) -> list[str]:
    """The EDL's cameras in its order, as the timeline was built from it: key n is the n-th."""
    try:
        names = json.loads(scene.get(CAMERA_NAMES, ""))
        if isinstance(names, list) and all(isinstance(name, str) for name in names):
            return names
    except (ValueError, TypeError):
        pass
    return [camera.name for camera in edl_of(scene).cameras]  # older than the property, or another's


@lru_cache(maxsize=4)
def _loaded(path: Path, _state: tuple[int, ...]) -> Edl:
    return edls.load(path)


def _read(path: Path) -> Edl:
    state = path.stat()
    return _loaded(path, (state.st_mtime_ns, state.st_size, state.st_ino))


def edl_of(scene: Any) -> Edl:
    """The scene's EDL as it lies on disk now. Raises as `linked_edl` and `load`."""
    return linked_edl(scene, Path(bpy.data.filepath))[1]


def relative(path: Path, folder: Path | None) -> str:
    """// and the way from ``folder``; the whole path where there is none (no folder yet, another drive)."""
    if folder is None:
        return path.as_posix()
    try:
        return "//" + Path(os.path.relpath(path, folder)).as_posix()
    except ValueError:
        return path.as_posix()
