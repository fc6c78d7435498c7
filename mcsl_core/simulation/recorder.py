"""How simulated cameras write what they film: kindly, or as recorders in theatres and phones do."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from mcsl_core.errors import UsageError
from mcsl_core.imaging.planes import Planes
from mcsl_core.media.hdr_writing import HdrWriter
from mcsl_core.media.splitting import split
from mcsl_core.media.writing import Encoding, VideoWriter

from .scenario import Scenario
from .sound import RATE

HDR = ("hlg", "pq")
_FINER = 2
"""What `ultrafast` needs in CRF to keep of what is flat all that `superfast` does, to a quarter of a decibel."""


def _hdr(instance: Recorder, _: object, value: str) -> None:
    if value not in ("", *HDR):
        raise ValueError(f"hdr must be one of {', '.join(HDR)}, got {value!r}")
    if value and instance.interlaced:
        raise ValueError("a recording is interlaced or HDR, not both")


def _split(instance: Recorder, _: object, value: float | None) -> None:
    if value is not None and not 0.5 <= value < math.inf:
        raise ValueError(f"split_s must be half a second or more, got {value:g}")
    if instance.continuing_clock and value is None:
        raise ValueError("a clock goes on over parts: give split_s, too")


@attrs.frozen(kw_only=True)
class Recorder:
    """How a recording is written.

    Attributes
    ----------
    interlaced
        Two fields a frame, the top one first, the second taken half a frame later; at the scenario's frame rate.
    hdr
        "hlg" or "pq": ten bits, BT.2020, the same picture at 203 cd/m2 for white. Empty for BT.709.
    vfr
        A quarter of the pictures is missing by chance: the one before stays until the next.
    split_s
        Seconds after which a new file begins, at a keyframe; None for one file a camera.
    continuing_clock
        Whether timestamps go on from one file to the next, as in FFmpeg's own segments; those are MKV.
    quick_coding
        Coded in 0.6 of the time and decoded in half, without B-frames, arithmetic coding and loop filter, and finer
        for it: files of 1.7 times the size, nearer to what was drawn.
    """

    interlaced: bool = False
    vfr: bool = False
    continuing_clock: bool = False
    quick_coding: bool = False
    hdr: str = attrs.field(default="", validator=_hdr)
    split_s: float | None = attrs.field(default=None, validator=_split)

    def check(self, scenario: Scenario) -> None:
        """UsageError for a scenario that cannot be written so."""
        if self.interlaced and scenario.size[1] % 4:
            raise UsageError(
                f"an interlaced picture's rows are a multiple of 4, got {scenario.size[1]}",
                remedy=f"Choose {scenario.size[0]}x{scenario.size[1] + 2}",
            )

    def file_name(self, camera: str) -> str:
        """The camera's file, or its first part."""
        if self.split_s is None:
            return f"{camera}.mp4"
        return f"{camera}_000{self._part_suffix}"

    @property
    def _part_suffix(self) -> str:
        return ".mkv" if self.continuing_clock else ".mp4"

    def writer(self, path: Path, scenario: Scenario, audio: bool) -> VideoWriter:
        """The file that a camera's pictures are written to before it is split."""
        # Cameras set keyframes by the clock, not where a head comes in.
        # As many threads as x264 is told decide on what it writes: two, whatever the machine has.
        options = {"preset": "superfast", "crf": str(scenario.crf), "sc_threshold": "0", "threads": "2"}
        if self.quick_coding:
            options |= {"preset": "ultrafast", "crf": str(max(scenario.crf - _FINER, 0))}
        settings: dict[str, Any] = {
            "size": scenario.size,
            "rate": scenario.rate,
            "keyframe_interval": max(1, round(Fraction(scenario.keyframe_s) * scenario.rate)),
            "audio_rate": RATE if audio else None,
        }
        if self.hdr:
            return HdrWriter(path, light=self.hdr, encoding=Encoding("libx264", options, "yuv420p10le"), **settings)
        if self.interlaced:
            options["x264-params"] = "tff=1"
        return VideoWriter(path, encoding=Encoding(options=options), **settings)

    def picture(self, at: Callable[[float], Planes], k: int) -> Planes:
        """Frame ``k``; ``at`` renders the camera's picture at a time in frames."""
        return woven(at(k), at(k + 0.5)) if self.interlaced else at(k)

    def missing(self, scenario: Scenario, camera: int, count: int) -> np.ndarray:
        """(count,) which frames are left out; never the first or the last."""
        chances = scenario.stream("vfr", camera).random(count)
        missing = (chances < 0.25) & self.vfr
        missing[[0, -1]] = False
        return missing

    def finish(self, path: Path) -> None:
        """Splits the file where it is to be."""
        if self.split_s is not None:
            split(path, Fraction(self.split_s), suffix=self._part_suffix, continuing=self.continuing_clock)


def woven(top: Planes, bottom: Planes) -> Planes:
    """The even rows of one picture and the odd rows of another."""

    def rows(even: np.ndarray, odd: np.ndarray) -> np.ndarray:
        both = even.copy()
        both[1::2] = odd[1::2]
        return both

    return Planes(*(rows(even, odd) for even, odd in zip(top, bottom, strict=True)))
