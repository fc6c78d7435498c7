"""What encoders write about themselves into their pictures and sound: found and taken out, nothing else is touched.

x264 and x265 put their version and every option into the first picture or the headers, the number of threads and the
compiler of the machine among them; FFmpeg's AAC and ProRes encoders name themselves. None of it is decoded.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import av

_USER_DATA = 5  # the payload type of a message that anybody may write, after ITU-T H.264 and H.265, annex D
_HEAD = 1 << 16  # such messages stand before the picture's own data
_LAVC = re.compile(rb"Lavc[0-9.]+")


def without_banner(packet: Any, codec: str, *, prefixed: bool) -> Any:
    """A coded packet without what its encoder says of itself; the packet itself where it says nothing.

    Parameters
    ----------
    packet
        An `av.Packet`, such as an encoder or a file gives it.
    codec
        FFmpeg's name of the codec or of the encoder.
    prefixed
        Whether a length of four bytes stands before each unit of H.264 or H.265, as in MP4; else a start code.
    """
    data = _without_banner(memoryview(packet), codec, prefixed=prefixed)
    if data is None:
        return packet
    clean = av.Packet(data)
    clean.pts, clean.dts, clean.duration, clean.time_base = packet.pts, packet.dts, packet.duration, packet.time_base
    clean.is_keyframe = packet.is_keyframe
    return clean


def _without_banner(view: memoryview, codec: str, *, prefixed: bool) -> bytes | None:
    if "264" in codec or "265" in codec or "hevc" in codec:
        hevc = "264" not in codec
        spans = [span for *span, unit in _units(view[:_HEAD], prefixed=prefixed) if _is_user_data(unit, hevc=hevc)]
        if not spans:
            return None
        kept, at = b"", 0
        for start, stop in spans:
            kept, at = kept + bytes(view[at:start]), stop
        return kept + bytes(view[at:])
    if codec == "aac" and _LAVC.search(view):
        return _LAVC.sub(lambda found: b" " * len(found[0]), view)
    if codec.startswith("prores") and view[12:16] == b"Lavc":  # after size, "icpf", size and version: who wrote it
        return bytes(view[:12]) + b"apl0" + bytes(view[16:])
    return None


def headers_without_banner(headers: bytes, codec: str) -> bytes:
    """A stream's headers (FFmpeg's extradata) without what its encoder says of itself.

    H.265's, as MP4 and Matroska hold them: a list of units by their kind (ISO/IEC 14496-15).
    """
    if "hevc" not in codec or len(headers) < 23 or headers[0] != 1:
        return headers
    arrays, at = [], 23
    for _ in range(headers[22]):
        start, kind, at = at, headers[at] & 0x3F, at + 3
        for _ in range(int.from_bytes(headers[start + 1 : start + 3])):
            at += 2 + int.from_bytes(headers[at : at + 2])
        if kind not in (39, 40):
            arrays.append(headers[start:at])
    return headers[:22] + bytes([len(arrays)]) + b"".join(arrays)


def _units(view: memoryview, *, prefixed: bool) -> Iterator[tuple[int, int, memoryview]]:
    """(start, stop, content) of the units that lie whole in ``view``."""
    if prefixed:
        start = 0
        while start + 4 < len(view):
            stop = start + 4 + int.from_bytes(view[start : start + 4])
            if stop > len(view):
                return
            yield start, stop, view[start + 4 : stop]
            start = stop
        return
    codes = [found.span() for found in re.finditer(rb"\0{2,3}\x01", view)]
    for (start, begin), (stop, _) in zip(codes, codes[1:], strict=False):
        yield start, stop, view[begin:stop]


def _is_user_data(unit: memoryview, *, hevc: bool) -> bool:
    if len(unit) < 3:
        return False
    kind, header = ((unit[0] >> 1) & 0x3F, 2) if hevc else (unit[0] & 0x1F, 1)
    return kind in ((39, 40) if hevc else (6,)) and unit[header] == _USER_DATA
