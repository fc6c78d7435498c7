"""The programme's sound: one camera's, on the programme clock, from frame 0 to the programme's end.

A WAV file: its sample 0 is programme time 0 exactly and it has no priming, so Blender places it on frame 1 in sync.
"""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
import wave
from fractions import Fraction
from pathlib import Path

import numpy as np

from mcsl_core.code_keys import SOUND
from mcsl_core.edl import Edl
from mcsl_core.errors import MediaError
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage

AUDIO_RATE = 48000
_LARGEST = (1 << 32) - 4096  # a WAV file counts its bytes in 32 bits: 12 hours of mono


def sound_key(edl: Edl, camera: str, content: list[str]) -> str:
    """A hash of everything the sound depends on."""
    clock = edl.camera(camera).clock
    facts = [SOUND, AUDIO_RATE, content, clock.offset_s, clock.drift_ppm, edl.frames, str(edl.rate)]
    return hashlib.sha256(json.dumps(facts).encode()).hexdigest()[:20]


def write_wav(footage: Footage, camera: str, edl: Edl, path: Path, progress: Progress) -> None:
    """Writes the whole programme's sound, 16 bits, mono; atomically and in flat memory."""
    samples = round(Fraction(edl.frames) / edl.rate * AUDIO_RATE)
    if samples * 2 > _LARGEST:
        raise MediaError(
            "the programme is longer than a sound file can be (12 hours)",
            where=str(path),
            remedy="Analyse the recording in parts",
        )
    progress.stage("Sound", samples // AUDIO_RATE, "s")
    handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".part", dir=path.parent)
    part = Path(name)
    try:
        with os.fdopen(handle, "wb") as stream, wave.open(stream, "wb") as out:
            out.setnchannels(1)
            out.setsampwidth(2)
            out.setframerate(AUDIO_RATE)
            done = 0
            for block in footage.audio_blocks(camera, 0, Fraction(edl.frames) / edl.rate, AUDIO_RATE):
                out.writeframes(np.round(np.clip(block, -1, 1) * 32767).astype("<i2").tobytes())
                done += len(block)
                progress.advance(done // AUDIO_RATE)
        part.chmod(0o644)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
