"""A finished video written anew without anything but its pictures and its sound; nothing is coded again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import av
from av.error import FFmpegError

from mcsl_core.errors import MediaError

from .banners import headers_without_banner, without_banner
from .opening import local_url, main_video, open_file
from .writing import FORMATS, muxer_options


def strip(path: Path, out: Path, *, sound: bool = True) -> None:
    """Copies the main video and the sound of ``path`` to ``out``, as they are coded, and nothing that identifies.

    Titles, times, places, time codes, chapters, data and attachments stay behind, and so does what the encoders wrote
    of themselves and of the machine.

    Parameters
    ----------
    path
        The video.
    out
        Another file, overwritten; its name ends as the video's does.
    sound
        Whether the sound comes along.

    Raises
    ------
    MediaError
        Where it cannot be read or written.
    """
    kind = FORMATS[out.suffix.lower()]
    try:
        with (
            open_file(path) as source,
            av.open(local_url(out), "w", format=kind, container_options=muxer_options(kind)) as target,
        ):
            kept = [main_video(source, path), *(source.streams.audio if sound else ())]
            streams = {stream.index: copied(target, stream) for stream in kept}
            for packet in source.demux(kept):
                if packet.size:  # the last are dummies
                    codec = packet.stream.codec_context.name
                    clean = without_banner(packet, codec, prefixed=True)
                    clean.stream = streams[packet.stream_index]
                    target.mux(clean)
    except (FFmpegError, OSError) as error:
        raise MediaError(
            f"the video could not be freed of its metadata ({error})",
            where=str(out),
            remedy="Check whether the disk is full",
        ) from error


def copied(target: Any, stream: Any) -> Any:
    """A stream of ``target`` for the packets of ``stream`` as they are, without what its encoder says of itself."""
    copy = target.add_stream_from_template(stream, opaque=True)
    copy.metadata.clear()
    context = stream.codec_context
    copy.codec_context.codec_tag = context.codec_tag
    if context.extradata:
        copy.codec_context.extradata = headers_without_banner(context.extradata, context.name)
    return copy
