"""Probing: facts of a file from its headers, index and packets, and from its first picture."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from pathlib import Path
from typing import Any

import av
import numpy as np
from attrs import frozen
from av.error import FFmpegError

from mcsl_core.errors import MediaError
from mcsl_core.timing import parse_time

from .avi import has_index, refuse_misfit
from .boxes import refuse_second_film
from .colours import colour_note, refuse_colours
from .crops import asked_size
from .decoders import takes_strictly
from .facts import MediaFacts, displayed_size, is_variable
from .opening import main_video, open_file, refuse_raw, time_origin_of, timestamp_of
from .orientation import orientation_of
from .packets import packets_of
from .scan import scan_of
from .timestamps import frame_rate, set_back
from .tracks import AudioTrack, audio_tracks

_WHOLE_BYTES = 64 << 20  # a file without an index is scanned whole up to this size (0.1 s), else at its ends
_HEAD_PACKETS = 600
_BY_BYTES, _PLACES = ("mpegts", "mpeg"), 64  # formats that can be sought by bytes; where to look for a clock set back
_LASTING = 10  # packets
_MOST_LOST = 10  # times what is there; a count beyond that is none
_REORDER_PACKETS = 64  # so many tell whether pictures are reordered: groups of B-frames are of 16 at most


@frozen
class _IndexEntry:
    timestamp: int  # ticks
    is_keyframe: bool
    end_byte: int


@frozen(kw_only=True)
class _Header:
    """What the container's headers and the first picture say; see `MediaFacts` for the fields of one name."""

    form: str  # FFmpeg's name of the container
    tick: Fraction
    zero_s: Fraction
    start_s: Fraction
    promised_end_s: Fraction | None
    declared_rate: Fraction | None
    counted: int  # frames, 0 where the headers do not count them
    index: list[_IndexEntry]
    coded_size: tuple[int, int]
    sample_aspect: Fraction
    stream_aspect: Fraction | None
    rotation: int
    mirrored: bool
    colour: str
    codec: str
    pixel_format: str
    audio_tracks: tuple[AudioTrack, ...]
    timecode: str | None
    decoding_order: bool
    created: str


@frozen(kw_only=True)
class _Packets:
    """What the index or the packets say, on the file's own time."""

    stamps: list[int]  # ticks
    keyframes: int  # among them
    end_s: Fraction | None  # of the last picture
    usable_s: Fraction | None  # where a file that was cut short ends; None for a whole one
    frames: int | None  # None where they were not counted

    @property
    def truncated(self) -> bool:
        return self.usable_s is not None

    def span(self, tick: Fraction) -> Fraction:
        """Seconds from the first to the last picture."""
        return Fraction(max(self.stamps) - min(self.stamps)) * tick if len(self.stamps) > 1 else Fraction(0)


def probe(path: str | Path) -> MediaFacts:
    """Facts of a media file from its headers, index and packets; only its first picture is decoded.

    Parameters
    ----------
    path
        Any file that FFmpeg opens.

    Raises
    ------
    MediaError
        Where it cannot be opened, holds no video, or not one picture of it can be decoded.

    Notes
    -----
    A file without an index is scanned packet by packet up to 64 MiB (0.1 s), a larger one at its ends only: then the
    number of its frames is estimated from its duration.

    Examples
    --------
    >>> facts = probe("cam1.mp4")  # doctest: +SKIP
    >>> facts.size, facts.rate, facts.duration_s  # doctest: +SKIP
    ((1920, 1080), Fraction(30000, 1001), 1800.3)
    """
    path = Path(path)
    header = _read_header(path)
    packets = _from_index(path, header) if 0 < header.counted <= len(header.index) else _from_packets(path, header)
    stamps, tick = packets.stamps, header.tick
    rate = frame_rate(stamps, tick, header.declared_rate)
    end = header.promised_end_s if packets.truncated else None
    end = end or packets.end_s or header.promised_end_s or header.start_s + len(stamps) / rate
    return MediaFacts(
        path=path,
        size=displayed_size(header.coded_size, header.sample_aspect, header.rotation),
        coded_size=header.coded_size,
        rotation=header.rotation,
        sample_aspect=header.sample_aspect,
        rate=rate,
        frames=max(1, round((end - header.start_s) * rate) if packets.frames is None else packets.frames),
        zero_s=header.zero_s,
        start_s=header.start_s,
        end_s=end,
        usable_s=end if packets.usable_s is None else min(packets.usable_s, end),
        tick_s=tick,
        variable_rate=is_variable(np.sort(np.array(stamps, np.float64)) * float(tick)),
        keyframe_interval_s=float(packets.span(tick) + 1 / rate) / max(1, packets.keyframes),
        codec=header.codec,
        pixel_format=header.pixel_format,
        audio_tracks=header.audio_tracks,
        timecode=header.timecode,
        truncated=packets.truncated,
        decoding_order=header.decoding_order,
        created=header.created,
        scan=scan_of(path, rate),
        mirrored=header.mirrored,
        colour=header.colour,
        stream_aspect=header.stream_aspect,
        asked_size=asked_size(path, header.form, header.coded_size),
        strict=takes_strictly(path),
    )


def conversions_of(path: Path) -> tuple[str, ...]:
    """`MediaFacts.conversions` of a file, kept for the run; raises as `probe` does."""
    state = path.stat()
    return _conversions_of(path, state.st_size, state.st_mtime_ns)


@lru_cache(maxsize=1024)
def _conversions_of(path: Path, _size: int, _changed_ns: int) -> tuple[str, ...]:
    return probe(path).conversions


def _read_header(path: Path) -> _Header:
    with open_file(path) as container:
        refuse_raw(container, path)
        if "mp4" in container.format.name:
            refuse_second_film(path)
        stream = main_video(container, path)
        zero = time_origin_of(container)
        timecode = next((s.metadata["timecode"] for s in container.streams if "timecode" in s.metadata), None)
        promised = _promised_end(container, stream, zero)
        index = [_IndexEntry(e.timestamp, e.is_keyframe, e.pos + e.size) for e in stream.index_entries]
        first = _first_picture(container, stream, path)
        begin = (timestamp_of(first) or 0) * stream.time_base
        if container.format.name == "avi":  # it has no presentation times; FFmpeg makes them up, and late with H.264
            zero = begin
        refuse_colours(first, path)
        rotation, mirrored = orientation_of(first)
        return _Header(
            form=container.format.name,
            tick=stream.time_base,
            zero_s=zero,
            start_s=begin - zero,
            promised_end_s=promised,
            declared_rate=stream.guessed_rate or stream.average_rate or stream.base_rate,
            counted=stream.frames,
            index=index,
            coded_size=(first.width, first.height),
            sample_aspect=stream.sample_aspect_ratio or Fraction(1),
            stream_aspect=stream.codec_context.sample_aspect_ratio or None,
            rotation=rotation,
            mirrored=mirrored,
            colour=colour_note(first),
            codec=stream.codec_context.name,
            pixel_format=first.format.name,
            audio_tracks=audio_tracks(container),
            timecode=timecode or container.metadata.get("timecode"),
            decoding_order=stream.codec_context.has_b_frames and _in_decoding_order(path),
            created=container.metadata.get("creation_time", ""),
        )


def _from_index(path: Path, header: _Header) -> _Packets:
    """Of a file whose index names every frame; where it was cut short, by what its size leaves of them."""
    size_bytes, index = path.stat().st_size, header.index
    missing = [entry.timestamp for entry in index if entry.end_byte > size_bytes]
    if len(index) == 1:  # it was decoded, so it is there
        missing = []
    stamps = [entry.timestamp for entry in index]
    end = None if missing else _end(path, stamps[-min(len(stamps), 40)], any_frame=True)
    return _Packets(
        stamps=stamps,
        keyframes=sum(entry.is_keyframe for entry in index),
        end_s=None if end is None else end - header.zero_s,
        usable_s=min(missing) * header.tick - header.zero_s if missing else None,
        frames=max(len(index) - len(missing), 1),
    )


def _from_packets(path: Path, header: _Header) -> _Packets:
    """Of a file without a full index, by reading its packets: all of them, or those at the ends of a large file."""
    whole, promised = path.stat().st_size <= _WHOLE_BYTES, header.promised_end_s
    if header.form == "mpeg":
        _refuse_untimed(path, None if whole else _HEAD_PACKETS)
    stamps, keyframes, end = _scan(path, None if whole else _HEAD_PACKETS)
    _refuse_joined(path, header, stamps if whole else _sampled(path), lasting=_LASTING if whole else 1)
    if not whole:
        end = _end(path, int(((promised or 0) + header.zero_s) / header.tick), any_frame=False) or end
    end_s = None if end is None else end - header.zero_s
    # An AVI's promise is a number of pictures, others' may be that of the sound.
    slack = 2 / header.declared_rate if header.form == "avi" and header.declared_rate else 1
    cut_short = promised and end and end - header.zero_s < promised - slack
    if cut_short and header.form == "mxf":
        _refuse_without_index(path)
    if cut_short and header.form == "avi" and not has_index(header.index, header.counted):
        refuse_misfit(path)
    return _Packets(
        stamps=stamps,
        keyframes=keyframes,
        end_s=end_s,
        usable_s=end_s if cut_short else None,
        frames=len(stamps) if whole else None,
    )


def _refuse_untimed(path: Path, most: int | None) -> None:
    """Programme streams give a time to the first picture of a block alone; of H.264's others FFmpeg makes up none.

    Of 60 small pictures so written 4 had a time, and 49 were shown.
    """
    with open_file(path) as container:
        packets = itertools.islice(packets_of(container, main_video(container, path)), most)
        timed = [timestamp_of(packet) is not None for packet in packets if packet.size]
    if timed.count(False) > len(timed) // 50:
        raise MediaError(
            f"{timed.count(False)} of {len(timed)} pictures have no time of their own in this programme stream",
            where=str(path),
            remedy=f"Export it as MP4, or write it anew: ffmpeg -i {path.name} -crf 16 {path.stem}.mkv",
        )


def _refuse_joined(path: Path, header: _Header, stamps: Sequence[int], *, lasting: int) -> None:
    at = set_back(stamps, header.tick, lasting=lasting)
    if at is not None:
        raise MediaError(
            f"its clock is set back after {float(at - header.zero_s):.1f} s, as in files joined end to end",
            where=str(path),
            remedy=f"Hand in the files it was joined from, or give it one clock: ffmpeg -i {path.name} -map 0 -c copy "
            f"{path.stem}-joined.mkv",
        )


def _refuse_without_index(path: Path) -> None:
    """MXF keeps its index at its end; without it FFmpeg guesses places and times, and shows wrong pictures."""
    raise MediaError(
        "is an MXF file that was cut short, without the index that stands at its end",
        where=str(path),
        remedy=f"Put what is left into another container: ffmpeg -i {path.name} -c copy {path.stem}.mkv",
    )


def _sampled(path: Path) -> list[int]:
    """Decoding times at places spread over a transport or programme stream; none of other files."""
    stamps = []
    with open_file(path) as container:
        if container.format.name not in _BY_BYTES:
            return []
        stream = main_video(container, path)
        for place in range(_PLACES):
            try:
                container.seek(path.stat().st_size * place // _PLACES, unsupported_byte_offset=True)
                packet = next((p for p in container.demux(stream) if p.dts is not None), None)
            except FFmpegError:
                continue
            if packet is not None:
                stamps.append(packet.dts)
    return stamps


def _promised_end(container: Any, stream: Any, zero: Fraction) -> Fraction | None:
    """The end of the picture in seconds as the headers have it; None where they do not say."""
    if container.format.name == "avi" and stream.frames <= _MOST_LOST * (stream.duration or 0):
        return max(stream.frames, stream.duration) * stream.time_base  # FFmpeg makes the duration fit what is there
    if stream.duration:
        return ((stream.start_time or 0) + stream.duration) * stream.time_base - zero
    for name, text in stream.metadata.items():
        if name.upper().startswith("DURATION"):  # Matroska's durations are ends, whenever the file begins
            with contextlib.suppress(ValueError):
                return parse_time(text) - zero
    if container.duration and not container.streams.audio:  # with sound, it may be the sound's
        begin = 0 if "matroska" in container.format.name else container.start_time or 0
        return Fraction(begin + container.duration, av.time_base) - zero
    return None


def _first_picture(container: Any, stream: Any, path: Path) -> Any:
    reason = "no picture in it"
    for packet in itertools.islice(packets_of(container, stream), 1000):
        try:
            for frame in packet.decode():
                return frame
        except FFmpegError as error:
            reason = str(error.strerror)
    raise MediaError(
        f"not one picture can be decoded ({reason})",
        where=str(path),
        remedy="Copy it again from the recorder, or leave it out",
    )


def _in_decoding_order(path: Path) -> bool:
    """Whether pictures that are shown in another order than decoded have timestamps that rise as they are decoded."""
    with open_file(path) as container:
        stream = main_video(container, path)
        stamps: list[int] = []
        shown: list[int] = []
        try:
            for packet in itertools.islice(container.demux(stream), _REORDER_PACKETS):
                if packet.size:
                    packet.pts = timestamp_of(packet)  # a frame keeps its own packet's
                    stamps.append(packet.pts if packet.pts is not None else 0)
                if stamps != sorted(stamps):
                    return False
                shown += [frame.pts for frame in packet.decode() if frame.pts is not None]
                if shown != sorted(shown):
                    return True
        except FFmpegError:
            return False
    return False


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
    stamps, keys, last = [], 0, None
    for packet in itertools.islice(packets_of(container, stream), most):
        stamp = timestamp_of(packet)
        if stamp is not None and packet.size:
            stamps.append(stamp)
            keys += packet.is_keyframe
            last = max(last or (stamp, 0), (stamp, packet.duration or 0))
    if last is None:
        return stamps, keys, None
    rising = sorted(stamps)
    # A parser gives the last picture no duration where one was lost before it.
    lasts = last[1] or min((b - a for a, b in zip(rising, rising[1:], strict=False) if b > a), default=0)
    return stamps, keys, (last[0] + lasts) * stream.time_base
