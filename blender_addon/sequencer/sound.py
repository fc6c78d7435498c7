# SPDX-License-Identifier: GPL-3.0-or-later
"""The sound strips: laid, and given other files with all that the editor did to them.

A spoken name that was muted must never be heard again: where an editor touched the sound, no strip of ours is made
anew. His strips get the new file and keep mute, volume, pan, keys, cuts, channel; what he took out stays out, and
where the new file cannot follow, there is silence and a word about it.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.edl import Edl
from mcsl_core.timing import FrameRange, ranges_of_spans, without

from ..core.carry_over import Place, expected_start, is_ours, parts_of, silent_now, sound_places
from ..core.strip_plan import AUDIO_CHANNEL, StripPlan, automatic_from_text, make_plan
from .compat import content_start, ends, set_content_start, set_ends
from .edit import check_there, parked, remove, split_at, split_strip
from .scene_properties import AUTOMATIC_CAMERA, MARK, SILENT, SOUND_LAID, SOUND_OF, note_placed, placed_of, role_of
from .touched import Work


def lay_sound(scene: Any, plan: StripPlan, base: Path) -> list[str]:
    """The sound strips, cut to the programme; a file without sound is a remark, not a fault."""
    notes, laid = [], []
    for piece in plan.sound:
        path = base / piece.path
        check_there(path)
        strip = scene.sequence_editor.strips.new_sound(
            name="sound", filepath=str(path), channel=AUDIO_CHANNEL, frame_start=piece.start + 1
        )
        strip[MARK] = "sound"
        strip.show_waveform = True
        note_placed(strip, piece.start, path.name)
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
        laid.append(ends(strip))
    _note_laid(scene, ranges_of_spans(laid))
    return notes


def renew_sound(scene: Any, plan: StripPlan, base: Path) -> list[str]:
    """The sound from ``plan``, in place of ours; the editor's own sound stays as it is. Notes for a person."""
    ours = our_sound(scene, plan)
    if not ours and scene.get(SILENT):
        return []
    for piece in plan.sound:
        check_there(base / piece.path)  # before anything of ours goes
    laid = laid_before(scene)
    if _is_as_laid(scene, ours, laid, plan):
        waveform = all(strip.show_waveform for strip in ours)
        for strip in ours:
            remove(scene, strip)
        notes = lay_sound(scene, plan, base)
        for strip in our_sound(scene, plan):
            strip.show_waveform = waveform
        return notes
    places = sound_places(plan)
    if not places:
        return ["you changed the sound of this timeline, so it stays: mute or delete what is not to be heard"]
    before = [ends(strip) for strip in ours]
    notes = [note for strip in ours for note in _renew(scene, strip, plan, places, base)]
    _note_laid(scene, without([*laid, *(place.range for place in places)], ()))
    if new := without(silent_now(plan, before), laid) if laid else ():
        notes.append(
            "you changed the sound of this timeline, so sound that is new in the recording stays out of it: "
            f"programme {_frames(new)}"
        )
    if not ours:
        notes.append("the recording's sound is not in this timeline any more: it stays silent")
    return notes


def choose_sound(scene: Any, plan: StripPlan, base: Path) -> list[str]:
    """The sound of ``plan``, which is another's by the editor's choice, or none. Notes for a person."""
    for piece in plan.sound:
        check_there(base / piece.path)
    if scene.get(SILENT):
        del scene[SILENT]
        _note_laid(scene, ())
    return renew_sound(scene, plan, base)


def follow_choice(scene: Any, edl: Edl, base: Path) -> list[str] | None:
    """The sound that ``edl`` takes, where another's was laid; notes for a person, None where nothing was changed.

    So it is where the EDL was changed elsewhere, and where a choice was undone here that the EDL has got already.
    """
    wanted, laid = edl.audio_from or "", scene.get(SOUND_OF)
    if laid is None or laid == wanted or scene.get(SILENT):
        return None
    notes = choose_sound(scene, make_plan(edl), base)
    scene[SOUND_OF] = wanted
    return notes


def keep_silent(scene: Any, plan: StripPlan) -> None:
    """A timeline built without sound stays so when it is brought up to date."""
    scene[SILENT] = True
    _note_laid(scene, (FrameRange(0, plan.frames),))


def our_sound(scene: Any, plan: StripPlan) -> list[Any]:
    """Our sound strips, inside meta strips too; one that plays a file of the editor's is his."""
    return [
        strip
        for strip in scene.sequence_editor.strips_all
        if role_of(strip) == "sound" and strip.type == "SOUND" and strip.sound is not None and _plays_ours(strip, plan)
    ]


def _plays_ours(strip: Any, plan: StripPlan) -> bool:
    name, placed = _file_name(strip), placed_of(strip)
    return (placed is not None and placed[1] == name) or is_ours(name, plan)


def _file_name(strip: Any) -> str:
    return Path(bpy.path.abspath(strip.sound.filepath)).name


def laid_before(scene: Any) -> tuple[FrameRange, ...]:
    """Where sound was laid when it was last laid; () where the timeline does not say so."""
    try:
        return ranges_of_spans((int(a), int(b)) for a, b in json.loads(scene.get(SOUND_LAID, "")))
    except (ValueError, TypeError):
        return ()


def _note_laid(scene: Any, ranges: tuple[FrameRange, ...]) -> None:
    scene[SOUND_LAID] = json.dumps([[piece.start, piece.stop] for piece in ranges])


def _is_as_laid(scene: Any, ours: list[Any], laid: tuple[FrameRange, ...], plan: StripPlan) -> bool:
    """Whether nobody touched the sound since it was laid."""
    top = {strip.name for strip in scene.sequence_editor.strips}
    work = Work(scene)
    if any(work.on(s) or s.channel != AUDIO_CHANNEL or s.name not in top or slip_of(s, plan) for s in ours):
        return False
    covered = ranges_of_spans(ends(strip) for strip in ours)
    if SOUND_LAID in scene:
        return covered == laid
    # A timeline that does not say where sound was laid: what is not whole may have been cut off.
    return (
        len(covered) == 1
        and covered[0].start <= max(0, *(piece.start for piece in plan.sound[:1]))
        and covered[0].stop >= _length(scene)
    )


def _length(scene: Any) -> int:
    """The frames of the programme that the timeline shows; what is longer than any where it does not say."""
    try:
        return automatic_from_text(scene.get(AUTOMATIC_CAMERA, ""))[-1][0].stop
    except (ValueError, TypeError, IndexError):
        return 1 << 31


def slip_of(strip: Any, plan: StripPlan) -> int:
    """By how many programme frames the editor moved the strip's content from where it was laid."""
    placed, name = placed_of(strip), _file_name(strip)
    laid = placed[0] if placed is not None and placed[1] == name else expected_start(name, plan)
    return 0 if laid is None else content_start(strip) - laid


def _renew(scene: Any, strip: Any, plan: StripPlan, places: tuple[Place, ...], base: Path) -> Iterator[str]:
    """Gives ``strip`` the new files; yields what there is to say."""
    slip, name = slip_of(strip, plan), strip.name
    start, stop = ends(strip)
    parts = parts_of(start, stop, places, slip)
    laid = [(base / p.place.path, p.place.start + slip) for p in parts if p.place is not None]
    stays = len(laid) == len(parts) and all(start == content_start(strip) for _, start in laid)
    if stays and all(path == _path(strip) for path, _ in laid):
        return
    in_meta = strip.parent_meta() is not None
    if stays and len(parts) == 1 and in_meta:  # in a meta strip Blender can neither be told a length nor move safely
        strip.sound = bpy.data.sounds.load(str(laid[0][0]), check_existing=True)
        note_placed(strip, laid[0][1] - slip, laid[0][0].name)
        return
    if in_meta or len(getattr(strip, "retiming_keys", ())):
        strip.mute = True
        what, undo = ("in a meta strip", "separate that") if in_meta else ("retimed", "take the retiming away")
        yield (
            f"sound strip {name!r} (frame {start + 1}) is {what}, where it cannot follow new sound: it is muted now; "
            f"{undo} and unmute it to hear it"
        )
        return
    for piece, part in zip(split_at(strip, [part.stop for part in parts[:-1]]), parts, strict=True):
        if part.place is None or not _link(scene, piece, base / part.place.path, part.place.start, slip):
            remove(scene, piece)
            if part.stop > 0 and part.start < plan.frames:
                yield f"sound strip {name!r} has no sound any more in frames {part.start + 1} to {part.stop}"


def _path(strip: Any) -> Path:
    return Path(bpy.path.abspath(strip.sound.filepath))


def _link(scene: Any, strip: Any, path: Path, start: int, slip: int) -> bool:
    """The strip plays ``path``, laid at programme frame ``start``, over the same frames as before; False: no sound."""
    sound = bpy.data.sounds.load(str(path), check_existing=True)
    if sound.samplerate == 0:
        return False
    span = ends(strip)
    sound.use_mono = sound.use_mono or strip.sound.use_mono
    with parked(scene, strip):
        strip.sound = sound
        for other in scene.sequence_editor.strips_all:
            other.select = other == strip
        bpy.ops.sequencer.reload(adjust_length=True)  # the only way to tell Blender the new file's length
        set_content_start(strip, start + slip)
        set_ends(strip, *span)
    note_placed(strip, start, path.name)
    return True


def _frames(pieces: tuple[FrameRange, ...]) -> str:
    return "frames " + ", ".join(f"{piece.start + 1} to {piece.stop}" for piece in pieces)


def has_sound(scene: Any) -> bool:
    """Whether any sound strip is left that can be heard."""
    return any(s.type == "SOUND" and not s.mute for s in scene.sequence_editor.strips_all)
