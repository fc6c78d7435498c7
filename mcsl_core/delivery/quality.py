"""How well programme pictures are conformed: encoder, groups and resampling, under names that an editor chooses from.

Measured on one core at 1920x1080, 30 frames a second (docs/decisions/007-conform.md): x264's `ultrafast` reaches the
PSNR of `superfast` at the same size, codes in less than half the time, decodes in a third (no CABAC, no loop filter),
which is what scrubbing waits for, and spreads its error evenly: its worst block is half as far off. Its groups may so
be twice as long and still be scrubbed faster. There are no B-frames: decoding order is showing order, which every
player seeks right.
"""

from __future__ import annotations

from attrs import frozen

from mcsl_core.errors import UsageError
from mcsl_core.imaging.warp import Resampling
from mcsl_core.media.writing import Encoding


@frozen
class Quality:
    """One way of conforming.

    group: frames from keyframe to keyframe, what scrubbing may have to decode. bits_a_pixel: what pictures take, about.
    """

    name: str
    encoding: Encoding
    group: int
    resampling: Resampling = "linear"
    bits_a_pixel: float = 0.4


def _x264(crf: int) -> Encoding:
    return Encoding(options={"preset": "ultrafast", "crf": str(crf)})


DRAFT = Quality("draft", _x264(24), 60, bits_a_pixel=0.07)  # for the network and the laptop: 4 Mbit/s, 43 dB
STANDARD = Quality("standard", _x264(14), 30)  # visually lossless: 50 dB, no block of 16 x 16 pixels off by 1.3 codes
FINE = Quality("fine", _x264(8), 15, "lanczos", bits_a_pixel=0.8)  # sharper by its resampling, at five times the time
QUALITIES = {quality.name: quality for quality in (DRAFT, STANDARD, FINE)}  # the least first


def quality_named(name: str) -> Quality:
    """The quality of that name; UsageError where there is none."""
    if name not in QUALITIES:
        raise UsageError(f"there is no quality {name!r}", remedy=f"Take one of {', '.join(QUALITIES)}")
    return QUALITIES[name]


def as_good_as(quality: Quality) -> tuple[Quality, ...]:
    """``quality`` and those that are finer."""
    names = list(QUALITIES)
    finer = names[names.index(quality.name) + 1 :] if quality.name in names else []
    return (quality, *(QUALITIES[name] for name in finer))
