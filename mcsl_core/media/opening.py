"""Opening a file, choosing its video stream, reading its clock: what probing, reading and audio share."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import av
from av.error import FFmpegError
from av.stream import Disposition

from mcsl_core.errors import MediaError

_RUNNING_CLOCKS = {"mpegts", "mpeg", "mpegtsraw", "asf", "rtp", "flv"}  # formats whose timestamps start anywhere
_STILLS = Disposition.attached_pic | Disposition.timed_thumbnails | Disposition.still_image


def open_file(path: Path) -> Any:
    """The container of a file, an `av` input container.

    Raises
    ------
    MediaError
        Where it cannot be opened.
    """
    try:
        return av.open(str(path), "r")
    except FFmpegError as error:
        missing = isinstance(error, FileNotFoundError | PermissionError | IsADirectoryError)
        raise MediaError(
            f"cannot be opened as a video ({error.strerror})",
            where=str(path),
            remedy="Check the path and its permissions"
            if missing
            else "It may be cut short or no video: copy it again from the recorder, or leave it out",
        ) from error


def main_video(container: Any, path: Path) -> Any:
    """The largest video stream that is no cover picture, thumbnail or still.

    Raises
    ------
    MediaError
        Where there is none.
    """
    streams = [s for s in container.streams.video if s.codec_context and not s.disposition & _STILLS]
    if not streams:
        raise MediaError("holds no video", where=str(path), remedy="Leave it out, or hand in the camera's video file")
    return max(streams, key=lambda s: (s.width * s.height, -s.index))


def time_origin_of(container: Any) -> Fraction:
    """The timestamp in seconds at which the file's own time is 0 (see `MediaFacts`)."""
    if not _RUNNING_CLOCKS & set(container.format.name.split(",")):
        return Fraction(0)
    streams = [*container.streams.video, *container.streams.audio]
    return min((s.start_time * s.time_base for s in streams if s.start_time is not None), default=Fraction(0))


def timestamp_of(item: Any) -> int | None:
    """The presentation timestamp of a packet or frame in ticks; the decoding one where a format has no other (AVI)."""
    return item.pts if item.pts is not None else item.dts
