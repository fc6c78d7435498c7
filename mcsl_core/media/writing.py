"""Writing a file: pictures and audio through FFmpeg's encoders, under its own name only when it is complete."""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Any

import av
import numpy as np
from attrs import field, frozen
from av.codec.context import Flags as CodecFlags
from av.error import FFmpegError
from numpy.typing import NDArray

from mcsl_core.errors import MediaError, UsageError, writing
from mcsl_core.imaging.planes import U8, Planes, bgr_to_planes
from mcsl_core.temporary import temporary_beside

from .banners import without_banner
from .colours import BT709, LIMITED
from .frames import frame_from_planes
from .opening import local_url
from .scheduling import scheduled_as_before

FORMATS = {".mp4": "mp4", ".m4v": "mp4", ".mov": "mov", ".mkv": "matroska"}


def muxer_options(container_format: str) -> dict[str, str]:
    """What a muxer is told: nothing that identifies or changes, and MP4s that a browser shows while they load."""
    options = {"fflags": "+bitexact"}  # no muxer version, no random ids
    return options if container_format == "matroska" else options | {"movflags": "+faststart+write_colr"}


@frozen
class Encoding:
    """How pictures and audio are coded. Names are FFmpeg's; options go to the encoder as they are.

    Attributes
    ----------
    codec, options
        The video encoder and its options.
    pixel_format
        What pictures are converted to before encoding.
    audio_codec, audio_options
        The audio encoder and its options.
    tag
        Four-character code where a player wants another than the muxer's, such as hvc1; empty for the muxer's.
    """

    codec: str = "libx264"
    options: Mapping[str, str] = field(factory=lambda: {"preset": "superfast", "crf": "20"})
    pixel_format: str = "yuv420p"
    audio_codec: str = "aac"
    audio_options: Mapping[str, str] = field(factory=lambda: {"b": "192k"})
    tag: str = ""


class VideoWriter:
    """Writes one video file with audio: constant rate from timestamp 0, BT.709 limited range, nothing that identifies.

    A context manager. The file grows under a hidden name beside ``path`` and takes its own name on a clean exit; on an
    exception nothing is left.

    Parameters
    ----------
    path
        Ends in .mp4, .m4v, .mov or .mkv.
    size
        (width, height), even.
    rate
        Frames per second.
    encoding
        How to code; `Encoding`'s defaults without.
    keyframe_interval
        Most frames from one keyframe to the next; the encoder's own without.
    audio_rate
        Samples per second; None for a file without audio.
    audio_channels
        1 or 2.

    Raises
    ------
    UsageError
        For a size, codec or format that cannot be written.
    InputError
        Where the folder cannot be written to.
    MediaError
        When the encoder fails.

    Notes
    -----
    The same input gives the same bytes on the same machine. Pictures and audio are handed over in time order, each for
    itself; which comes first does not matter.

    Examples
    --------
    >>> with VideoWriter("out.mp4", size=(1920, 1080), rate=Fraction(25)) as writer:  # doctest: +SKIP
    ...     for picture in pictures:
    ...         writer.write(picture)
    """

    def __init__(
        self,
        path: str | Path,
        *,
        size: tuple[int, int],
        rate: Fraction,
        encoding: Encoding | None = None,
        keyframe_interval: int | None = None,
        audio_rate: int | None = None,
        audio_channels: int = 1,
    ) -> None:
        self.path = Path(path)
        self.size, self.rate, self.encoding = size, Fraction(rate), encoding or Encoding()
        self.frames = 0
        self.samples = 0
        self._tags = BT709, BT709, BT709  # primaries, transfer, matrix
        self._keyframe_interval, self._audio_rate, self._channels = keyframe_interval, audio_rate, audio_channels
        if self.path.suffix.lower() not in FORMATS:
            raise UsageError(
                f"cannot write a {self.path.suffix or 'nameless'} file",
                where=str(self.path),
                remedy=f"Choose a name that ends in {', '.join(FORMATS)}",
            )
        if min(size) <= 0 or size[0] % 2 or size[1] % 2:
            raise UsageError(
                f"a video's size is even and positive, got {size[0]}x{size[1]}",
                where=str(self.path),
                remedy="Choose an even size",
            )
        if audio_channels not in (1, 2):
            raise UsageError(f"sound has 1 or 2 channels, got {audio_channels}", where=str(self.path))

    def __enter__(self) -> VideoWriter:
        with writing(self.path):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._part = temporary_beside(self.path)
            self._part.touch(exist_ok=False)  # obeys the umask
        try:
            self._open()
        except BaseException:
            self._part.unlink(missing_ok=True)
            raise
        return self

    def _open(self) -> None:
        kind = FORMATS[self.path.suffix.lower()]
        self._container = av.open(local_url(self._part), "w", format=kind, container_options=muxer_options(kind))
        try:
            self._video = self._add_video()
            self._audio = self._add_audio() if self._audio_rate else None
            with scheduled_as_before():
                self._container.start_encoding()
            self._check_options()
        except (FFmpegError, ValueError) as error:
            with contextlib.suppress(OSError):
                self._container.close()
            self._tell_of_the_disk(error)
            raise UsageError(
                f"cannot encode with {self.encoding.codec} as {self.encoding.pixel_format} ({error})",
                where=str(self.path),
                remedy="Choose a codec, pixel format and options that this FFmpeg and the container know",
            ) from error

    def _check_options(self) -> None:
        """ValueError for options that an encoder left alone: FFmpeg passes over what it does not know."""
        for stream in (self._video, self._audio):
            if stream is not None and stream.codec_context.options:
                names = ", ".join(map(repr, stream.codec_context.options))
                raise ValueError(f"{stream.codec_context.name} knows no option {names}")

    def _add_video(self) -> Any:
        encoding = self.encoding
        _check_kind(encoding.codec, "video")
        stream: Any = self._container.add_stream(encoding.codec, rate=self.rate, options=_quiet(encoding))
        context = stream.codec_context
        context.width, context.height = self.size
        context.pix_fmt = encoding.pixel_format
        context.time_base = stream.time_base = 1 / self.rate
        context.sample_aspect_ratio = Fraction(1)
        context.color_primaries, context.color_trc, context.colorspace = self._tags
        context.color_range = LIMITED
        context.flags |= CodecFlags.bitexact
        if self._keyframe_interval:
            context.gop_size = self._keyframe_interval
        if encoding.tag:
            context.codec_tag = encoding.tag
        return stream

    def _add_audio(self) -> Any:
        layout = "mono" if self._channels == 1 else "stereo"
        _check_kind(self.encoding.audio_codec, "audio")
        stream: Any = self._container.add_stream(
            self.encoding.audio_codec,
            rate=self._audio_rate,
            layout=layout,
            options=dict(self.encoding.audio_options),
        )
        stream.codec_context.flags |= CodecFlags.bitexact
        return stream

    def write(self, picture: U8 | Planes) -> None:
        """Appends one picture of the file's size: planes, or (H, W, 3) BGR."""
        planes = picture if isinstance(picture, Planes) else bgr_to_planes(picture)
        if planes.size != self.size:
            raise ValueError(f"a picture of {planes.size} for a file of {self.size}")
        frame = self._frame(planes)
        frame.pts, frame.time_base = self.frames, 1 / self.rate
        self._mux(self._video, frame)
        self.frames += 1

    def _frame(self, planes: Planes) -> Any:
        frame = frame_from_planes(planes)
        if self.encoding.pixel_format != "yuv420p":
            frame = frame.reformat(format=self.encoding.pixel_format, src_colorspace="ITU709", dst_colorspace="ITU709")
        return frame

    def leave_out(self) -> None:
        """Writes no picture: the one before is shown for one more frame."""
        self.frames += 1

    def write_audio(self, samples: NDArray[np.float32]) -> None:
        """Appends audio.

        Parameters
        ----------
        samples
            (n, channels), or (n,) for one channel, in -1..1.
        """
        if self._audio is None:
            raise ValueError("this file was opened without sound")
        samples = np.asarray(samples, np.float32)
        if samples.ndim == 1:
            samples = samples[:, None]
        if samples.shape[1] != self._channels:
            raise ValueError(f"sound of {samples.shape[1]} channels for a file of {self._channels}")
        second = self._audio_rate or 1
        for start in range(0, len(samples), second):  # by the second, so that no single frame grows large
            piece = np.ascontiguousarray(samples[start : start + second]).reshape(1, -1)
            frame = av.AudioFrame.from_ndarray(piece, format="flt", layout="mono" if self._channels == 1 else "stereo")
            frame.sample_rate = second
            frame.pts, frame.time_base = self.samples, Fraction(1, second)
            self._mux(self._audio, frame)
            self.samples += piece.size // self._channels

    def _mux(self, stream: Any, frame: Any) -> None:
        try:
            for packet in stream.encode(frame):
                clean = without_banner(packet, stream.codec_context.name, prefixed=False)
                clean.stream = stream
                self._container.mux(clean)
        except (FFmpegError, OSError) as error:
            self._tell_of_the_disk(error)
            raise MediaError(
                f"writing failed after {self.frames} frames ({error})",
                where=str(self.path),
                remedy="Choose other encoder settings",
            ) from error

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                if not self.frames:
                    raise MediaError("no picture was written", where=str(self.path), remedy="Choose a longer range")
                self._mux(self._video, None)
                if self._audio is not None:
                    self._mux(self._audio, None)
            self._close()
            if kind is None:
                self._rename()
        finally:
            self._part.unlink(missing_ok=True)

    def _close(self) -> None:
        try:
            self._container.close()
        except (FFmpegError, OSError) as error:
            self._tell_of_the_disk(error)
            raise MediaError(
                f"the file could not be finished ({error})",
                where=str(self.path),
                remedy="Check whether the disk is full",
            ) from error

    def _tell_of_the_disk(self, error: Exception) -> None:
        """Raises what people can do, where it is the disk's fault; FFmpeg's errors name the hidden file."""
        number = getattr(error, "errno", None)
        if number in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO):
            with writing(self.path):
                raise OSError(number, os.strerror(number)) from error

    def _rename(self) -> None:
        with self._part.open("rb+") as stream:  # a power cut must not leave a name without its content
            os.fsync(stream.fileno())
        self._part.replace(self.path)


def _check_kind(codec: str, kind: str) -> None:
    """ValueError where FFmpeg has no such encoder; of another kind it fails in ways of its own."""
    try:
        found = av.Codec(codec, "w").type
    except ValueError:
        raise ValueError(f"there is no encoder {codec!r}") from None
    if found != kind:
        raise ValueError(f"{codec} is no {kind} encoder")


def _quiet(encoding: Encoding) -> dict[str, str]:
    """The encoder's options, with which it does not write down what it is and what it was told."""
    options = dict(encoding.options)
    if encoding.codec == "libx265":
        options["x265-params"] = ":".join(filter(None, (options.get("x265-params"), "info=0")))
    if encoding.codec == "prores_ks":
        options.setdefault("vendor", "apl0")
    return options
