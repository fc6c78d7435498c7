"""Videos of one kind joined into one file, nothing coded again."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
from attrs import frozen
from av.error import FFmpegError

from mcsl_core.errors import MediaError

from .opening import local_url, main_video, open_file
from .writing import FORMATS, muxer_options


@frozen
class Piece:
    """A video, and when its first picture is to be shown, in seconds."""

    path: Path
    at_s: Fraction


def concatenate(pieces: Sequence[Piece], out: Path) -> Iterator[int]:
    """Writes the pictures of ``pieces`` one after another to ``out``, as they are coded; yields how many are done.

    Parameters
    ----------
    pieces
        In order; all coded in one way by one program, each with its first picture at time 0.
    out
        Another file, overwritten; its suffix says which container.

    Raises
    ------
    MediaError
        Where one cannot be read, is coded in another way, or the file cannot be written.
    """
    kind = FORMATS[out.suffix.lower()]
    try:
        with av.open(local_url(out), "w", format=kind, container_options=muxer_options(kind)) as target:
            stream: Any = None
            coded = b""
            for done, piece in enumerate(pieces, start=1):
                with open_file(piece.path) as source:
                    video = main_video(source, piece.path)
                    extra = bytes(video.codec_context.extradata or b"")
                    if stream is None:
                        stream, coded = target.add_stream_from_template(video, opaque=True), extra
                        stream.metadata.clear()
                        stream.codec_context.codec_tag = video.codec_context.codec_tag
                    elif extra != coded:
                        raise MediaError("is coded in another way than those before it", where=str(piece.path))
                    _copy(source, video, target, stream, piece.at_s)
                yield done
    except (FFmpegError, OSError) as error:
        raise MediaError(
            f"the video could not be joined ({error})", where=str(out), remedy="Check whether the disk is full"
        ) from error


def _copy(source: Any, video: Any, target: Any, stream: Any, at_s: Fraction) -> None:
    ticks = round(at_s / video.time_base)
    for packet in source.demux(video):
        if not packet.size:  # the last is a dummy
            continue
        packet.pts += ticks
        packet.dts += ticks
        packet.stream = stream
        target.mux(packet)
