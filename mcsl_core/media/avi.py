"""Where an AVI's packets belong in time, by its index.

They carry no timestamps. FFmpeg counts them as it reads, and counts on over those that are lost: what follows a damaged
stretch came earlier by as much as is missing. The index says at which byte each lies.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

from mcsl_core.errors import MediaError

_HEADER = 8  # bytes: a packet's place is behind the chunk's name and length, the index's before
_ALL = 0.9  # of the pictures that the header counts; those that a recorder dropped have no entry
_LARGEST_INDEX = 16 << 20  # bytes, 16 for each of a million chunks


def has_index(entries: Any, frames: int) -> bool:
    """Whether what FFmpeg knows of a file is its own index, which stands at its end, and not what was read so far."""
    return len(entries) > 1 and entries[-1].timestamp > _ALL * frames


def refuse_misfit(path: Path) -> None:
    """MediaError for an AVI that has its index, though FFmpeg could not use it: bytes are missing before it."""
    size = path.stat().st_size
    with path.open("rb") as stream:
        stream.seek(max(0, size - _LARGEST_INDEX))
        data = stream.read()
    at = data.find(b"idx1")
    while 0 <= at <= len(data) - _HEADER:
        (length,) = struct.unpack_from("<I", data, at + 4)
        if at + _HEADER + length + length % 2 == len(data):
            raise MediaError(
                "is an AVI whose index does not fit its pictures: bytes are missing inside it, and nothing says when "
                "what follows them was recorded",
                where=str(path),
                remedy="Copy it again from the recorder, or leave it out",
            )
        at = data.find(b"idx1", at + 1)


class AviPlaces:
    """Gives packets the timestamps of their places; does nothing in a file without its index."""

    def __init__(self, stream: Any) -> None:
        self._index = stream.index_entries
        self._usable = has_index(self._index, stream.frames)
        self._numbers: dict[int, int] = {}  # of entries by their bytes, made once one is not where it should be
        self._last: int | None = None

    def place(self, packet: Any) -> bool:
        """Corrects a packet's timestamp; whether others are missing before it, or it is none that the index knows."""
        if not self._usable or packet.dts is None or packet.pos is None:
            return False
        number = self._number_of(packet)
        if number is None:
            return True
        last, self._last = self._last, number
        late = self._index[number].timestamp - packet.dts
        packet.dts += late
        if packet.pts is not None:
            packet.pts += late
        return last is not None and number > last + 1

    def _number_of(self, packet: Any) -> int | None:
        expected = self._index.search_timestamp(packet.dts, any_frame=True)
        if expected >= 0 and self._index[expected].pos + _HEADER == packet.pos:
            return expected
        if not self._numbers:
            self._numbers = {entry.pos + _HEADER: number for number, entry in enumerate(self._index)}
        return self._numbers.get(packet.pos)
