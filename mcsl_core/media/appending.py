"""Files that follow each other written as one; nothing is coded again."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack
from fractions import Fraction
from heapq import merge
from pathlib import Path
from typing import Any

import av
from av.error import FFmpegError

from mcsl_core.errors import InputError, MediaError

from .banners import without_banner
from .opening import local_url, main_video, open_file
from .stripping import copied
from .writing import FORMATS, muxer_options

_Timed = tuple[Fraction, int, Any]


def append(
    pieces: Sequence[Path], out: Path, *, sound: Path | None = None, lengths: Sequence[int] | None = None
) -> int:
    """Writes the pictures of ``pieces`` one after another into ``out``, with the sound of ``sound`` beside them.

    Parameters
    ----------
    pieces : sequence of Path
        Videos of one encoder and its settings, each a whole number of frames at a constant rate from time 0 on. Their
        own sound is left out: a lossy one does not end with the last picture.
    out : Path
        Another file, overwritten.
    sound : Path, optional
        A file whose first sound track ``out`` shall have, coded as it is.
    lengths : sequence of int, optional
        How many pictures each piece shall have.

    Returns
    -------
    int
        How many pictures there are.

    Raises
    ------
    InputError
        Where a piece is coded otherwise than the first, which one header cannot describe, or has not its length.
    MediaError
        Where a file cannot be read or written.
    """
    kind = FORMATS[out.suffix.lower()]
    try:
        with ExitStack() as stack:
            first = main_video(stack.enter_context(open_file(pieces[0])), pieces[0])
            options = muxer_options(kind)
            target = stack.enter_context(av.open(local_url(out), "w", format=kind, container_options=options))
            video = copied(target, first)
            frames = 0
            packets = [_pictures(pieces, lengths, first)]
            streams = [video]
            if sound is not None:
                source = stack.enter_context(open_file(sound))
                streams.append(_sound_of(target, source.streams.audio[0]))
                packets.append(_sound(source))
            for _, which, packet in merge(*packets, key=lambda timed: timed[:2]):
                frames += which == 0
                packet.stream = streams[which]
                target.mux(packet)
            return frames
    except (FFmpegError, OSError, IndexError) as error:
        what = f"the pieces could not be joined ({error})"
        raise MediaError(what, where=str(out), remedy="Check whether the disk is full, and the pieces whole") from error


def _pictures(pieces: Sequence[Path], lengths: Sequence[int] | None, first: Any) -> Iterator[_Timed]:
    """(time of decoding, 0, packet): each piece begins where the pictures before it end."""
    like, rate, before = _coding(first), first.average_rate, 0
    for path, length in zip(pieces, lengths or [None] * len(pieces), strict=True):
        with open_file(path) as source:
            stream = main_video(source, path)
            if _coding(stream) != like:
                raise InputError("is coded otherwise than the first piece", where=str(path), remedy="Render it again")
            tick, start = stream.time_base, before
            offset = round(Fraction(before) / rate / tick)
            for packet, decoded_at in _with_decoding_times(source.demux(stream), 1 / rate / tick):
                clean = without_banner(packet, stream.codec_context.name, prefixed=True)
                clean.pts, clean.dts = packet.pts + offset, decoded_at + offset
                before += 1
                yield clean.dts * tick, 0, clean
            if length is not None and before - start != length:
                what = f"holds {before - start} pictures where its name says {length}"
                raise InputError(what, where=str(path), remedy="Render it again")


def _with_decoding_times(packets: Iterable[Any], frame: Fraction) -> Iterator[tuple[Any, int]]:
    """Packets, and when each is decoded, in ticks; ``frame``: ticks from one picture to the next.

    Matroska leaves it open for the first of pictures that are not shown in the order in which they are coded.
    """
    waiting: list[Any] = []
    for packet in packets:
        if not packet.size:  # the last are dummies
            continue
        waiting.append(packet)
        if packet.dts is not None:
            last = len(waiting) - 1
            yield from ((each, packet.dts - round((last - n) * frame)) for n, each in enumerate(waiting))
            waiting = []
    yield from ((packet, packet.pts) for packet in waiting)


def _sound(source: Any) -> Iterator[_Timed]:
    stream = source.streams.audio[0]
    for packet in source.demux(stream):
        if packet.size:
            yield packet.pts * stream.time_base, 1, packet


def _sound_of(target: Any, stream: Any) -> Any:
    """A stream for the sound's packets; plain samples carry a word of their container's that others do not know."""
    if not stream.codec_context.name.startswith("pcm_"):
        return copied(target, stream)
    context = stream.codec_context
    made = target.add_stream(context.name, rate=context.sample_rate)
    made.codec_context.layout = context.layout
    return made


def _coding(stream: Any) -> tuple[Any, ...]:
    context = stream.codec_context
    return context.name, context.width, context.height, context.pix_fmt, context.extradata, stream.average_rate
