"""The part of a picture that its container asks players to show: MP4's clean aperture, Matroska's crop.

FFmpeg's decoders and Blender show the whole picture, and so does mcsl: at worst an edge that a player hides. What the
stream itself cuts off (H.264's and HEVC's conformance window) is never seen anywhere.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from .ebml import elements, read_number

_HEAD = 1 << 20  # bytes at whose beginning Matroska's tracks stand
_VIDEO = 78  # bytes of a sample entry of pictures before the boxes in it, behind its own header
_INSIDE = {b"moov": 0, b"trak": 0, b"mdia": 0, b"minf": 0, b"stbl": 0, b"stsd": 8}  # bytes before the boxes in it
_TRACKS, _TRACK, _PICTURES = b"\x16\x54\xae\x6b", 0xAE, 0xE0
_WIDTH, _HEIGHT = (0xB0, 0x54CC, 0x54DD), (0xBA, 0x54BB, 0x54AA)  # of all, and what is cut off at either side


def asked_size(path: Path, form: str, coded_size: tuple[int, int]) -> tuple[int, int] | None:
    """(width, height) of coded pixels that players are asked to show of a file's pictures; None where it is all.

    Parameters
    ----------
    path
        The file.
    form
        FFmpeg's name of its container.
    coded_size
        (width, height) of its pictures.

    References
    ----------
    ISO/IEC 14496-12, "Pixel aspect ratio and clean aperture"; RFC 9559, section 5.1.4.1.28.
    """
    with path.open("rb") as stream:
        asked = None
        if "mp4" in form:
            asked = _of_mp4(stream, path.stat().st_size)
        elif "matroska" in form:
            asked = _of_matroska(stream)
    return None if asked == coded_size else asked


def _of_mp4(stream: BinaryIO, end: int) -> tuple[int, int] | None:
    for kind, begin, stop in _boxes(stream, 0, end):
        if kind == b"clap" and stop - begin >= 16:
            stream.seek(begin)
            width, width_of, height, height_of = struct.unpack(">4I", stream.read(16))
            if width_of and height_of:
                return round(width / width_of), round(height / height_of)
    return None


def _boxes(stream: BinaryIO, begin: int, end: int) -> Iterator[tuple[bytes, int, int]]:
    """The boxes of the way to the sample entries, with those in them: kind, and where the content lies."""
    while begin + 8 <= end:
        stream.seek(begin)
        size, kind = struct.unpack(">I4s", stream.read(8))
        head = 8
        if size == 1 and begin + 16 <= end:
            (size,), head = struct.unpack(">Q", stream.read(8)), 16
        if size < head:
            return
        stop = min(begin + size, end)
        yield kind, begin + head, stop
        if kind in _INSIDE:
            for entry in _boxes(stream, begin + head + _INSIDE[kind], stop):
                yield entry
                if kind == b"stsd":  # an entry's own boxes; those of sound are none that matter here
                    yield from _boxes(stream, entry[1] + _VIDEO, entry[2])
        begin = stop


def _of_matroska(stream: BinaryIO) -> tuple[int, int] | None:
    head, at = stream.read(_HEAD), -1
    while (at := head.find(_TRACKS, at + 1)) >= 0:  # the list of what stands where names them as well
        length, size = read_number(head[at + 4 : at + 12], marked=False)
        for name, track in elements(head[at + 4 + length : at + 4 + length + size]):
            for kind, pictures in elements(track) if name == _TRACK else ():
                size = _cropped(dict(elements(pictures))) if kind == _PICTURES else None
                if size is not None:
                    return size
    return None


def _cropped(pictures: dict[int, bytes]) -> tuple[int, int] | None:
    whole, before, behind = (
        [int.from_bytes(pictures.get(names[n], b""), "big") for names in (_WIDTH, _HEIGHT)] for n in range(3)
    )
    if not any((*before, *behind)):
        return None
    width, height = (a - b - c for a, b, c in zip(whole, before, behind, strict=True))
    return width, height
