# SPDX-License-Identifier: GPL-3.0-or-later
"""StripPlan -> the sequencer, and the sequencer -> SequencerState: the only user of Blender's strip API.

Programme frame n is Blender's frame n + 1. Every strip made here carries the property `mcsl` with its role (camera,
programme, centering, conformed, sound); what has none belongs to the editor and is never touched, only moved up when
it lies where our channels are. What differs between Blender 4.5, 5.0 and 5.2 stands in the first section.
"""

from __future__ import annotations

import hashlib
from array import array
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.edl import Look
from mcsl_core.errors import BlenderError, InputError

from . import plan as plans
from .nudges import FoundCamera
from .plan import CameraTrack, ConformedPiece, OffsetKey, StripPlan
from .readback import AUTOMATIC, FoundStrip, SequencerState
from .reverting import Setting
from .similarity import Transform
from .switching import Switch

ROLE = "mcsl"
PLANNED = "mcsl_planned"  # of a camera strip: its transform without any correction
NAME = "mcsl_name"  # of a Programme strip: the name it was given here; another one is the editor's
TRACKS = "mcsl_tracks"  # of the scene: what the camera strips were made from
LOOK = "mcsl_look_"  # of the scene, with the aid's name after it: switched for the whole programme
KEYS = "mcsl_keys"  # of the scene: the Centering strip's keys as they were written
REBUILT = ("programme", "centering", "conformed", "sound")  # from the EDL anew; camera strips stay as they are
HIGHEST_CHANNEL = 128  # Blender has no more
OVERRIDDEN_COLOUR = "COLOR_03"  # yellow: an editor's decision
AXES = ("x", "y")
AIDS = ("centering", "fill", "colour")
_CONSTANT, _LINEAR = 0, 1  # Blender's interpolation codes, as foreach_set takes them

# --------------------------------------------------------------------------------------------- version differences


def new_effect(scene: Any, name: str, kind: str, channel: int, start: int, stop: int) -> Any:
    """An effect strip over programme frames [start, stop). 4.5 takes an end, 5.0 a length."""
    span = {"length": stop - start} if bpy.app.version >= (5, 0, 0) else {"frame_end": stop + 1}
    return scene.sequence_editor.strips.new_effect(name=name, type=kind, channel=channel, frame_start=start + 1, **span)


def ends(strip: Any) -> tuple[int, int]:
    """The programme frames [start, stop) a strip shows. `frame_final_*` is deprecated in 5.2."""
    if hasattr(strip, "left_handle"):
        return int(strip.left_handle) - 1, int(strip.right_handle) - 1
    return int(strip.frame_final_start) - 1, int(strip.frame_final_end) - 1


def sequencer_scene(context: Any) -> Any:
    """The scene the sequencer cuts; from 5.0 the workspace names it, and it may be none."""
    return getattr(context, "sequencer_scene", None) or context.scene


def use_sequencer_scene(scene: Any) -> None:
    """From 5.0 each workspace names the scene it cuts; unset, touching strip modifiers crashes."""
    for workspace in bpy.data.workspaces:
        if hasattr(workspace, "sequencer_scene"):
            workspace.sequencer_scene = scene


# -------------------------------------------------------------------------------------------------------- building


def build(scene: Any, plan: StripPlan, base: Path) -> list[str]:
    """Fills an empty scene. base: the folder the plan's paths are relative to. Returns remarks for a person.

    Raises BlenderError naming the file that Blender cannot open.
    """
    _settings(scene, plan)
    scene.sequence_editor_create()
    notes = [*plan.notes, *_cameras(scene, plan, base)]
    notes.extend(_decided(scene, plan, base))
    for marker in plan.markers:
        scene.timeline_markers.new(marker.name, frame=marker.frame + 1)
    return notes


def rebuild(scene: Any, plan: StripPlan, base: Path) -> list[str]:
    """Programme, Centering, Conformed and sound anew from ``plan``; the editor's own strips stay.

    The camera strips stay as well, unless the EDL's cameras, files or poses are others than when they were made. Where
    one of the editor's strips lies on our channels, all of them move up together, keeping their order.
    """
    editor = scene.sequence_editor
    others = scene.get(TRACKS) not in (None, plans.tracks_key(plan.cameras))
    cameras = {s["mcsl_camera"] for s in editor.strips if _role(s) == "camera"}
    gone = (*REBUILT, "camera") if others else REBUILT
    for strip in [s for s in editor.strips if _role(s) in gone or (s.type == "MULTICAM" and not s.mute)]:
        editor.strips.remove(strip)
    notes = []
    lowest = min(plan.programme_channel, plans.FIRST_CAMERA_CHANNEL + len(cameras))  # where ours began, or begin now
    above = sorted((s for s in editor.strips if not _role(s) and s.channel >= lowest), key=_by_channel)
    if above and (lift := plan.conformed_channel + 1 - above[0].channel) > 0:
        if above[-1].channel + lift > HIGHEST_CHANNEL:
            raise InputError(
                "has no channel left above Conformed for your strips",
                where=f"strip {above[-1].name!r} on channel {above[-1].channel}",
                remedy="Move your highest strips down",
            )
        for strip in reversed(above):  # the highest first: each finds its new place free
            strip.channel += lift
        notes.append(f"your strips moved up by {lift} channels, to lie above the Conformed channel")
    if others:
        notes.append("the EDL has other cameras, files or poses than this timeline: its camera strips were made anew")
        notes.extend(_cameras(scene, plan, base))
    return notes + _decided(scene, plan, base)


def _settings(scene: Any, plan: StripPlan) -> None:
    render = scene.render
    render.fps = -(-plan.rate.numerator // plan.rate.denominator)  # rounded up, as Blender's own 30 / 1.001
    render.fps_base = float(render.fps / plan.rate)
    render.resolution_x, render.resolution_y = plan.size
    render.use_sequencer, render.use_compositing = True, False
    render.dither_intensity = 0.0
    render.use_stamp = False
    scene.frame_start, scene.frame_end, scene.frame_step = 1, plan.frames, 1
    # Standard keeps 47-48 dB against the source, the default AgX 33 dB.
    scene.display_settings.display_device = "sRGB"
    view = scene.view_settings
    view.view_transform, view.look, view.exposure, view.gamma = "Standard", "None", 0.0, 1.0
    scene.sequencer_colorspace_settings.name = "sRGB"


def _cameras(scene: Any, plan: StripPlan, base: Path) -> list[str]:
    scene[TRACKS] = plans.tracks_key(plan.cameras)
    return [note for track in plan.cameras for note in _camera(scene, track, base)]


def _camera(scene: Any, track: CameraTrack, base: Path) -> list[str]:
    """A camera's files, one movie strip each (0.15 s of opening), split at the pieces; what lies between goes."""
    notes = []
    _channel(scene, track.channel, track.camera)
    for file in track.files:
        strip = _movie(scene, track.camera, base / file.path, track.channel, file.start)
        strip[ROLE], strip["mcsl_camera"] = "camera", track.camera
        start, stop = ends(strip)
        if stop - start != file.frames:
            notes.append(f"{track.camera}: {file.path} has {file.frames} frames, Blender counts {stop - start}")
        pieces = [p for p in file.pieces if p.range.start < stop]
        for piece in pieces:
            if piece.range.start > start:
                gap, strip = strip, _split(strip, piece.range.start)
                scene.sequence_editor.strips.remove(gap)
            rest = _split(strip, piece.range.stop) if piece.range.stop < stop else None
            _set_transform(strip, piece.transform)
            strip[PLANNED] = _numbers(piece.planned)
            if rest is None:
                break
            strip, start = rest, piece.range.stop
        else:
            scene.sequence_editor.strips.remove(strip)  # what is left lies after the last piece
    return notes


def _set_transform(strip: Any, transform: Transform) -> None:
    to = strip.transform
    # rounded far below a pixel, so that no field shows -0
    to.offset_x, to.offset_y, to.scale_x, to.scale_y, to.rotation = (round(n, 9) + 0.0 for n in _numbers(transform))


def _numbers(transform: Transform) -> list[float]:
    """As the property `mcsl_planned` holds it: offset_x, offset_y, scale_x, scale_y, rotation."""
    t = transform
    return [t.offset_x, t.offset_y, t.scale, t.height_scale, t.rotation]


def _transform(numbers: Sequence[float]) -> Transform:
    """The inverse of `_numbers`."""
    x, y, scale, scale_y, rotation = map(float, numbers)
    return Transform(x, y, scale, rotation, None if scale == scale_y else scale_y)


def _split(strip: Any, frame: int) -> Any:
    """The right part of ``strip`` cut at a programme frame; ``strip`` keeps the left."""
    right = strip.split(frame=frame + 1, split_method="SOFT")
    if right is None:
        raise BlenderError(f"strip {strip.name!r} cannot be split at frame {frame + 1}")
    return right


def split_at(strip: Any, frames: Sequence[int]) -> list[Any]:
    """The parts of ``strip`` cut at programme frames, which rise and lie inside it; in order."""
    parts = [strip]
    for frame in frames:
        parts.append(_split(parts[-1], frame))
    return parts


def _movie(scene: Any, name: str, path: Path, channel: int, start: int) -> Any:
    if not path.is_file():
        raise InputError("is missing", where=str(path), remedy="Put the file back, or correct the EDL's media paths")
    strip = scene.sequence_editor.strips.new_movie(
        name=name, filepath=str(path), channel=channel, frame_start=start + 1, fit_method="ORIGINAL"
    )
    if not strip.elements or strip.elements[0].orig_width == 0:
        raise BlenderError("Blender cannot read it as video", where=str(path), remedy="Convert it to H.264 in MP4")
    strip.blend_type = "REPLACE"  # with ALPHA_OVER, the default, all cameras below are decoded too
    return strip


def _decided(scene: Any, plan: StripPlan, base: Path) -> list[str]:
    """Everything that follows from decisions: Programme, Centering, Conformed, sound, and the ids in the scene."""
    _channel(scene, plans.AUDIO_CHANNEL, "Audio")
    _channel(scene, plan.programme_channel, "Programme")
    _channel(scene, plan.centering_channel, "Centering")
    _channel(scene, plan.conformed_channel, "Conformed")
    for number, shot in enumerate(plan.programme, 1):  # names of their own: Blender's search for a free .001 is slow
        name = f"{number}: {shot.camera}"
        strip = new_effect(scene, name, "MULTICAM", plan.programme_channel, shot.range.start, shot.range.stop)
        strip[NAME] = name
        strip.multicam_source = shot.source
        strip[ROLE], strip["mcsl_id"], strip["mcsl_automatic"] = "programme", shot.id, shot.automatic
        if shot.overridden:
            strip.color_tag = OVERRIDDEN_COLOUR
    strip = new_effect(scene, "Centering", "ADJUSTMENT", plan.centering_channel, 0, plan.frames)
    strip[ROLE] = "centering"
    strip.transform.filter = "BILINEAR"
    center(scene, plan.centering)
    for piece in plan.conformed:
        conformed(scene, piece, plan.conformed_channel, base)
    scene["mcsl_automatic"] = plans.automatic_to_text(plan.automatic)
    notes = _sound(scene, plan, base)
    for strip in scene.sequence_editor.strips:
        if _role(strip) and strip.select:  # what is new comes selected: the next key would move it all
            strip.select = False
    return notes


def conformed(scene: Any, piece: ConformedPiece, channel: int, base: Path) -> None:
    """One file of exact pictures in its place. BlenderError when its length is not the stretch's."""
    path = base / piece.path
    strip = _movie(scene, "conformed", path, channel, piece.range.start)
    strip[ROLE] = "conformed"
    if ends(strip) != (piece.range.start, piece.range.stop):
        start, stop = ends(strip)
        raise BlenderError(
            f"has {stop - start} frames, {len(piece.range)} belong there", where=str(path), remedy="Conform again"
        )


def _sound(scene: Any, plan: StripPlan, base: Path) -> list[str]:
    """The sound strips, cut to the programme; a file without sound is a remark, not a fault."""
    notes = []
    for piece in plan.sound:
        path = base / piece.path
        if not path.is_file():
            raise InputError("is missing", where=str(path), remedy="Put the file back, or correct the EDL's paths")
        strip = scene.sequence_editor.strips.new_sound(
            name="sound", filepath=str(path), channel=plans.AUDIO_CHANNEL, frame_start=piece.start + 1
        )
        strip[ROLE] = "sound"
        start, stop = ends(strip)
        if strip.sound.samplerate == 0 or stop <= 0 or start >= plan.frames:
            if strip.sound.samplerate == 0:
                notes.append(f"{piece.path} has no sound")
            scene.sequence_editor.strips.remove(strip)
            continue
        if start < 0:
            before, strip = strip, _split(strip, 0)
            scene.sequence_editor.strips.remove(before)
        if stop > plan.frames:
            scene.sequence_editor.strips.remove(_split(strip, plan.frames))
    return notes


def replace_sound(scene: Any, plan: StripPlan, base: Path) -> list[str]:
    """The sound anew from ``plan``, in place of ours; the editor's own stays. Notes for a person."""
    for strip in [s for s in scene.sequence_editor.strips if _role(s) == "sound"]:
        scene.sequence_editor.strips.remove(strip)
    return _sound(scene, plan, base)


def has_sound(scene: Any) -> bool:
    """Whether any sound strip is left that can be heard."""
    return any(s.type == "SOUND" and not s.mute for s in scene.sequence_editor.strips_all)


def center(scene: Any, keys: Sequence[OffsetKey]) -> None:
    """The Centering strip's keys, in place of those it has: the preview moves at once."""
    strip = _centering(scene)
    if strip is None:
        return
    for axis in AXES:
        curve = _curve(scene, strip, axis, make=bool(keys))
        if curve is None:
            continue
        points = curve.keyframe_points
        points.clear()
        points.add(len(keys))  # all at once: 10,000 in 7 ms
        points.foreach_set("co", [number for key in keys for number in (key.frame + 1, getattr(key, axis))])
        points.foreach_set("interpolation", [_CONSTANT if key.hold else _LINEAR for key in keys])
        curve.update()
    if not keys:
        strip.transform.offset_x = strip.transform.offset_y = 0.0
    scene[KEYS] = _keys_as_found(scene)


def _centering(scene: Any) -> Any:
    return next((s for s in scene.sequence_editor.strips if _role(s) == "centering"), None)


def _curve(scene: Any, strip: Any, axis: str, *, make: bool) -> Any:
    """The F-curve of the strip's offset, or None where there is none and none is to be made."""
    path = f'sequence_editor.strips_all["{strip.name}"].transform.offset_{axis}'
    animation = scene.animation_data_create() if make else scene.animation_data
    if animation is None:
        return None
    if animation.action is None:
        if not make:
            return None
        animation.action = bpy.data.actions.new("mcsl")
    if make:
        return animation.action.fcurve_ensure_for_datablock(scene, path)
    for layer in animation.action.layers:
        for part in layer.strips:
            bag = part.channelbag(animation.action_slot) if animation.action_slot else None
            if bag is not None and (curve := bag.fcurves.find(path)) is not None:
                return curve
    return None


def _keys_as_found(scene: Any) -> str:
    """A hash of the Centering strip's keys; '' without any."""
    strip = _centering(scene)
    values = array("f")
    for axis in AXES if strip is not None else ():
        curve = _curve(scene, strip, axis, make=False)
        if curve is not None:
            found = array("f", bytes(8 * len(curve.keyframe_points)))
            curve.keyframe_points.foreach_get("co", found)
            values.extend(found)
    return hashlib.sha256(values.tobytes()).hexdigest()[:16] if values else ""


def _channel(scene: Any, index: int, name: str) -> None:
    scene.sequence_editor.channels[index].name = name


def _by_channel(strip: Any) -> int:
    return strip.channel


def _role(strip: Any) -> str:
    return strip.get(ROLE, "")


# --------------------------------------------------------------------------------------------------------- reading


def read(scene: Any) -> SequencerState:
    """What the editor left: every Multicam strip on every channel, and where the cameras are."""
    editor = scene.sequence_editor
    top = {s.name for s in editor.strips}
    for strip in editor.strips_all:
        if strip.type == "MULTICAM" and strip.name not in top:
            raise InputError(
                "is a Multicam strip inside a meta strip, where it has no cameras",
                where=f"strip {strip.name!r}",
                remedy="Separate the meta strip (Ctrl-Alt-G) and save",
            )
    strips, cameras = [], []
    for strip in editor.strips:
        start, stop = ends(strip)
        if strip.type == "MULTICAM":
            strips.append(
                FoundStrip(
                    name=strip.name,
                    channel=strip.channel,
                    start=start,
                    stop=stop,
                    source=strip.multicam_source,
                    muted=strip.mute,
                    centering=_switch(strip, "mcsl_centering"),
                    fill=_switch(strip, "mcsl_fill"),
                    colour=_switch(strip, "mcsl_colour"),
                    offset=_offset(strip),
                )
            )
        elif _role(strip) == "camera":
            planned = strip.get(PLANNED)
            t = strip.transform
            cameras.append(
                FoundCamera(
                    camera=strip["mcsl_camera"],
                    channel=strip.channel,
                    start=start,
                    stop=stop,
                    name=strip.name,
                    transform=_transform([t.offset_x, t.offset_y, t.scale_x, t.scale_y, t.rotation]),
                    planned=None if planned is None else _transform(planned),
                )
            )
    automatic = scene.get("mcsl_automatic")
    return SequencerState(
        strips=tuple(strips),
        cameras=tuple(cameras),
        automatic=plans.automatic_from_text(automatic) if automatic else None,
        look=tuple((aid, bool(scene[LOOK + aid])) for aid in AIDS if LOOK + aid in scene),
        notes=_remarks(scene),
    )


def _remarks(scene: Any) -> tuple[str, ...]:
    """What an editor did that is not read, for a person."""
    if scene.get(KEYS, "") not in ("", _keys_as_found(scene)):
        return (
            "the Centering strip or its keys were changed by hand, which is not read: to set the centre of a shot, "
            "use the panel (or the strip's property mcsl_offset)",
        )
    return ()


def _offset(strip: Any) -> Any:
    """The strip's centre by hand: two numbers to a thousandth of a pixel, AUTOMATIC, or None."""
    value = strip.get("mcsl_offset")
    if value is None or value == AUTOMATIC:
        return value
    try:
        x, y = (round(float(number), 3) for number in value)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"has mcsl_offset {value!r}; two numbers [dx, dy] are expected, or {AUTOMATIC!r}",
            where=f"strip {strip.name!r}, frame {ends(strip)[0] + 1}",
            remedy="Correct it among the strip's custom properties, or remove it",
        ) from error
    return x, y


def _switch(strip: Any, name: str) -> bool | None:
    value = strip.get(name)
    return None if value is None else bool(value)


# --------------------------------------------------------------------------------------------------------- by hand


def apply_switch(scene: Any, change: Switch) -> None:
    """Cuts and switches as decided; the part that is shown from now on becomes the active strip, alone selected."""
    strip = scene.sequence_editor.strips[change.name]
    if change.split is not None:
        strip = _split(strip, change.split)
    strip.multicam_source = change.source
    for other in scene.sequence_editor.strips:
        if other.select and other != strip:
            other.select = False
    strip.select = True
    scene.sequence_editor.active_strip = strip


def revert(scene: Any, settings: Mapping[str, Sequence[Setting]], look: Look) -> None:
    """Strips cut and set as `reverting` decided; in what is set, look and centre are the programme's again."""
    for name, parts in settings.items():
        cuts = [part.range.stop for part in parts[:-1]]
        for strip, part in zip(split_at(scene.sequence_editor.strips[name], cuts), parts, strict=True):
            if part.source is not None:
                strip.multicam_source = part.source
                _be_silent(strip)
                for aid in part.said & set(AIDS):
                    strip[f"mcsl_{aid}"] = getattr(look, aid)
                if "offset" in part.said:
                    strip["mcsl_offset"] = AUTOMATIC


def say_nothing(scene: Any) -> None:
    """The EDL holds all that the strips said about looks and centres: from now on they say nothing of their own."""
    for strip in scene.sequence_editor.strips:
        if strip.type == "MULTICAM":
            _be_silent(strip)
    for aid in AIDS:
        scene.pop(LOOK + aid, None)


def _be_silent(strip: Any) -> None:
    for name in (*AIDS, "offset"):
        strip.pop(f"mcsl_{name}", None)


def label(scene: Any, overridden: frozenset[str], cameras: Mapping[str, str]) -> None:
    """Yellow for the ``overridden`` strips, none for the other Multicam strips, and the camera in their names.

    cameras: what each strip shows, by its name. An editor's own colours and names stay.
    """
    for strip in [s for s in scene.sequence_editor.strips if s.type == "MULTICAM"]:
        name = strip.name
        wanted = OVERRIDDEN_COLOUR if name in overridden else "NONE"
        if strip.color_tag != wanted and strip.color_tag in ("NONE", OVERRIDDEN_COLOUR):
            strip.color_tag = wanted
        given = strip.get(NAME)  # split, it is followed by .001
        if given and name.startswith(given) and name in cameras:
            number = given.partition(":")[0]
            if (now := f"{number}: {cameras[name]}") != given:
                strip.name = strip[NAME] = now


def can_be_reset(strip: Any) -> bool:
    """Whether it is a camera strip that knows its automatic place."""
    return _role(strip) == "camera" and strip.get(PLANNED) is not None


def reset_transform(strip: Any) -> None:
    """Back to where the analysis placed the camera: pulling then takes the correction away."""
    _set_transform(strip, _transform(strip[PLANNED]))
