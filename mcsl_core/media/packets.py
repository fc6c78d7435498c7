"""A stream's packets past damaged places, and which of them are whole, judged without decoding one.

A decoder that meets damage shows the picture before, or smears on until the next keyframe, and only those of some
codecs say so. Packets tell at the price of reading the file: a unit that is none of its codec, bytes that its coding
cannot hold, a break in the container, pictures missing where bytes are. What hits the inside of one packet and leaves
no such trace, only decoding shows (`reading`), and that not always (`decoders`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any

from av.error import FFmpegError

from .avi import AviPlaces

_MOST_FAULTS = 100_000  # in a row without a packet between: FFmpeg reads on by 64 KiB each time, 6 GB together
_STREAMED = {"mpegts", "mpeg", "mpegvideo", "h264", "hevc"}
_MISSING = 2.5  # steps from one picture to the next from which on some are missing
_MISSING_BYTES = 1 << 16  # between the two: a recorder that dropped pictures wrote none
_ZEROS = bytes(64)  # arithmetic and Huffman coding do not make so many in a row
_NO_ZEROS = {"h264", "hevc", "vp8", "vp9", "av1", "libdav1d", "mjpeg"}
_STARTS: dict[str, Callable[[bytes], bool]] = {
    "mpeg4": lambda data: data[:3] == b"\0\0\1",
    "mpeg2video": lambda data: data[:3] == b"\0\0\1",
    "mpeg1video": lambda data: data[:3] == b"\0\0\1",
    "mjpeg": lambda data: b"\xff\xd8" in data[:256],
    "prores": lambda data: data[4:8] == b"icpf",
    "vp9": lambda data: data[0] & 0xC0 == 0x80,
    "libdav1d": lambda data: data[0] & 0x81 == 0,
    "av1": lambda data: data[0] & 0x81 == 0,
}


def packets_of(container: Any, stream: Any, broken: Callable[[], None] | None = None) -> Iterator[Any]:
    """The packets of a stream to its end, past places where the file is damaged.

    Parameters
    ----------
    container, stream
        As `open_file` and `main_video` give them.
    broken
        Called at every place that could not be read, before the packet behind it. FFmpeg then finds its way again: half
        a megabyte of zeros in a transport stream is seven such places, and the hours after it are whole.
    """
    faults = 0
    broken = broken or (lambda: None)
    avi = AviPlaces(stream) if container.format.name == "avi" else None
    while faults < _MOST_FAULTS:
        try:
            for packet in container.demux(stream):
                faults = 0
                if avi is not None and packet.size and avi.place(packet):
                    broken()
                yield packet
            return
        except FFmpegError:
            faults += 1
            broken()


def judged_packets(container: Any, stream: Any, rate: Fraction) -> Iterator[tuple[Any, bool]]:
    """As `packets_of`, each with whether it is whole.

    Parameters
    ----------
    container, stream
        As `open_file` and `main_video` give them.
    rate
        Nominal pictures per second.

    Yields
    ------
    packet, whole
        An `av.Packet`; those at the end are empty, and have a decoder give what it holds back. Not whole are all from
        the first that is not to the next keyframe that is: what is decoded there is made up.

    Notes
    -----
    One packet is held back, since damage that shows in the next may have begun in this one. In streams FFmpeg's parser
    puts packets together, at a break of pieces from before and after it: there the next one is not trusted either.
    """
    fits, pace = _unit_check(stream), _Pace(container.format.name, stream.time_base, rate)
    streamed = container.format.name in _STREAMED
    held, held_bad, bad_before, smears = None, False, False, False
    for packet in packets_of(container, stream, pace.breaks):
        bad = bool(packet.size) and (packet.is_corrupt or not fits(bytes(packet)))
        cut = pace.is_cut_before(packet)
        if held is not None:
            smears = held_bad or bad or cut or (smears and not held.is_keyframe)
            yield held, not smears
        held, held_bad = packet, bad or (cut and (streamed or not packet.is_keyframe)) or (streamed and bad_before)
        bad_before = bad
    if held is not None:
        yield held, not (held_bad or (smears and not held.is_keyframe))


class _Pace:
    """Whether something between two packets is lost."""

    def __init__(self, form: str, tick_s: Fraction, rate: Fraction) -> None:
        self._in_a_row = form in _STREAMED or "matroska" in form  # not led by an index: what is lost leaves no trace
        self._missing = _MISSING / float(rate * tick_s)
        self._broken, self._last = False, (None, 0)

    def breaks(self) -> None:
        """The file cannot be read before the next packet."""
        self._broken = True

    def is_cut_before(self, packet: Any) -> bool:
        """Whether packets are lost between the one asked for before and this one."""
        cut, self._broken = self._broken, False
        (stamp, end), now = self._last, packet.dts if packet.dts is not None else packet.pts
        if self._in_a_row and packet.pos is not None and now is not None:
            if stamp is not None and now - stamp > self._missing and packet.pos - end > _MISSING_BYTES:
                cut = True
            self._last = now, packet.pos + packet.size
        return cut


def _unit_check(stream: Any) -> Callable[[bytes], bool]:
    """What tells by a packet's bytes whether it can be a picture of the stream's codec."""
    codec, extra = stream.codec_context.name, bytes(stream.codec_context.extradata or b"")
    if codec in ("h264", "hevc") and extra[:1] == b"\1":
        at = 4 if codec == "h264" else 21
        length = (extra[at] & 3) + 1 if len(extra) > at else 4
        return lambda data: _units_fit(data, length)
    starts, no_zeros = _STARTS.get(codec, lambda _: True), codec in _NO_ZEROS

    def fits(data: bytes) -> bool:
        return starts(data) and not (no_zeros and _ZEROS in data and _ZEROS in data.rstrip(b"\0"))

    return fits


def _units_fit(data: bytes, length: int) -> bool:
    """Whether the NAL units of a packet fill it, and hold no bytes that H.264 and HEVC escape."""
    at, size = 0, len(data)
    while at < size:
        start = at + length
        at = start + int.from_bytes(data[at:start], "big")
        if at == start or at > size or data[start] & 0x80:
            return False
        if data.find(b"\0\0\0\0", start, at) >= 0 and b"\0\0\0\0" in data[start:at].rstrip(b"\0"):
            return False
    return True
