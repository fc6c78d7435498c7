"""Containers that ask players to cut pictures: all of the picture is shown, and it is told."""

from __future__ import annotations

import re
import struct
from fractions import Fraction
from pathlib import Path

import pytest
from coded_video import SIZE, read_number, write_coded
from notes import Notes

from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.media.frames import to_planes
from mcsl_core.media.probing import probe
from mcsl_core.media.reading import VideoReader
from mcsl_core.recording.cameras import open_cameras

ASKED = (SIZE[0] - 16, SIZE[1] - 8)


def with_clean_aperture(path: Path) -> Path:
    """Puts a ``clap`` box behind the ``avcC`` of an MP4 or MOV whose index stands at its end."""
    data = bytearray(path.read_bytes())
    width, height = ASKED
    clap = struct.pack(">I4s8I", 40, b"clap", width, 1, height, 1, 0, 1, 0, 1)
    at = data.rindex(b"avcC") - 4
    at += struct.unpack_from(">I", data, at)[0]
    for kind in (b"avc1", b"stsd", b"stbl", b"minf", b"mdia", b"trak", b"moov"):
        size_at = data.rindex(kind, 0, at) - 4
        struct.pack_into(">I", data, size_at, struct.unpack_from(">I", data, size_at)[0] + len(clap))
    data[at:at] = clap
    path.write_bytes(data)
    return path


def with_pixel_crop(path: Path) -> Path:
    """Puts PixelCrop elements into a Matroska film's track, and takes as much from the void before it."""
    data = path.read_bytes()
    crops = b"".join(name + b"\x81" + bytes([n]) for name, n in ((b"\x54\xcc", 16), (b"\x54\xbb", 8)))
    void = data.index(b"\xec\x01\x00\x00\x00\x00\x00\x00")
    size = data[void + 8]
    data = data[: void + 8] + bytes([size - len(crops)]) + data[void + 9 + len(crops) :]
    tracks = data.index(b"\x16\x54\xae\x6b\x40")  # a size of two bytes
    head = data[:tracks] + b"\x16\x54\xae\x6b\x40" + bytes([data[tracks + 5] + len(crops)])
    rest = data[tracks + 6 :]
    entry, video = rest.index(b"\xae\x01\0\0\0\0\0\0") + 8, re.search(rb"\xe0([\x80-\xff])\xb0", rest)
    assert video is not None
    at = video.start() + 1
    grown = [rest[:entry], rest[entry] + len(crops), rest[entry + 1 : at], rest[at] + len(crops)]
    rest = b"".join(piece if isinstance(piece, bytes) else bytes([piece]) for piece in grown) + crops + rest[at + 1 :]
    path.write_bytes(head + rest)
    return path


def film(folder: Path, name: str, *, cut: bool) -> Path:
    path = write_coded(folder / name, range(24))
    if not cut:
        return path
    return with_pixel_crop(path) if path.suffix == ".mkv" else with_clean_aperture(path)


@pytest.mark.parametrize("name", ["a.mp4", "a.mov", "a.mkv"])
def test_the_whole_picture_is_shown_and_it_is_told(tmp_path, name):
    assert probe(film(tmp_path, name, cut=False)).asked_size is None
    path = film(tmp_path, name, cut=True)
    facts = probe(path)
    assert (facts.asked_size, facts.size, facts.coded_size) == (ASKED, SIZE, SIZE)
    reader = VideoReader(facts, threads=1)
    shown = [read_number(planes_to_bgr(to_planes(frame, facts))) for _, frame in reader.read(Fraction(0))]
    reader.close()
    assert shown == list(range(24))
    write_coded(tmp_path / "b.mp4", range(24))
    notes = Notes()
    open_cameras([path, tmp_path / "b.mp4"], tmp_path, notes)
    (told,) = [note for note in notes.notes if "asks players" in note]
    assert told == f"a: {name} asks players to show 240x136 of its 256x144 pixels; here all of them are shown"


@pytest.mark.parametrize("suffix", [".ts", ".avi", ".mp4", ".mkv", ".mov", ".webm"])
def test_nothing_is_asked_by_other_files(tmp_path, suffix):
    codec, options = ("libvpx-vp9", {"deadline": "realtime"}) if suffix == ".webm" else ("libx264", None)
    path = write_coded(tmp_path / f"a{suffix}", range(10), codec=codec, options=options, aspect=Fraction(4, 3))
    assert probe(path).asked_size is None
