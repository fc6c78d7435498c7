"""The boxes at the top of an MP4 or MOV file, read by their headers alone."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path

from mcsl_core.errors import MediaError


def refuse_second_film(path: Path) -> None:
    """MediaError for an MP4 or MOV file that holds another behind its end: players show the first alone.

    A film has one table of its pictures (``moov``), however many fragments it is recorded in.
    """
    if sum(kind == b"moov" for kind in _kinds(path)) > 1:
        raise MediaError(
            "holds two films or more, as files joined end to end do, of which only the first can be seen",
            where=str(path),
            remedy="Hand in the files it was joined from",
        )


def _kinds(path: Path) -> Iterator[bytes]:
    """The kinds of the boxes in order, up to where something else than a box begins.

    References
    ----------
    ISO/IEC 14496-12, "Object structure": 32 bits of size and the kind; a size of 1 stands for 64 bits behind them.
    """
    end, begin = path.stat().st_size, 0
    with path.open("rb") as stream:
        while begin + 8 <= end:
            stream.seek(begin)
            size, kind = struct.unpack(">I4s", stream.read(8))
            if size == 1 and begin + 16 <= end:
                (size,) = struct.unpack(">Q", stream.read(8))
            if size < 8 or not kind.isascii():  # 0: to the end of the file
                yield kind
                return
            yield kind
            begin += size
