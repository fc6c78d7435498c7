"""A small programme of two cameras whose pictures tell their numbers, for tests of what is delivered."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from coded_video import SIZE, read_number, write_coded

from mcsl_core.edl import IDENTITY, Camera, Clock, Edl, Look, Media, Pose, Shot
from mcsl_core.timing import FrameRange

FRAMES = 130
RATE = Fraction(30)
CLICK_S = 2.0
EXPECTED = [*range(50), *range(20, FRAMES - 30)]


def click_track(seconds: float, at_s: float) -> np.ndarray:
    sound = np.zeros(int(seconds * 48000), np.float32)
    start = round(at_s * 48000)
    sound[start : start + 480] = 0.7 * np.sin(2 * np.pi * 1000 * np.arange(480) / 48000)
    return sound


def write_sources(folder: Path) -> None:
    """Camera a shows n at programme frame n; b's clock began a second later, so that it shows n - 30."""
    write_coded(folder / "a.mp4", range(FRAMES), sound=click_track(FRAMES / 30, CLICK_S))
    write_coded(folder / "b.mp4", range(FRAMES), gop=40)


def make(**changes) -> Edl:
    """Camera a up to frame 50, then b, without any look."""
    cameras = (
        Camera("a", (Media("a.mp4", FRAMES),), SIZE, RATE),
        Camera("b", (Media("b.mp4", FRAMES),), SIZE, RATE, clock=Clock(offset_s=1.0)),
    )
    values = {
        "rate": RATE,
        "size": SIZE,
        "frames": FRAMES,
        "reference": "a",
        "cameras": cameras,
        "poses": (Pose(FrameRange(0, FRAMES), {"a": IDENTITY, "b": IDENTITY}),),
        "shots": (Shot(FrameRange(0, 50), "a"), Shot(FrameRange(50, FRAMES), "b")),
        "look": Look(centering=False, fill=False, colour=False),
        **changes,
    }
    return Edl(**values)


def shown(path: Path) -> list[int]:
    """The numbers in a file's pictures, and that its timestamps are 0, 1, 2 / rate."""
    with av.open(str(path)) as container:
        frames = list(container.decode(video=0))
    assert [round(f.time * 30, 3) for f in frames] == list(range(len(frames)))
    return [read_number(f.to_ndarray(format="gray")) for f in frames]
