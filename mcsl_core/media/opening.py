"""Opening a file, choosing its video stream, reading its clock: what probing, reading and audio share."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import av
from av.codec.hwaccel import HWAccel
from av.error import ArgumentError, FFmpegError, InvalidDataError
from av.format import Flags
from av.stream import Disposition

from mcsl_core.edl.playlists import list_kind
from mcsl_core.errors import MediaError

from .hardware import NONE, accelerations

_RUNNING_CLOCKS = {"mpegts", "mpeg", "mpegtsraw", "asf", "rtp", "flv"}  # formats whose timestamps start anywhere
# Containers and streams that hold their pictures and sound themselves. FFmpeg knows 300 more; among them are lists that
# lead to other files or hosts (concat, hls, dash, sdp, imf), numbered pictures, and devices.
_CONTAINERS = (
    "mov,mp4,matroska,webm,avi,mpegts,mpegtsraw,mpeg,mxf,asf,flv,live_flv,dv,ogg,nut,gxf,wtv,rm,lxf,nsv,dhav,ifv"
)
_STREAMS = "ivf,mpegvideo,m4v,h263,h264,hevc,vvc,evc,av1,obu,vc1,mjpeg,yuv4mpegpipe,cavsvideo,dirac,dnxhd"
_SOUNDS = "wav,w64,aac,ac3,eac3,mp3,flac,caf,aiff,au"
_OPENED = {"protocol_whitelist": "file", "format_whitelist": f"{_CONTAINERS},{_STREAMS},{_SOUNDS}"}
_LATEST_START_S = 10  # what starts later is no late start: its clock went on from an earlier file, or from midnight
_STILLS = Disposition.attached_pic | Disposition.timed_thumbnails | Disposition.still_image


def local_url(path: Path) -> str:
    """What FFmpeg must be handed to take ``path`` for a local file, whatever its name holds.

    A relative name with a colon is a protocol to it: a folder called ``http:``, or a recording of ``12:30:01.mp4``.
    """
    return f"file:{path.absolute()}"


def open_file(path: Path, *, hwaccel: str = NONE) -> Any:
    """The container of a file, an `av` input container.

    Only a local, regular file is opened, and nothing that it refers to: no playlist is followed, no network reached.

    Parameters
    ----------
    path
        The file.
    hwaccel
        Which hardware decodes its pictures, as `hardware` names it; where there is none for them, the processor does.

    Raises
    ------
    MediaError
        Where it cannot be opened.
    """
    if path.exists() and not path.is_file() and not path.is_dir():
        raise MediaError(
            "is no regular file but a device, pipe or socket",
            where=str(path),
            remedy="Hand in the camera's video file",
        )
    for acceleration in accelerations(hwaccel):
        if (container := _accelerated(path, acceleration)) is not None:
            return container
    try:
        return av.open(local_url(path), "r", container_options=_OPENED)
    except FFmpegError as error:
        refused = isinstance(error, ArgumentError | InvalidDataError)
        if refused and (kind := list_kind(path)):
            raise MediaError(
                f"is {kind}; what it leads to is not opened",
                where=str(path),
                remedy="Hand in the camera's video file itself",
            ) from error
        if isinstance(error, ArgumentError):
            raise MediaError(
                "is no video file of a kind that is opened",
                where=str(path),
                remedy="Convert it to MP4, MOV or MKV, or leave it out",
            ) from error
        missing = isinstance(error, FileNotFoundError | PermissionError | IsADirectoryError)
        raise MediaError(
            f"cannot be opened as a video ({error.strerror})",
            where=str(path),
            remedy="Check the path and its permissions"
            if missing
            else "It may be cut short or no video: copy it again from the recorder, or leave it out",
        ) from error


def _accelerated(path: Path, acceleration: HWAccel) -> Any | None:
    """The container of a file whose pictures this hardware decodes; None where it does not, or the file is wrong."""
    try:
        container = av.open(local_url(path), "r", container_options=_OPENED, hwaccel=acceleration)
    except FFmpegError:  # without hardware it is told what is wrong with the file
        return None
    if any(is_accelerated(stream) for stream in container.streams.video):
        return container
    container.close()
    return None


def is_accelerated(stream: Any) -> bool:
    """Whether hardware decodes a video stream."""
    return stream.codec_context is not None and stream.codec_context.is_hwaccel


def main_video(container: Any, path: Path) -> Any:
    """The largest video stream that is no cover picture, thumbnail or still: of several, none of a single picture.

    Raises
    ------
    MediaError
        Where there is none.
    """
    streams = [s for s in container.streams.video if s.codec_context and not s.disposition & _STILLS]
    if not streams:
        raise MediaError("holds no video", where=str(path), remedy="Leave it out, or hand in the camera's video file")
    return max(streams, key=lambda s: (not _is_single(s), s.width * s.height, -s.index))


def _is_single(stream: Any) -> bool:
    """Whether the headers count one picture in a stream; some recorders keep their thumbnail as a track of its own."""
    counted = {str(stream.frames), *(v for k, v in stream.metadata.items() if k.upper().startswith("NUMBER_OF_FRAMES"))}
    hours, _, rest = next((v for k, v in stream.metadata.items() if k.upper() == "DURATION"), "").partition(":")
    return "1" in counted or (hours == "00" and rest.startswith("00:00.0"))


def time_origin_of(container: Any) -> Fraction:
    """The timestamp in seconds at which the file's own time is 0 (see `MediaFacts`)."""
    streams = [s for s in (*container.streams.video, *container.streams.audio) if s.start_time is not None]
    earliest = min((s.start_time * s.time_base for s in streams), default=Fraction(0))
    if _RUNNING_CLOCKS & set(container.format.name.split(",")) or earliest > _LATEST_START_S:
        return earliest
    # Muxers without negative timestamps shift all streams by the delay of reordered pictures, two of them at most.
    rates = [s.guessed_rate for s in container.streams.video if s.guessed_rate]
    return earliest if rates and 0 < earliest <= 2 / min(rates) else Fraction(0)


def refuse_raw(container: Any, path: Path) -> None:
    """MediaError for a raw stream: its pictures have no timestamps, and it cannot be seeked in."""
    if container.format.flags & Flags.no_timestamps.value:
        raise MediaError(
            f"is a raw {container.format.name} stream, whose pictures have no timestamps",
            where=str(path),
            remedy=f"Put it into a container with its rate, for example: mkvmerge -o {path.stem}.mkv "
            f"--default-duration 0:25fps {path.name}",
        )


def timestamp_of(item: Any) -> int | None:
    """The presentation timestamp of a packet or frame in ticks; the decoding one where a format has no other (AVI)."""
    return item.pts if item.pts is not None else item.dts
