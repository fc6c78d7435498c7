# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether an MP4 or MOV is mirrored for display, which Blender does not obey. No bpy.

Blender turns a picture as the file's display matrix says and leaves out its mirroring: tried in 5.0 with all eight
orientations. Its own flips act on the transformed picture, so that they would turn every transform about. The same
matrix in Matroska is not read here.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

_LARGEST = 1 << 20  # bytes of a track's header, its matrix among them, are a hundred


def is_mirrored(path: Path) -> bool:
    """Whether players show the file's picture mirrored."""
    try:
        with path.open("rb") as file:
            matrix = _video_matrix(file)
    except (OSError, struct.error):  # told by who shows it
        return False
    return matrix is not None and matrix[0] * matrix[3] - matrix[1] * matrix[2] < 0


def _video_matrix(file: BinaryIO) -> tuple[int, int, int, int] | None:
    """a, b, c, d of the first video track's header (ISO/IEC 14496-12): one pixel right goes (a, b), one down (c, d)."""
    size = file.seek(0, 2)
    for _, begin, end in _boxes(file, 0, size, b"moov"):
        for _, first, last in _boxes(file, begin, end, b"trak"):
            header = next(_boxes(file, first, last, b"tkhd"), None)
            if header is None or header[2] - header[1] > _LARGEST:
                continue
            file.seek(header[1])
            content = file.read(header[2] - header[1])
            a, b, _, c, d, *_ = struct.unpack(">9i", content[-44:-8])
            if any(content[-8:]):  # width and height: sound has none
                return a, b, c, d
    return None


def _boxes(file: BinaryIO, begin: int, end: int, wanted: bytes) -> Iterator[tuple[bytes, int, int]]:
    """(name, first byte, byte after the last) of the content of the boxes of that name."""
    while begin + 8 <= end:
        file.seek(begin)
        size, name = struct.unpack(">I4s", file.read(8))
        start = begin + 8
        if size == 1:
            (size,) = struct.unpack(">Q", file.read(8))
            start += 8
        elif size == 0:
            size = end - begin
        if size < start - begin:
            return
        if name == wanted:
            yield name, start, min(begin + size, end)
        begin += size
