# SPDX-License-Identifier: GPL-3.0-or-later
"""StripPlan -> the sequencer: an empty scene is filled, or what follows from decisions is made anew."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mcsl_core.blender.messages import ConformedPiece
from mcsl_core.edl.playlists import list_kind
from mcsl_core.errors import BlenderError, InputError

from ..core.strip_plan import AUDIO_CHANNEL, FIRST_CAMERA_CHANNEL, CameraTrack, StripPlan, automatic_to_text, tracks_key
from .centering_keys import set_centering_keys
from .compat import ends, new_effect
from .edit import OVERRIDDEN_COLOUR, split_strip
from .scene_properties import (
    AUTOMATIC_CAMERA,
    CAMERA,
    GIVEN_NAME,
    MARK,
    PLANNED_TRANSFORM,
    SHOT_ID,
    TRACKS_HASH,
    role_of,
)
from .transforms import set_transform, transform_numbers

REBUILT = ("programme", "centering", "conformed", "sound")  # from the EDL anew; camera strips stay as they are
HIGHEST_CHANNEL = 128  # Blender has no more


def build_timeline(scene: Any, plan: StripPlan, base: Path) -> list[str]:
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


def rebuild_timeline(scene: Any, plan: StripPlan, base: Path) -> list[str]:
    """Programme, Centering, Conformed and sound anew from ``plan``; the editor's own strips stay.

    The camera strips stay as well, unless the EDL's cameras, files or poses are others than when they were made. Where
    one of the editor's strips lies on our channels, all of them move up together, keeping their order.
    """
    editor = scene.sequence_editor
    others = scene.get(TRACKS_HASH) not in (None, tracks_key(plan.cameras))
    cameras = {s[CAMERA] for s in editor.strips if role_of(s) == "camera"}
    gone = (*REBUILT, "camera") if others else REBUILT
    for strip in [s for s in editor.strips if role_of(s) in gone or (s.type == "MULTICAM" and not s.mute)]:
        editor.strips.remove(strip)
    notes = []
    lowest = min(plan.programme_channel, FIRST_CAMERA_CHANNEL + len(cameras))  # the Programme's, as it was or now
    above = sorted((s for s in editor.strips if not role_of(s) and s.channel >= lowest), key=_by_channel)
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
    colours = scene.view_settings
    colours.view_transform, colours.look, colours.exposure, colours.gamma = "Standard", "None", 0.0, 1.0
    scene.sequencer_colorspace_settings.name = "sRGB"


def _cameras(scene: Any, plan: StripPlan, base: Path) -> list[str]:
    scene[TRACKS_HASH] = tracks_key(plan.cameras)
    return [note for track in plan.cameras for note in _camera(scene, track, base)]


def _camera(scene: Any, track: CameraTrack, base: Path) -> list[str]:
    """A camera's files, one movie strip each (0.15 s of opening), split at the pieces; what lies between goes."""
    notes = []
    _channel(scene, track.channel, track.camera)
    for file in track.files:
        strip = _movie(scene, track.camera, base / file.path, track.channel, file.start)
        strip[MARK], strip[CAMERA] = "camera", track.camera
        start, stop = ends(strip)
        if stop - start != file.frames:
            notes.append(f"{track.camera}: {file.path} has {file.frames} frames, Blender counts {stop - start}")
        pieces = [p for p in file.pieces if p.range.start < stop]
        for piece in pieces:
            if piece.range.start > start:
                gap, strip = strip, split_strip(strip, piece.range.start)
                scene.sequence_editor.strips.remove(gap)
            rest = split_strip(strip, piece.range.stop) if piece.range.stop < stop else None
            set_transform(strip, piece.transform)
            strip[PLANNED_TRANSFORM] = transform_numbers(piece.planned)
            if rest is None:
                break
            strip, start = rest, piece.range.stop
        else:
            scene.sequence_editor.strips.remove(strip)  # what is left lies after the last piece
    return notes


def _movie(scene: Any, name: str, path: Path, channel: int, start: int) -> Any:
    if not path.is_file():
        raise InputError("is missing", where=str(path), remedy="Put the file back, or correct the EDL's media paths")
    if kind := list_kind(path):  # Blender would open what it leads to
        raise InputError(f"is {kind}; what it leads to is not opened", where=str(path), remedy="Name the video itself")
    strip = scene.sequence_editor.strips.new_movie(
        name=name, filepath=str(path), channel=channel, frame_start=start + 1, fit_method="ORIGINAL"
    )
    if not strip.elements or strip.elements[0].orig_width == 0:
        raise BlenderError("Blender cannot read it as video", where=str(path), remedy="Convert it to H.264 in MP4")
    strip.blend_type = "REPLACE"  # with ALPHA_OVER, the default, all cameras below are decoded too
    return strip


def _decided(scene: Any, plan: StripPlan, base: Path) -> list[str]:
    """Everything that follows from decisions: Programme, Centering, Conformed, sound, and the ids in the scene."""
    _channel(scene, AUDIO_CHANNEL, "Audio")
    _channel(scene, plan.programme_channel, "Programme")
    _channel(scene, plan.centering_channel, "Centering")
    _channel(scene, plan.conformed_channel, "Conformed")
    for number, shot in enumerate(plan.programme, 1):  # names of their own: Blender's search for a free .001 is slow
        name = f"{number}: {shot.camera}"
        strip = new_effect(scene, name, "MULTICAM", plan.programme_channel, shot.range.start, shot.range.stop)
        strip[GIVEN_NAME] = name
        strip.multicam_source = shot.source
        strip[MARK], strip[SHOT_ID], strip[AUTOMATIC_CAMERA] = "programme", shot.id, shot.automatic
        if shot.overridden:
            strip.color_tag = OVERRIDDEN_COLOUR
    strip = new_effect(scene, "Centering", "ADJUSTMENT", plan.centering_channel, 0, plan.frames)
    strip[MARK] = "centering"
    strip.transform.filter = "BILINEAR"
    set_centering_keys(scene, plan.centering)
    for piece in plan.conformed:
        add_conformed_strip(scene, piece, plan.conformed_channel, base)
    scene[AUTOMATIC_CAMERA] = automatic_to_text(plan.automatic)
    notes = _sound(scene, plan, base)
    for strip in scene.sequence_editor.strips:
        if role_of(strip) and strip.select:  # what is new comes selected: the next key would move it all
            strip.select = False
    return notes


def add_conformed_strip(scene: Any, piece: ConformedPiece, channel: int, base: Path) -> None:
    """One file of exact pictures in its place. BlenderError when its length is not the stretch's."""
    path = base / piece.path
    strip = _movie(scene, "conformed", path, channel, piece.range.start)
    strip[MARK] = "conformed"
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
            name="sound", filepath=str(path), channel=AUDIO_CHANNEL, frame_start=piece.start + 1
        )
        strip[MARK] = "sound"
        start, stop = ends(strip)
        if strip.sound.samplerate == 0 or stop <= 0 or start >= plan.frames:
            if strip.sound.samplerate == 0:
                notes.append(f"{piece.path} has no sound")
            scene.sequence_editor.strips.remove(strip)
            continue
        if start < 0:
            before, strip = strip, split_strip(strip, 0)
            scene.sequence_editor.strips.remove(before)
        if stop > plan.frames:
            scene.sequence_editor.strips.remove(split_strip(strip, plan.frames))
    return notes


def replace_sound(scene: Any, plan: StripPlan, base: Path) -> list[str]:
    """The sound anew from ``plan``, in place of ours; the editor's own stays. Notes for a person."""
    for strip in [s for s in scene.sequence_editor.strips if role_of(s) == "sound"]:
        scene.sequence_editor.strips.remove(strip)
    return _sound(scene, plan, base)


def has_sound(scene: Any) -> bool:
    """Whether any sound strip is left that can be heard."""
    return any(s.type == "SOUND" and not s.mute for s in scene.sequence_editor.strips_all)


def _channel(scene: Any, index: int, name: str) -> None:
    scene.sequence_editor.channels[index].name = name


def _by_channel(strip: Any) -> int:
    return strip.channel
