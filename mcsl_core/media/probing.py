"""Facts of a file from its headers, index and packets, and from its first picture."""

from __future__ import annotations

import itertools
import logging
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
from av.error import FFmpegError

from mcsl_core.errors import MediaError

from .facts import MediaFacts, displayed_size, is_variable, nominal_rate
from .opening import main_video, open_file, stamp_of, zero_of

log = logging.getLogger(__name__)

_WHOLE_BYTES = 64 << 20  # a file without an index is scanned whole up to this size (0.1 s), else at its ends
_HEAD_PACKETS = 600


def probe(path: str | Path) -> MediaFacts:
    """Facts of a media file from its headers and packets; only its first picture is decoded.

    MediaError where it cannot be opened, holds no video, or not one picture of it can be decoded.
    """
    path = Path(path)
    with open_file(path) as container:
        stream = main_video(container, path)
        tick, zero = stream.time_base, zero_of(container)
        sound = next(iter(container.streams.audio), None)
        channels, audio_rate = (sound.channels, sound.sample_rate) if sound is not None else (0, None)
        timecode = next((s.metadata["timecode"] for s in container.streams if "timecode" in s.metadata), None)
        timecode = timecode or container.metadata.get("timecode")
        declared = stream.guessed_rate or stream.average_rate or stream.base_rate
        promised = _promised_end(container, stream, zero)
        index = [(e.timestamp, e.is_keyframe, e.pos + e.size) for e in stream.index_entries]
        first = _first_picture(container, stream, path)
        coded, pixel_format = (first.width, first.height), first.format.name
        rotation, begin = round(first.rotation / 90) * 90 % 360, (stamp_of(first) or 0) * tick
        if container.format.name == "avi":  # it has no presentation times; FFmpeg makes them up, and late with H.264
            zero = begin
        start = begin - zero
        aspect = stream.sample_aspect_ratio or Fraction(1)
        codec = stream.codec_context.name
        counted = stream.frames

    size_bytes = path.stat().st_size
    indexed = counted > 0 and len(index) >= counted
    if indexed:
        there = [entry for entry in index if entry[2] <= size_bytes] or index[:1]
        cut = len(there) < len(index)
        stamps, keys = [e[0] for e in index], sum(e[1] for e in index)
        end = _end(path, stamps[-min(len(stamps), 40)], any_frame=True) if not cut else None
        usable = (min(e[0] for e in index if e[2] > size_bytes) * tick - zero) if cut else None
        frames, whole = len(there), True
    else:
        whole = size_bytes <= _WHOLE_BYTES
        stamps, keys, end = _scan(path, None if whole else _HEAD_PACKETS)
        if not whole:
            end = _end(path, int(((promised or 0) + zero) / tick), any_frame=False) or end
        usable = end - zero if promised and end and end - zero < promised - 1 else None
        cut, frames = usable is not None, len(stamps)
    end = end - zero if end is not None else None
    times = np.sort(np.array(stamps, np.float64)) * float(tick)
    span = Fraction(max(stamps) - min(stamps)) * tick if len(stamps) > 1 else Fraction(0)
    measured = (len(stamps) - 1) / span if span else Fraction(declared or 25)
    variable = is_variable(times)
    rate = nominal_rate(Fraction(declared)) if declared and variable else nominal_rate(measured)
    end = promised if cut and promised else (end or promised or start + len(stamps) / rate)
    if not whole:
        frames = round((end - start) * rate)
    return MediaFacts(
        path=path,
        size=displayed_size(coded, aspect, rotation),
        coded_size=coded,
        rotation=rotation,
        sample_aspect=aspect,
        rate=rate,
        frames=max(1, frames),
        zero_s=zero,
        start_s=start,
        end_s=end,
        usable_s=min(usable, end) if usable is not None else end,
        tick_s=tick,
        variable_rate=variable,
        keyframe_interval_s=float(span + 1 / rate) / max(1, keys),
        codec=codec,
        pixel_format=pixel_format,
        audio_rate=audio_rate,
        audio_channels=channels,
        timecode=timecode,
        truncated=cut,
    )


def _promised_end(container: Any, stream: Any, zero: Fraction) -> Fraction | None:
    """The end of the picture in seconds as the headers have it; None where they do not say."""
    if stream.duration:
        return ((stream.start_time or 0) + stream.duration) * stream.time_base - zero
    tag = next((v for k, v in stream.metadata.items() if k.upper().startswith("DURATION")), "")
    parts = tag.split(":")
    if len(parts) == 3:
        return int(parts[0]) * 3600 + int(parts[1]) * 60 + Fraction(parts[2])
    if container.duration and not container.streams.audio:  # with sound, it may be the sound's
        return Fraction((container.start_time or 0) + container.duration, av.time_base) - zero
    return None


def _first_picture(container: Any, stream: Any, path: Path) -> Any:
    reason = "no picture in it"
    try:
        for packet in itertools.islice(container.demux(stream), 1000):
            try:
                for frame in packet.decode():
                    return frame
            except FFmpegError as error:
                reason = str(error.strerror)
    except FFmpegError as error:
        reason = str(error.strerror)
    raise MediaError(
        f"not one picture can be decoded ({reason})",
        where=str(path),
        remedy="Copy it again from the recorder, or leave it out",
    )


def _scan(path: Path, most: int | None) -> tuple[list[int], int, Fraction | None]:
    """Timestamps of the first ``most`` packets (all when None), the keyframes among them, the end as a timestamp."""
    with open_file(path) as container:
        stream = main_video(container, path)
        return _packets(container, stream, most)


def _end(path: Path, ticks: int, *, any_frame: bool) -> Fraction | None:
    """The end of the picture as a timestamp in s, from the packets after ``ticks``; None where it cannot seek there."""
    with open_file(path) as container:
        stream = main_video(container, path)
        try:
            container.seek(ticks, stream=stream, any_frame=any_frame)
        except FFmpegError:
            return None
        return _packets(container, stream, None)[2]


def _packets(container: Any, stream: Any, most: int | None) -> tuple[list[int], int, Fraction | None]:
    stamps, keys, end = [], 0, None
    try:
        for packet in itertools.islice(container.demux(stream), most):
            stamp = stamp_of(packet)
            if stamp is not None and packet.size:
                stamps.append(stamp)
                keys += packet.is_keyframe
                last = stamp + (packet.duration or 0)
                end = last if end is None else max(end, last)
    except FFmpegError as error:
        log.warning("%s: reading its packets ended early (%s)", container.name, error.strerror)
    return stamps, keys, None if end is None else end * stream.time_base
