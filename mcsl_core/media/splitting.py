"""Splitting a file into parts at keyframes, as recorders do; nothing is decoded."""

from __future__ import annotations

from bisect import bisect_right
from contextlib import ExitStack
from fractions import Fraction
from pathlib import Path
from typing import Any

import av

from .opening import local_url, main_video, open_file
from .writing import FORMATS, muxer_options


def split(path: Path, length_s: Fraction, *, suffix: str, continuing: bool) -> tuple[Path, ...]:
    """Replaces a file by its parts, STEM_000 and so on; a part ends at the first keyframe ``length_s`` after its start.

    Parameters
    ----------
    path
        A file without open groups of pictures, as `VideoWriter` makes them.
    length_s
        Seconds.
    suffix
        Of the parts.
    continuing
        Whether timestamps go on from part to part; else each begins at 0.
    """
    begins = _part_begins(path, length_s)
    parts = tuple(path.with_name(f"{path.stem}_{n:03d}{suffix}") for n in range(len(begins)))
    container_format = FORMATS[suffix]
    with open_file(path) as source, ExitStack() as stack:
        streams = [main_video(source, path), *source.streams.audio]
        outputs = []
        for part in parts:
            options = muxer_options(container_format)
            out = av.open(local_url(part), "w", format=container_format, container_options=options)
            outputs.append(stack.enter_context(out))
        copies = [[out.add_stream_from_template(stream) for stream in streams] for out in outputs]
        now = 0
        for packet in source.demux(streams):
            if packet.dts is None or packet.pts is None:
                continue
            time = packet.pts * packet.time_base
            if continuing and time < 0:  # the sound's run-in, for which the muxer would shift the whole part
                continue
            if packet.stream is not streams[0]:
                number = max(0, bisect_right(begins, time) - 1)
            else:
                now = bisect_right(begins, time) - 1 if packet.is_keyframe else now
                number = now
            if not continuing:
                packet.pts -= int(begins[number] / packet.time_base)
                packet.dts -= int(begins[number] / packet.time_base)
            packet.stream = copies[number][streams.index(packet.stream)]
            outputs[number].mux(packet)
    path.unlink()
    return parts


def _part_begins(path: Path, length_s: Fraction) -> list[Fraction]:
    begins: list[Fraction] = []
    with open_file(path) as source:
        stream: Any = main_video(source, path)
        for packet in source.demux(stream):
            if packet.is_keyframe and packet.pts is not None:
                time = packet.pts * packet.time_base
                if not begins or time >= begins[-1] + length_s:
                    begins.append(time)
    return begins
