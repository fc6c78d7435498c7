"""The checksums of a Matroska file: which of its clusters, a second of film or a few, do not hold what was written.

FFmpeg writes a CRC-32 into every cluster, and with it what records through it (OBS Studio), and reads over it. It tells
of any changed byte, in every codec.

References
----------
RFC 8794 (EBML), section 11.3.1; RFC 9559 (Matroska), section 5.1.3.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO

from .ebml import read_number
from .opening import open_file

_SEGMENT, _CLUSTER = 0x18538067, 0x1F43B675
# EBML, SeekHead, Info, Tracks, Cues, Chapters, Tags, Attachments, Void, CRC-32
_OTHERS = {0x1A45DFA3, 0x114D9B74, 0x1549A966, 0x1654AE6B, 0x1C53BB6B, 0x1043A770, 0x1254C367, 0x1941A469, 0xEC, 0xBF}
_CRC = b"\xbf\x84"  # the first element of whatever has one, and the length of what follows
_PIECE = 1 << 20


def damaged_clusters(path: Path, told: Callable[[int], None]) -> list[range]:
    """The bytes of the clusters whose checksum is not theirs; none in a file of another kind or without checksums.

    Parameters
    ----------
    path
        The file.
    told
        Called with the bytes that have been passed.
    """
    with open_file(path) as container:
        if "matroska" not in container.format.name:
            return []
    bad, right = [], 0
    with path.open("rb") as stream:
        for place in _clusters(stream, path.stat().st_size):
            stream.seek(place.start)
            head = stream.read(6)
            if head[:2] != _CRC:
                if not right and not bad:
                    return []
                continue
            if _crc_of_next(stream, len(place) - 6) == int.from_bytes(head[2:], "little"):
                right += 1
            else:
                bad.append(place)
            told(place.stop)
    return bad if right else []  # whoever wrote none that is right counts otherwise


def _crc_of_next(stream: BinaryIO, count: int) -> int:
    crc = 0
    while count > 0 and (piece := stream.read(min(count, _PIECE))):
        crc, count = zlib.crc32(piece, crc), count - len(piece)
    return crc


def _clusters(stream: BinaryIO, end: int) -> Iterator[range]:
    """Where the contents of the clusters lie that are there to their ends, past what is damaged between them."""
    at = 0
    while 0 <= at < end:
        stream.seek(at)
        head = stream.read(12)
        name_length, name = read_number(head, marked=True)
        size_length, size = read_number(head[name_length:], marked=False)
        begin = at + name_length + size_length
        if name == _SEGMENT and size_length:
            at = begin
        elif name not in (_CLUSTER, *_OTHERS) or not size_length:
            at = _next_cluster(stream, at + 1)
        elif begin + size > end:  # its length is damaged, it was not closed, or the file was cut short
            at = _next_cluster(stream, begin)
        else:
            if name == _CLUSTER and size > 6:
                yield range(begin, begin + size)
            at = begin + size


def _next_cluster(stream: BinaryIO, at: int) -> int:
    """The first byte of the next cluster from ``at`` on; -1 without one."""
    name = _CLUSTER.to_bytes(4, "big")
    while True:
        stream.seek(at)
        piece = stream.read(_PIECE)
        found = piece.find(name)
        if found >= 0:
            return at + found
        if len(piece) < _PIECE:
            return -1
        at += _PIECE - 3
