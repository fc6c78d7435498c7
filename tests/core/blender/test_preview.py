"""A person is told, by file, where Blender's preview is not what is delivered."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest
from coded_video import DATA, SIZE, coded_picture, write_coded
from interlaced_video import write_interlaced

from mcsl_core.blender.preview import preview_notes
from mcsl_core.edl import IDENTITY, Camera, Edl, Media, Pose, Shot
from mcsl_core.media.hdr_writing import HdrWriter
from mcsl_core.media.writing import Encoding
from mcsl_core.timing import FrameRange


def notes_of(folder: Path, **files: list[str]) -> list[str]:
    """Of an EDL with these files a camera."""
    span = FrameRange(0, 10)
    edl = Edl(
        rate=Fraction(25),
        size=(320, 180),
        frames=10,
        reference=next(iter(files)),
        cameras=tuple(
            Camera(name, tuple(Media(path, 10) for path in paths), (320, 180), Fraction(25))
            for name, paths in files.items()
        ),
        poses=(Pose(span, dict.fromkeys(files, IDENTITY)),),
        shots=(Shot(span, next(iter(files))),),
    )
    return list(preview_notes(edl, folder))


@pytest.mark.parametrize("coding", ["h264", "mpeg2", "prores"])
def test_interlaced_files_are_told_once_a_camera(tmp_path, coding):
    names = [f"a{number}.mov" for number in range(3)]
    for name in names:
        write_interlaced(tmp_path / name, 12, coding=coding)
    write_coded(tmp_path / "b.mp4", range(12))
    (note,) = notes_of(tmp_path, cam1=names, cam2=["b.mp4"])
    assert note.startswith("cam1: a0.mov and 2 more: interlaced; Blender's preview shows combs")
    assert "conformed pictures are deinterlaced" in note


def test_an_ordinary_file_and_one_that_cannot_be_read_are_not_told(tmp_path):
    write_coded(tmp_path / "a.mp4", range(12))
    (tmp_path / "broken.mp4").write_bytes(b"nothing")
    assert notes_of(tmp_path, cam1=["a.mp4"], cam2=["broken.mp4"], cam3=["missing.mp4"]) == []


@pytest.mark.parametrize("light", ["hlg", "pq"])
def test_hdr_files_are_told(tmp_path, light):
    encoding = Encoding(options={"preset": "ultrafast"}, pixel_format="yuv420p10le")
    with HdrWriter(tmp_path / "a.mp4", light=light, size=SIZE, rate=Fraction(25), encoding=encoding) as writer:
        for number in range(5):
            writer.write(coded_picture(number))
    (note,) = notes_of(tmp_path, cam1=["a.mp4"])
    assert note.startswith(f"cam1: a.mp4: colours in {light} bt2020; Blender's preview may show others")


@pytest.mark.skipif(not (DATA / "faults" / "hdr" / "hlg.mp4").is_file(), reason="../shared/data/faults/hdr is not here")
def test_an_hlg_file_is_told():
    (note,) = notes_of(DATA / "faults" / "hdr", cam1=["hlg.mp4"])
    assert note.startswith("cam1: hlg.mp4: colours in hlg bt2020; Blender's preview may show others")
