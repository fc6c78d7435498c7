"""The conformed programme as one video and one sound file, which other editors take more gladly than its chunks."""

from __future__ import annotations

import os
import shutil
from math import ceil
from pathlib import Path

from attrs import frozen

from mcsl_core.delivery.audio import AUDIO_RATE, sound_key, wav_header
from mcsl_core.delivery.chunk_keys import Chunk, media_fingerprints
from mcsl_core.delivery.quality import QUALITIES
from mcsl_core.delivery.reuse import chunks_there
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.edl import Edl
from mcsl_core.errors import InputError, writing
from mcsl_core.media.appending import append
from mcsl_core.media.probing import probe
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import footage_of

from .model import Medium

MARK = ".programme"  # in the name of what is written here: it tells the file from a camera's when it comes back


@frozen
class Conformed:
    """What was conformed of a programme: chunks that tile it, and its sound; None where it has none."""

    chunks: tuple[Path, ...]
    sound: Path | None


def conformed_of(source: ProgrammeSource, folder: Path, edl_path: Path) -> Conformed:
    """What lies in ``folder`` of the programme as it is, in the finest quality that is there whole.

    Raises
    ------
    InputError
        Where a part of it is missing.
    """
    remedy = f"Run `mcsl conform {edl_path}` first, or export --angles"
    best: tuple[Chunk, ...] = ()
    for quality in QUALITIES.values():
        found = chunks_there(source, folder, quality)
        if found and sum(len(chunk.range) for chunk in found) >= sum(len(chunk.range) for chunk in best):
            best = found
    there = sum(len(chunk.range) for chunk in best)
    if there < source.edl.frames:
        what = f"holds {there} of the programme's {source.edl.frames} frames in one quality"
        raise InputError(what, where=str(folder), remedy=remedy)
    sound = _sound(source, folder)
    if sound is not None and not sound.is_file():
        also = "" if source.audio_from is None else f" --audio {source.audio_from}"
        remedy = f"Run `mcsl conform {edl_path}{also}` first"
        raise InputError(f"lacks the sound of {source.sound_camera}", where=str(folder), remedy=remedy)
    return Conformed(tuple(folder / chunk.name for chunk in best), sound)


def _sound(source: ProgrammeSource, folder: Path) -> Path | None:
    camera = source.sound_camera
    if camera is None or not footage_of(source.edl, source.base, 1).has_sound(camera):
        return None
    content = media_fingerprints(source.edl.camera(camera), source.base)
    return folder / f"sound-{sound_key(source.edl, camera, content)}.wav"


def programme_path(out: Path) -> Path:
    """The video that is written beside ``out``: cut.fcpxml -> cut.programme.mp4."""
    return out.with_name(f"{out.stem}{MARK}.mp4")


def sound_path(out: Path) -> Path:
    """The sound that is written beside ``out``: cut.fcpxml -> cut.programme.wav."""
    return out.with_name(f"{out.stem}{MARK}.wav")


def write_programme(conformed: Conformed, path: Path, progress: Progress) -> None:
    """Joins the chunks to one video at ``path``; nothing is coded again."""
    progress.stage("Joining the conformed pictures")
    append(conformed.chunks, path)
    with path.open("rb+") as stream:  # a power cut must not leave a name without its content
        os.fsync(stream.fileno())


def write_sound(conformed: Conformed, edl: Edl, path: Path) -> None:
    """Copies the sound to ``path``, with silence after it up to the end of the last frame: none outlasts its media."""
    assert conformed.sound is not None
    samples = ceil(edl.frames / edl.rate * AUDIO_RATE)
    written = round(edl.frames / edl.rate * AUDIO_RATE)
    with conformed.sound.open("rb") as source, writing(path), path.open("wb") as target:
        source.seek(len(wav_header(written)))
        target.write(wav_header(samples))
        shutil.copyfileobj(source, target, 1 << 20)
        target.write(bytes(2 * (samples - written)))


def programme_medium(edl: Edl, path: Path) -> Medium:
    """The joined video as editors see it; what it holds is checked.

    Raises
    ------
    InputError
        Where it has not the programme's frames.
    """
    facts = probe(path)
    if facts.frames != edl.frames or facts.rate != edl.rate:
        what = f"has {facts.frames} frames at {facts.rate}, the programme {edl.frames} at {edl.rate}"
        raise InputError(what, where=str(path), remedy="Conform again")
    return Medium(path.absolute(), edl.rate, edl.frames, size=edl.size)


def sound_medium(edl: Edl, path: Path) -> Medium:
    """The sound as editors see it."""
    return Medium(path.absolute(), edl.rate, edl.frames, channels=1, audio_rate=AUDIO_RATE)
