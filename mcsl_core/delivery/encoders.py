"""Which encoder a preset's video is written with: the machine's own where it was asked for and works."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np
from attrs import evolve

from mcsl_core.edl import Edl
from mcsl_core.errors import McslError
from mcsl_core.media.hardware import AUTO, ENCODERS, NONE
from mcsl_core.media.writing import Encoding, VideoWriter
from mcsl_core.progress import Progress
from mcsl_core.temporary import temporary_folder

from .presets import Preset


def encoding_of(preset: Preset, hwaccel: str, edl: Edl, progress: Progress) -> Encoding:
    """A preset's direct half as the video writer takes it.

    Parameters
    ----------
    preset
        What is delivered.
    hwaccel
        ``none``, ``auto`` or a kind of hardware as FFmpeg names it: the first of the preset's hardware encoders of that
        kind that codes a picture here is taken.
    edl
        Its rate and size are what an encoder has to take.
    progress
        Is told which encoder it is, where hardware was asked for.
    """
    direct = preset.direct
    software = Encoding(
        codec=direct.codec,
        options=direct.options,
        pixel_format=direct.pixel_format,
        audio_codec=direct.audio_codec,
        audio_options=direct.audio_options,
        tag=direct.tag,
    )
    if hwaccel == NONE:
        return software
    for encoding in _of_hardware(preset, hwaccel, software):
        if _works(encoding, preset.scaled(edl.size), edl.rate):
            progress.note(f"hardware ({encoding.codec}) encodes the video")
            return encoding
    progress.note(f"no hardware ({hwaccel}) here encodes this preset; {software.codec} does, on the processor")
    return software


def _of_hardware(preset: Preset, hwaccel: str, software: Encoding) -> Iterator[Encoding]:
    for codec, options in preset.direct.hardware.items():
        if hwaccel == AUTO or codec.endswith(ENCODERS.get(hwaccel, hwaccel)):
            yield evolve(software, codec=codec, options=options)


def _works(encoding: Encoding, size: tuple[int, int], rate: Fraction) -> bool:
    """Whether it codes one grey picture: that FFmpeg was built with an encoder says nothing of the machine."""
    grey = np.full((size[1], size[0], 3), 128, np.uint8)
    with temporary_folder("encoder") as folder:
        try:
            with VideoWriter(folder / "one.mkv", size=size, rate=rate, encoding=evolve(encoding, tag="")) as writer:
                writer.write(grey)
        except McslError:
            return False
    return True
