"""Media files in and out: the only module that imports av (PyAV, FFmpeg's libraries).

Pictures are BGR (H, W, 3) uint8 or `Planes` (4:2:0, BT.709 limited). Sound is float32 (n, channels) in -1..1.
Times of a file are Fractions of a second as its timestamps give them; presentation timestamps are the authority.
"""

from __future__ import annotations

import itertools
import logging
import os
import tempfile
import threading
from collections.abc import Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Any

import av
import numpy as np
from attrs import field, frozen
from av.codec.context import Flags as CodecFlags
from av.error import FFmpegError
from av.stream import Disposition
from av.video.reformatter import Colorspace, VideoReformatter
from numpy.typing import NDArray

from .errors import InputError, MediaError, UsageError
from .images import U8, Planes, bgr_to_planes, resize_planes, turn_planes
from .media import MediaFacts, displayed_size, is_variable, nominal_rate

log = logging.getLogger(__name__)

_FORMATS = {".mp4": "mp4", ".m4v": "mp4", ".mov": "mov", ".mkv": "matroska"}
_BT709 = 1  # the same number for primaries, transfer and matrix in ITU-T H.273
_LIMITED = 1  # AVCOL_RANGE_MPEG

_BT601 = (5, 6)  # BT.470BG, SMPTE 170M
_BT2020 = (9, 10)
_FULL = 2  # AVCOL_RANGE_JPEG
_RUNNING_CLOCKS = {"mpegts", "mpeg", "mpegtsraw", "asf", "rtp", "flv"}  # formats whose timestamps start anywhere
_WHOLE_BYTES = 64 << 20  # a file without an index is scanned whole up to this size (0.1 s), else at its ends
_HEAD_PACKETS = 600
_STILLS = Disposition.attached_pic | Disposition.timed_thumbnails | Disposition.still_image
_per_thread = threading.local()

# ------------------------------------------------------------------------------------------------------- reading


def _open(path: Path) -> Any:
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


def _main_video(container: Any, path: Path) -> Any:
    """The film among the video streams: cover pictures, thumbnails and stills are not it."""
    films = [s for s in container.streams.video if s.codec_context and not s.disposition & _STILLS]
    if not films:
        raise MediaError("holds no video", where=str(path), remedy="Leave it out, or hand in the camera's video file")
    return max(films, key=lambda s: (s.width * s.height, -s.index))


def _zero(container: Any) -> Fraction:
    """The timestamp in seconds at which the file's own time is 0 (see `MediaFacts`)."""
    if not _RUNNING_CLOCKS & set(container.format.name.split(",")):
        return Fraction(0)
    streams = [*container.streams.video, *container.streams.audio]
    return min((s.start_time * s.time_base for s in streams if s.start_time is not None), default=Fraction(0))


def _stamp(item: Any) -> int | None:
    """The presentation timestamp of a packet or frame in ticks; the decoding one where a format has no other (AVI)."""
    return item.pts if item.pts is not None else item.dts


def probe(path: str | Path) -> MediaFacts:
    """Facts of a media file from its headers and packets; only its first picture is decoded.

    MediaError where it cannot be opened, holds no video, or not one picture of it can be decoded.
    """
    path = Path(path)
    with _open(path) as container:
        stream = _main_video(container, path)
        tick, zero = stream.time_base, _zero(container)
        sound = next(iter(container.streams.audio), None)
        channels, audio_rate = (sound.channels, sound.sample_rate) if sound is not None else (0, None)
        timecode = next((s.metadata["timecode"] for s in container.streams if "timecode" in s.metadata), None)
        timecode = timecode or container.metadata.get("timecode")
        declared = stream.guessed_rate or stream.average_rate or stream.base_rate
        promised = _promised_end(container, stream, zero)
        index = [(e.timestamp, e.is_keyframe, e.pos + e.size) for e in stream.index_entries]
        first = _first_picture(container, stream, path)
        coded, pixel_format = (first.width, first.height), first.format.name
        rotation, begin = round(first.rotation / 90) * 90 % 360, (_stamp(first) or 0) * tick
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
    with _open(path) as container:
        stream = _main_video(container, path)
        return _packets(container, stream, most)


def _end(path: Path, ticks: int, *, any_frame: bool) -> Fraction | None:
    """The end of the picture as a timestamp in s, from the packets after ``ticks``; None where it cannot seek there."""
    with _open(path) as container:
        stream = _main_video(container, path)
        try:
            container.seek(ticks, stream=stream, any_frame=any_frame)
        except FFmpegError:
            return None
        return _packets(container, stream, None)[2]


def _packets(container: Any, stream: Any, most: int | None) -> tuple[list[int], int, Fraction | None]:
    stamps, keys, end = [], 0, None
    try:
        for packet in itertools.islice(container.demux(stream), most):
            stamp = _stamp(packet)
            if stamp is not None and packet.size:
                stamps.append(stamp)
                keys += packet.is_keyframe
                last = stamp + (packet.duration or 0)
                end = last if end is None else max(end, last)
    except FFmpegError as error:
        log.warning("%s: reading its packets ended early (%s)", container.name, error.strerror)
    return stamps, keys, None if end is None else end * stream.time_base


class VideoReader:
    """Decodes the pictures of one file in presentation order, from any time on. Not for use by two threads at once.

    threads: decoder threads, 0 for as many as the machine has cores. skip: what the decoder may leave out ("NONREF":
    pictures that no other needs, "NONKEY": all but keyframes). Frames are av frames; `to_planes` makes them pictures.
    """

    def __init__(self, facts: MediaFacts, *, threads: int = 0, skip: str = "") -> None:
        self.facts, self._threads, self._skip = facts, threads, skip
        self._keys: list[int] = []
        self._reopen()

    def _reopen(self) -> None:
        self._container = _open(self.facts.path)
        self._stream = _main_video(self._container, self.facts.path)
        context = self._stream.codec_context
        context.thread_count = self._threads
        context.thread_type = "AUTO" if self._threads != 1 else "SLICE"
        if self._skip:
            context.skip_frame = self._skip
        self._fresh = True

    def close(self) -> None:
        self._container.close()

    def read(self, from_s: Fraction) -> Iterator[tuple[Fraction, Any]]:
        """(time in seconds, frame) from the picture shown at ``from_s`` on; times rise.

        Seeking goes to a keyframe before and decodes forward. Containers seek by decoding time, which with B-frames
        can land on a keyframe that is shown later than asked: then it goes back further.
        """
        goal, back = from_s + self.facts.tolerance_s, Fraction(0)
        while True:
            target = goal - back
            at_start = target <= self.facts.start_s or not self._seek(target)
            if at_start and not self._fresh:
                self.close()
                self._reopen()
            pictures = self._decoded()
            held = next(pictures, None)
            if at_start or (held is not None and held[0] <= goal):
                break
            back = max(back * 2, Fraction(1))
        if held is None:
            return
        for picture in pictures:
            if held[0] > goal or picture[0] > goal:
                yield held
            held = picture
        yield held

    def _seek(self, target_s: Fraction) -> bool:
        try:
            self._container.seek(int((target_s + self.facts.zero_s) / self._stream.time_base), stream=self._stream)
        except FFmpegError:  # no index and no way back: read from the start instead
            return False
        self._fresh = False
        return True

    def _decoded(self) -> Iterator[tuple[Fraction, Any]]:
        self._fresh = False
        tick, zero, name = self._stream.time_base, self.facts.zero_s, self.facts.path.name
        bad = 0
        packets = self._container.demux(self._stream)
        while True:
            try:
                packet = next(packets, None)
                frames = packet.decode() if packet is not None else []
            except FFmpegError as error:
                bad += 1
                if bad == 1:
                    log.warning("%s: a damaged part is left out (%s)", name, error.strerror)
                if bad > 1000:
                    return
                continue
            if packet is None:
                return
            for frame in frames:
                stamp = _stamp(frame)
                if stamp is not None:
                    yield stamp * tick - zero, frame

    def _keyframe_stamps(self) -> list[int]:
        """Presentation timestamps of all keyframes where the file has a full index; else nothing.

        An index holds decoding times; how far the keyframes' presentation lies behind is read off the first.
        """
        index = self._stream.index_entries
        if not self._keys and 0 < self._stream.frames <= len(index):
            first = next((p for p in self._container.demux(self._stream) if p.is_keyframe and p.size), None)
            delay = first.pts - first.dts if first is not None and None not in (first.pts, first.dts) else 0
            self._keys = [e.timestamp + delay for e in index if e.is_keyframe]
        return self._keys

    def keyframe(self, near_s: Fraction) -> tuple[Fraction, Any] | None:
        """(time, frame) of the keyframe nearest to ``near_s`` as far as the file's index knows; only it is decoded."""
        tick = self._stream.time_base
        target = int((near_s + self.facts.zero_s) / tick)
        keys = self._keyframe_stamps()
        if keys:
            at = int(np.searchsorted(keys, target))
            target = min(keys[max(0, at - 1) : at + 1], key=lambda stamp: abs(stamp - target))
        else:
            target += int(Fraction(self.facts.keyframe_interval_s) / 2 / tick)
        context = self._stream.codec_context
        try:
            self._container.seek(target, stream=self._stream)
            packet = next((p for p in self._container.demux(self._stream) if p.is_keyframe and p.size), None)
            if packet is None:
                return None
            frames = [*context.decode(packet), *context.decode(None)]
            context.flush_buffers()
        except FFmpegError as error:
            log.warning("%s: no keyframe at %.1f s (%s)", self.facts.path.name, float(near_s), error.strerror)
            return None
        self._fresh = False
        return (_stamp(frames[0]) * tick - self.facts.zero_s, frames[0]) if frames else None


def to_planes(frame: Any, facts: MediaFacts) -> Planes:
    """The upright, square-pixel picture of a decoded frame. Views of the decoder's memory where nothing need change.

    Pictures without a colour tag are BT.709 from 720 rows or 1280 columns up and BT.601 below, as players take them.
    """
    upright = facts.size if facts.rotation % 180 == 0 else (facts.size[1], facts.size[0])
    bt601 = frame.colorspace in _BT601 or (frame.colorspace not in (0, _BT709, *_BT2020) and _is_small(frame))
    full = frame.color_range == _FULL or frame.format.name.startswith("yuvj")
    odd = frame.width % 2 or frame.height % 2
    if frame.format.name != "yuv420p" or bt601 or full or odd:
        rgb = frame.format.is_rgb
        frame = _reformatter().reformat(
            frame,
            width=frame.width + frame.width % 2,
            height=frame.height + frame.height % 2,
            format="yuv420p",
            src_colorspace=_matrix_of(frame, bt601=bt601 and not rgb),
            dst_colorspace=Colorspace.ITU709,
            src_color_range=_FULL if full or rgb else _LIMITED,
            dst_color_range=_LIMITED,
        )
    y, u, v = (
        np.frombuffer(p, np.uint8)[: p.height * p.line_size].reshape(p.height, p.line_size)[:, : p.width]
        for p in frame.planes
    )
    planes = resize_planes(Planes(y, u, v), upright)
    return turn_planes(planes, facts.rotation) if facts.rotation else planes


def _reformatter() -> VideoReformatter:
    """One a thread: it keeps its tables, and is not safe to share."""
    if not hasattr(_per_thread, "reformatter"):
        _per_thread.reformatter = VideoReformatter()
    return _per_thread.reformatter


def _matrix_of(frame: Any, *, bt601: bool) -> Colorspace:
    if bt601:
        return Colorspace.ITU601
    return Colorspace.BT2020 if frame.colorspace in _BT2020 else Colorspace.ITU709


def _is_small(frame: Any) -> bool:
    return max(frame.width, frame.height) < 1280 and min(frame.width, frame.height) < 720


def read_sound(facts: MediaFacts, from_s: Fraction, rate: int) -> Iterator[tuple[Fraction, NDArray[np.float32]]]:
    """(time in seconds, mono float32 samples at ``rate``) of a file's first sound track from about ``from_s`` on.

    The first block begins at or before ``from_s`` where there is sound. Blocks are in order; what lies between the
    end of one and the start of the next is silence. Begun inside a file, the sound lies as exactly as the file's ticks
    (half a millisecond in Matroska); after that samples are counted, so it does not jitter.
    """
    with _open(facts.path) as container:
        stream = container.streams.audio[0]
        zero, tick = _zero(container), stream.time_base
        if from_s > Fraction(1, 2):
            # The decoder needs some frames before the first that is right: overlapped transforms, bit reservoirs.
            container.seek(int((from_s - Fraction(1, 4) + zero) / tick), stream=stream)
        grace = float(max(3 * tick, Fraction(1, 500)))  # timestamps are rounded; a hole is more than that
        run: _Run | None = None
        for frame in _sound_frames(container, stream, facts.path.name):
            stamp, ticks = _stamp(frame), frame.time_base
            if run is None or (stamp is not None and abs(stamp * float(ticks) - float(zero) - run.end_s) > grace):
                if run is not None:
                    yield from run.blocks(None)
                run = _Run((stamp or 0) * ticks - zero, rate)
            yield from run.blocks(frame)
        if run is not None:
            yield from run.blocks(None)


def _sound_frames(container: Any, stream: Any, name: str) -> Iterator[Any]:
    packets = container.demux(stream)
    while True:
        try:
            packet = next(packets, None)
            frames = packet.decode() if packet is not None else []
        except FFmpegError as error:
            log.warning("%s: damaged sound is left out (%s)", name, error.strerror)
            continue
        if packet is None:
            return
        yield from frames


class _Run:
    """A stretch of sound without a hole, resampled; counts samples so that rounded timestamps cannot jitter it.

    Handed out by the half second: Python's share of a block is ten times the decoding of one AAC frame.
    """

    def __init__(self, start_s: Fraction, rate: int) -> None:
        self.end_s = float(start_s)
        self._start_s, self._rate, self._given, self._taken = start_s, rate, 0, 0
        self._resampler = av.AudioResampler(format="flt", layout="mono", rate=rate, frame_size=rate // 2)

    def blocks(self, frame: Any) -> Iterator[tuple[Fraction, NDArray[np.float32]]]:
        """What comes out for ``frame``, or at the end for None."""
        if frame is not None:
            frame.pts = None
            self._taken += frame.samples
            self.end_s = float(self._start_s) + self._taken / frame.sample_rate
        for piece in self._resampler.resample(frame):
            samples = piece.to_ndarray().reshape(-1).astype(np.float32, copy=False)
            yield self._start_s + Fraction(self._given, self._rate), samples
            self._given += piece.samples


# ------------------------------------------------------------------------------------------------------- writing


@frozen
class Encoding:
    """How pictures and sound are coded. Names are FFmpeg's; options go to the encoder as they are."""

    codec: str = "libx264"
    options: Mapping[str, str] = field(factory=lambda: {"preset": "superfast", "crf": "20"})
    pixel_format: str = "yuv420p"
    audio_codec: str = "aac"
    audio_options: Mapping[str, str] = field(factory=lambda: {"b": "192k"})
    tag: str = ""  # four-character code where a player wants another than the muxer's, such as hvc1


class VideoWriter:
    """Writes one video file with sound: constant rate from timestamp 0, BT.709 limited range, nothing that identifies.

    A context manager. The file grows under a hidden name beside ``path`` and takes its own name on a clean exit; on an
    exception nothing is left. The same input gives the same bytes on the same machine. ``path`` ends in .mp4, .mov or
    .mkv. size: (width, height), even. rate: frames per second. keyframe_interval: most frames from one keyframe to
    the next. audio_rate: samples per second; None for a silent file. Pictures and sound are handed over in time
    order, each for itself; which comes first does not matter.

    Raises UsageError for a size, codec or format that cannot be written, InputError where the folder cannot be
    written to, MediaError when the encoder fails.
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
        self._keyframe_interval, self._audio_rate, self._channels = keyframe_interval, audio_rate, audio_channels
        if self.path.suffix.lower() not in _FORMATS:
            raise UsageError(
                f"cannot write a {self.path.suffix or 'nameless'} file",
                where=str(self.path),
                remedy=f"Choose a name that ends in {', '.join(_FORMATS)}",
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
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            handle, name = tempfile.mkstemp(prefix=f".{self.path.name}.", suffix=".part", dir=self.path.parent)
        except OSError as error:
            raise InputError(
                f"cannot be written ({error.strerror})", where=str(self.path), remedy="Choose a folder you may write to"
            ) from error
        os.close(handle)
        self._part = Path(name)
        try:
            self._open()
        except BaseException:
            self._part.unlink(missing_ok=True)
            raise
        return self

    def _open(self) -> None:
        container_format = _FORMATS[self.path.suffix.lower()]
        options = {"fflags": "+bitexact"}  # no muxer version, no random ids
        if container_format != "matroska":
            options["movflags"] = "+faststart+write_colr"
        self._container = av.open(str(self._part), "w", format=container_format, container_options=options)
        try:
            self._video = self._add_video()
            self._audio = self._add_audio() if self._audio_rate else None
            self._container.start_encoding()
        except (FFmpegError, ValueError) as error:
            self._container.close()
            raise UsageError(
                f"cannot encode with {self.encoding.codec} as {self.encoding.pixel_format} ({error})",
                where=str(self.path),
                remedy="Choose a codec, pixel format and options that this FFmpeg and the container know",
            ) from error

    def _add_video(self) -> Any:
        encoding = self.encoding
        stream: Any = self._container.add_stream(encoding.codec, rate=self.rate, options=dict(encoding.options))
        context = stream.codec_context
        context.width, context.height = self.size
        context.pix_fmt = encoding.pixel_format
        context.time_base = stream.time_base = 1 / self.rate
        context.sample_aspect_ratio = Fraction(1)
        context.color_primaries = context.color_trc = context.colorspace = _BT709
        context.color_range = _LIMITED
        context.flags |= CodecFlags.bitexact
        if self._keyframe_interval:
            context.gop_size = self._keyframe_interval
        if encoding.tag:
            context.codec_tag = encoding.tag
        return stream

    def _add_audio(self) -> Any:
        layout = "mono" if self._channels == 1 else "stereo"
        stream: Any = self._container.add_stream(
            self.encoding.audio_codec,
            rate=self._audio_rate,
            layout=layout,
            options=dict(self.encoding.audio_options),
        )
        stream.codec_context.flags |= CodecFlags.bitexact
        return stream

    def write(self, picture: U8 | Planes) -> None:
        """Appends one picture of the file's size."""
        planes = picture if isinstance(picture, Planes) else bgr_to_planes(picture)
        if planes.size != self.size:
            raise ValueError(f"a picture of {planes.size} for a file of {self.size}")
        frame = frame_from_planes(planes)
        if self.encoding.pixel_format != "yuv420p":
            frame = frame.reformat(format=self.encoding.pixel_format, src_colorspace="ITU709", dst_colorspace="ITU709")
        frame.pts, frame.time_base = self.frames, 1 / self.rate
        self._mux(self._video, frame)
        self.frames += 1

    def write_audio(self, samples: NDArray[np.float32]) -> None:
        """Appends sound, (n, channels) or (n,) for one channel, in -1..1."""
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
            self._container.mux(stream.encode(frame))
        except (FFmpegError, OSError) as error:
            raise MediaError(
                f"writing failed after {self.frames} frames ({error})",
                where=str(self.path),
                remedy="Look whether the disk is full, or choose other encoder settings",
            ) from error

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                if not self.frames:
                    raise MediaError("no picture was written", where=str(self.path), remedy="Choose a longer stretch")
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
            raise MediaError(
                f"the file could not be finished ({error})",
                where=str(self.path),
                remedy="Look whether the disk is full",
            ) from error

    def _rename(self) -> None:
        with self._part.open("rb+") as stream:  # a power cut must not leave a name without its content
            os.fsync(stream.fileno())
        umask = os.umask(0)
        os.umask(umask)
        self._part.chmod(0o666 & ~umask)
        self._part.replace(self.path)


def frame_from_planes(planes: Planes) -> Any:
    """An av frame, yuv420p tagged BT.709 limited, holding a copy of ``planes``."""
    width, height = planes.size
    frame: Any = av.VideoFrame(width, height, "yuv420p")
    for target, source in zip(frame.planes, planes, strict=True):
        rows = np.frombuffer(target, np.uint8).reshape(target.height, target.line_size)
        rows[:, : source.shape[1]] = source
    frame.colorspace = frame.color_primaries = frame.color_trc = _BT709
    frame.color_range = _LIMITED
    return frame
