# SPDX-License-Identifier: GPL-3.0-or-later
"""StripPlan -> the sequencer: an empty scene is filled. renew.py brings one up to date."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mcsl_core.blender.messages import ConformedPiece
from mcsl_core.errors import BlenderError
from mcsl_core.timing import FrameRange

from ..core.carry_over import Place, uncovered
from ..core.mirrored import is_mirrored
from ..core.strip_plan import (
    AUDIO_CHANNEL,
    CameraTrack,
    ProgrammeStrip,
    StripPlan,
    automatic_to_text,
    strip_name,
    tracks_key,
)
from .camera_keys import place_camera
from .centering_keys import set_centering_keys
from .compat import ends, new_effect
from .edit import check_there, set_colour, split_strip
from .marks import lay_marks
from .scene_properties import (
    AUTOMATIC_CAMERA,
    CAMERA,
    GIVEN_NAME,
    MARK,
    SHOT_ID,
    TRACKS_HASH,
    note_placed,
    role_of,
)
from .sound import lay_sound


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


def _settings(scene: Any, plan: StripPlan) -> None:
    render = scene.render
    render.fps = -(-plan.rate.numerator // plan.rate.denominator)  # rounded up, as Blender's own 30 / 1.001
    render.fps_base = float(render.fps / plan.rate)
    render.resolution_x, render.resolution_y = plan.size
    render.use_sequencer, render.use_compositing = True, False
    render.dither_intensity = 0.0
    render.use_stamp = False
    scene.frame_start, scene.frame_end, scene.frame_step = 1, plan.frames, 1
    scene.use_audio_scrub = True  # a cut is found by ear as well
    # Standard keeps 47-48 dB against the source, the default AgX 33 dB.
    scene.display_settings.display_device = "sRGB"
    colours = scene.view_settings
    colours.view_transform, colours.look, colours.exposure, colours.gamma = "Standard", "None", 0.0, 1.0
    scene.sequencer_colorspace_settings.name = "sRGB"


def _cameras(scene: Any, plan: StripPlan, base: Path) -> list[str]:
    scene[TRACKS_HASH] = tracks_key(plan.cameras)
    return [note for track in plan.cameras for note in build_camera(scene, track, base)]


def build_camera(scene: Any, track: CameraTrack, base: Path, kept: Sequence[tuple[int, int]] = ()) -> list[str]:
    """A camera's files, one movie strip each (0.15 s of opening), split at the pieces; what lies between goes.

    Where a strip in ``kept`` (as spans of frames) lies nothing is built. Returns remarks for a person.
    """
    notes = []
    name_channel(scene, track.channel, track.camera)
    for file in track.files:
        pieces = [
            (span, piece)
            for piece in file.pieces
            for span, _ in uncovered([Place(piece.range)], kept)
            if span.start < file.start + file.frames
        ]
        if not pieces:
            continue
        strip = lay_movie(scene, track.camera, base / file.path, track.channel, file.start)
        strip[MARK], strip[CAMERA] = "camera", track.camera
        set_colour(strip, track.key)
        start, stop = ends(strip)
        if stop - start != file.frames:
            notes.append(f"{track.camera}: {file.path} has {file.frames} frames, Blender counts {stop - start}")
        if is_mirrored(base / file.path):
            notes.append(
                f"{track.camera}: {file.path} is mirrored for display, which Blender does not obey: its preview "
                "shows it the wrong way round, conformed pictures are right"
            )
        pieces = [(span, piece) for span, piece in pieces if span.start < stop]
        for part, (_, piece) in zip(cut_out(scene, strip, [span for span, _ in pieces]), pieces, strict=True):
            place_camera(scene, part, piece)
    return notes


def cut_out(scene: Any, strip: Any, spans: Sequence[FrameRange]) -> list[Any]:
    """``strip`` cut to ``spans``, which are in order and begin inside it; what lies between them goes."""
    parts = []
    start, stop = ends(strip)
    for span in spans:
        if span.start > start:
            gap, strip = strip, split_strip(strip, span.start)
            scene.sequence_editor.strips.remove(gap)
        parts.append(strip)
        if span.stop >= stop:
            return parts
        strip, start = split_strip(strip, span.stop), span.stop
    scene.sequence_editor.strips.remove(strip)  # what is left lies after the last
    return parts


def lay_movie(scene: Any, name: str, path: Path, channel: int, start: int) -> Any:
    """A film's strip from programme frame ``start``. InputError or BlenderError naming a file that cannot be shown."""
    check_there(path)
    strip = scene.sequence_editor.strips.new_movie(
        name=name, filepath=str(path), channel=channel, frame_start=start + 1, fit_method="ORIGINAL"
    )
    check_readable(strip, path)
    strip.blend_type = "REPLACE"  # with ALPHA_OVER, the default, all cameras below are decoded too
    note_placed(strip, start, path.name)
    return strip


def check_readable(strip: Any, path: Path) -> None:
    """BlenderError where Blender finds no pictures in a film."""
    if not strip.elements or strip.elements[0].orig_width == 0:
        raise BlenderError("Blender cannot read it as video", where=str(path), remedy="Convert it to H.264 in MP4")


def _decided(scene: Any, plan: StripPlan, base: Path) -> list[str]:
    """Everything that follows from decisions: Programme, Centering, Conformed, sound, and the ids in the scene."""
    name_channel(scene, AUDIO_CHANNEL, "Audio")
    name_channel(scene, plan.programme_channel, "Programme")
    name_channel(scene, plan.centering_channel, "Centering")
    name_channel(scene, plan.conformed_channel, "Conformed")
    for channel in (plan.centering_channel, plan.conformed_channel):  # all others may be cut or corrected by hand
        scene.sequence_editor.channels[channel].lock = True
    for number, shot in enumerate(plan.programme, 1):
        lay_shot(scene, number, shot, plan.programme_channel)
    lay_centering(scene, plan.centering_channel, 0, plan.frames)
    set_centering_keys(scene, plan.centering)
    for piece in plan.conformed:
        add_conformed_strip(scene, piece, plan.conformed_channel, base)
    scene[AUTOMATIC_CAMERA] = automatic_to_text(plan.automatic)
    lay_marks(scene, plan.removed)
    notes = lay_sound(scene, plan, base)
    deselect(scene)
    return notes


def lay_shot(scene: Any, number: int, shot: ProgrammeStrip, channel: int, span: FrameRange | None = None) -> None:
    """The Multicam strip of a shot, or of that part of it."""
    name = strip_name(number, shot.camera, shot.key)  # a name of its own: Blender's search for a free .001 is slow
    span = span or shot.range
    strip = new_effect(scene, name, "MULTICAM", channel, span.start, span.stop)
    strip[GIVEN_NAME] = name
    set_shot(strip, shot)


def set_shot(strip: Any, shot: ProgrammeStrip) -> None:
    """A Programme strip shows ``shot``; its name and whatever an editor gave it stay."""
    strip.multicam_source = shot.source
    strip[MARK], strip[SHOT_ID], strip[AUTOMATIC_CAMERA] = "programme", shot.id, shot.automatic
    set_colour(strip, shot.key, overridden=shot.overridden)


def lay_centering(scene: Any, channel: int, start: int, stop: int) -> None:
    """The Adjustment strip that shifts what lies below it."""
    strip = new_effect(scene, "Centering", "ADJUSTMENT", channel, start, stop)
    strip[MARK] = "centering"
    strip.transform.filter = "BILINEAR"


def deselect(scene: Any) -> None:
    """What is new comes selected: the next key would move it all."""
    for strip in scene.sequence_editor.strips:
        if role_of(strip) and strip.select:
            strip.select = False


def add_conformed_strip(scene: Any, piece: ConformedPiece, channel: int, base: Path) -> Any:
    """One file of exact pictures in its place. BlenderError when its length is not the stretch's."""
    path = base / piece.path
    strip = lay_movie(scene, "conformed", path, channel, piece.range.start)
    strip[MARK] = "conformed"
    if ends(strip) != (piece.range.start, piece.range.stop):
        start, stop = ends(strip)
        raise BlenderError(
            f"has {stop - start} frames, {len(piece.range)} belong there", where=str(path), remedy="Conform again"
        )
    return strip


def name_channel(scene: Any, index: int, name: str) -> None:
    """Names a channel, for people."""
    scene.sequence_editor.channels[index].name = name
