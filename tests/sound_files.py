"""Films with odd sound tracks, written with PyAV and by changing the bytes of what it wrote; read without mcsl."""

from __future__ import annotations

import re
import struct
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

RATE = 48000
FILM_RATE = Fraction(10)
_PARENTS = (b"moov", b"trak", b"mdia", b"minf", b"stbl")


@frozen(eq=False)
class Track:
    """A sound track: (channels, n) samples in -1..1 at ``rate``, their order, codec, and when it begins."""

    samples: NDArray
    layout: str = "mono"
    codec: str = "pcm_s16le"
    rate: int = RATE
    language: str = ""
    start_s: Fraction = Fraction(0)
    gap: tuple[int, int] | None = None  # samples that are left out of the file


def silence(seconds: float, channels: int = 1) -> NDArray:
    return np.zeros((channels, int(seconds * RATE)), np.float32)


def voice(seconds: float, seed: int = 0, level: float = 0.2, rate: int = RATE) -> NDArray:
    """(1, n): bursts of noise, as words are, with energy between 300 and 3400 Hz."""
    rng = np.random.default_rng(seed)
    count = int(seconds * rate)
    rough = np.repeat(rng.normal(0, 1, count // 8 + 1), 8)[:count]
    words = np.repeat(rng.random(int(seconds * 4) + 1) > 0.4, rate // 4)[:count]
    return (level * np.clip(rough, -2, 2) / 2 * words).astype(np.float32)[None]


def write_film(
    path: Path, tracks: Sequence[Track], seconds: float, *, size: tuple[int, int] = (64, 48), rate: Fraction = FILM_RATE
) -> Path:
    """A grey film with these sound tracks."""
    with av.open(str(path), "w") as container:
        video = container.add_stream("libx264", rate=rate, options={"preset": "ultrafast"})
        video.width, video.height, video.pix_fmt = *size, "yuv420p"
        streams = [container.add_stream(t.codec, rate=t.rate, layout=t.layout) for t in tracks]
        for stream, track in zip(streams, tracks, strict=True):
            if track.language:
                stream.metadata["language"] = track.language
        for index in range(round(seconds * rate)):
            picture = np.full((size[1], size[0], 3), 60 + index % 100, np.uint8)
            frame = av.VideoFrame.from_ndarray(picture, format="bgr24")
            frame.pts, frame.time_base = index, 1 / rate
            container.mux(video.encode(frame))
        container.mux(video.encode(None))
        for stream, track in zip(streams, tracks, strict=True):
            _write_track(container, stream, track)
    return path


def _write_track(container, stream, track: Track) -> None:
    step, first = track.rate // 10, round(track.start_s * track.rate)
    for start in range(0, track.samples.shape[1], step):
        if track.gap and track.gap[0] <= start < track.gap[1]:
            continue
        piece = np.ascontiguousarray(track.samples[:, start : start + step].T, np.float32).reshape(1, -1)
        frame = av.AudioFrame.from_ndarray(piece, format="flt", layout=track.layout)
        frame.sample_rate, frame.pts, frame.time_base = track.rate, first + start, Fraction(1, track.rate)
        container.mux(stream.encode(frame))
    container.mux(stream.encode(None))


def without_decoder(path: Path, position: int = 0) -> Path:
    """The sound track at ``position`` of an MP4 becomes Apple's spatial sound, which FFmpeg cannot decode."""
    data = path.read_bytes()
    at = [match.start() for match in re.finditer(rb"mp4a\0{6}", data)][position]
    described = data.index(b"esds", at)
    return _written(path, data[:at] + b"apac" + data[at + 4 : described] + b"dapa" + data[described + 4 :])


def with_channel_labels(path: Path, labels: Sequence[int]) -> Path:
    """The first sound track of a QuickTime file, its index at its end, says which channel is which, one by one.

    Labels are Apple's: 1 left, 2 right, 3 centre, 4 low, 5 and 6 left and right surround.
    """
    described = b"".join(struct.pack(">IIfff", label, 0, 0, 0, 0) for label in labels)
    chan = struct.pack(">IIII", 0, 0, 0, len(labels)) + described
    chan = struct.pack(">I4s", len(chan) + 8, b"chan") + chan
    data = path.read_bytes()
    assert data.index(b"moov") > data.index(b"mdat"), "places in the file must not move"
    start = data.index(b"moov") - 4
    return _written(path, data[:start] + _relabelled(data[start:], chan))


def _relabelled(boxes: bytes, chan: bytes) -> bytes:
    out = b""
    while boxes:
        size, kind = struct.unpack(">I4s", boxes[:8])
        body, boxes = boxes[8:size], boxes[size:]
        if kind in _PARENTS and (kind != b"trak" or b"soun" in body):
            body = _relabelled(body, chan)
        elif kind == b"stsd":
            body = _described(body, chan)
        out += struct.pack(">I4s", len(body) + 8, kind) + body
    return out


def _described(stsd: bytes, chan: bytes) -> bytes:
    """A sample table's description with ``chan`` in place of, or after, what its sound entry has."""
    entry = stsd[8:]
    version = struct.unpack(">H", entry[16:18])[0]
    fixed = 36 + {0: 0, 1: 16, 2: 36}[version]
    inner, kept = entry[fixed:], b""
    while len(inner) >= 8:
        size, kind = struct.unpack(">I4s", inner[:8])
        kept += inner[:size] if kind != b"chan" else b""
        inner = inner[size:]
    entry = entry[4:fixed] + kept + chan
    return stsd[:8] + struct.pack(">I", len(entry) + 4) + entry


def _written(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path
