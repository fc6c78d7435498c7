"""Films with burnt-in numbers whose bytes are damaged as disks, cards and cables do it; written without mcsl."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path

import av
from coded_video import write_coded

FRAMES, GOP = 300, 30
_OPTIONS = {
    "libx264": {"preset": "veryfast", "crf": "1", "bf": "2", "sc_threshold": "0"},
    "libx265": {"preset": "ultrafast", "crf": "1", "x265-params": "log-level=none:bframes=2"},
    "mpeg4": {"b": "8M", "qmin": "1"},
    "mpeg2video": {"b": "20M", "maxrate": "40M", "bufsize": "8M"},
    # One level of parallelism: of many threads it once stood still for ever, and once gave a packet that was refused.
    "libsvtav1": {"preset": "10", "crf": "8", "svtav1-params": "keyint=30:lp=1"},
    "libvpx-vp9": {"deadline": "realtime", "cpu-used": "8", "b": "6M", "minrate": "4M"},
}


def write_film(folder: Path, name: str, codec: str = "libx264", frames: int = FRAMES, **settings) -> Path:
    """Ten seconds at 30 frames a second, a keyframe a second, coded so finely that damage fits in."""
    settings.setdefault("options", _OPTIONS.get(codec))
    return write_coded(folder / name, range(frames), codec=codec, gop=GOP, **settings)


def place_of(path: Path, frame: int) -> int:
    """The byte at which the packet of a picture lies, by its time."""
    with av.open(str(path)) as container:
        packets = [p for p in container.demux(video=0) if p.size]
    first = min(p.pts for p in packets)
    step = 1 / (30 * packets[0].time_base)
    return next(p.pos for p in packets if round((p.pts - first) / step) == frame)


def zeros(count: int) -> Callable[[bytearray, int], None]:
    def damage(data: bytearray, at: int) -> None:
        data[at : at + count] = bytes(len(data[at : at + count]))

    return damage


def noise(count: int) -> Callable[[bytearray, int], None]:
    def damage(data: bytearray, at: int) -> None:
        data[at : at + count] = random.Random(1).randbytes(len(data[at : at + count]))

    return damage


def lost(count: int) -> Callable[[bytearray, int], None]:
    def damage(data: bytearray, at: int) -> None:
        del data[at : at + count]

    return damage


def damaged(path: Path, at: int, damage: Callable[[bytearray, int], None]) -> Path:
    """``path`` itself, with its bytes damaged from ``at`` on."""
    data = bytearray(path.read_bytes())
    damage(data, at)
    path.write_bytes(data)
    return path
