"""The programme's sound: one camera's, on the programme clock, from frame 0 to the programme's end.

A WAV file: its sample 0 is programme time 0 exactly and it has no priming, so Blender places it on frame 1 in sync.
"""

from __future__ import annotations

import hashlib
import json
import os
import struct
from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from mcsl_core.code_keys import SOUND
from mcsl_core.edl import Edl
from mcsl_core.errors import writing
from mcsl_core.fades import FADE_FRAMES, gain
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage
from mcsl_core.temporary import open_private, temporary_beside
from mcsl_core.timing import FrameRange

AUDIO_RATE = 48000


def sound_key(edl: Edl, camera: str, content: list[str]) -> str:
    """A hash of everything the sound depends on."""
    clock = edl.camera(camera).clock
    facts = [SOUND, AUDIO_RATE, content, clock.offset_s, clock.drift_ppm, edl.frames, str(edl.rate)]
    return hashlib.sha256(json.dumps(facts).encode()).hexdigest()[:20]


def delivered_sound(
    footage: Footage, camera: str, edl: Edl, pieces: Sequence[FrameRange], *, block_s: float = 1.0
) -> Iterator[NDArray[np.float32]]:
    """The sound of these programme frames one after another; where one piece ends, or begins after another, it fades.

    Parameters
    ----------
    footage, camera
        Whose sound.
    edl
        The programme.
    pieces
        Programme frames, in order.
    block_s
        Length of a block at most.

    Yields
    ------
    NDArray
        (n,) float32 in -1..1, at `AUDIO_RATE`. A piece's first sample is that of its first frame, to half a sample.
    """
    frames, given, last = 0, 0, len(pieces) - 1
    for number, piece in enumerate(pieces):
        frames += len(piece)
        count = round(Fraction(frames) / edl.rate * AUDIO_RATE) - given
        given += count
        first = round(Fraction(piece.start) / edl.rate * AUDIO_RATE)
        fade = round(FADE_FRAMES / edl.rate * AUDIO_RATE)
        at, start_s, stop_s = 0, Fraction(first, AUDIO_RATE), Fraction(first + count, AUDIO_RATE)
        for block in footage.audio_blocks(camera, start_s, stop_s, AUDIO_RATE, block_s=block_s):
            yield block * gain(at, len(block), count, fade, rises=number > 0, falls=number < last)
            at += len(block)


def is_audible(footage: Footage, camera: str | None, progress: Progress) -> bool:
    """Whether the programme has sound: none is wanted, or ``camera`` has none. What a person should know is told."""
    if camera is None:
        return False
    for note in footage.sound_track(camera).notes:
        progress.note(f"{camera}: {note}")
    if not footage.has_sound(camera):
        progress.note(f"{camera} has no sound, so the programme has none")
        return False
    return True


def write_wav(footage: Footage, camera: str, edl: Edl, path: Path, progress: Progress) -> None:
    """Writes the whole programme's sound, 16 bits, mono; atomically and in flat memory.

    Raises
    ------
    McslError
        Where the disk is full or the folder cannot be written to; nothing is left then.
    """
    samples = round(Fraction(edl.frames) / edl.rate * AUDIO_RATE)
    progress.stage("Sound", samples // AUDIO_RATE, "s")
    part = temporary_beside(path)
    with writing(path):
        file = open_private(part, "xb", buffering=0)  # an operating room speaks of people by name
    try:
        done = 0
        with file as out:
            _write(out, wav_header(samples), path)
            for block in footage.audio_blocks(camera, 0, Fraction(edl.frames) / edl.rate, AUDIO_RATE):
                _write(out, np.round(np.clip(block, -1, 1) * 32767).astype("<i2").tobytes(), path)
                done += len(block)
                progress.advance(done // AUDIO_RATE)
            with writing(path):
                os.fsync(out.fileno())  # a power cut must not leave a name without its content
        with writing(path):
            part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def _write(out: BinaryIO, data: bytes, path: Path) -> None:
    with writing(path):
        while data:  # a disk that is nearly full takes some of it
            data = data[out.write(data) :]


def wav_header(samples: int) -> bytes:
    """What stands before so many samples of 16 bits, mono; RF64 (EBU Tech 3306) beyond 4 GiB, which is 12 hours."""
    size = 2 * samples
    form = struct.pack("<4sIHHIIHH", b"fmt ", 16, 1, 1, AUDIO_RATE, 2 * AUDIO_RATE, 2, 16)
    if size + 36 < 1 << 32:
        return struct.pack("<4sI4s", b"RIFF", size + 36, b"WAVE") + form + struct.pack("<4sI", b"data", size)
    sizes = struct.pack("<4sIQQQI", b"ds64", 28, size + 72, size, samples, 0)
    unknown = (1 << 32) - 1  # it is in ds64
    return struct.pack("<4sI4s", b"RF64", unknown, b"WAVE") + sizes + form + struct.pack("<4sI", b"data", unknown)
