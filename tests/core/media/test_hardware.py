"""Decoding hardware: whatever the machine has, the pictures come; what was asked for and is not there is told."""

from __future__ import annotations

import numpy as np
import pytest
from av.codec.hwaccel import hwdevices_available
from coded_video import read_number, write_coded
from notes import Notes

from mcsl_core.errors import MediaError, UsageError
from mcsl_core.media.frames import to_planes
from mcsl_core.media.hardware import AUTO, NONE, accelerations, check_hwaccel
from mcsl_core.media.opening import open_file
from mcsl_core.media.probing import probe
from mcsl_core.media.reading import VideoReader
from mcsl_core.recording.decoding import tell_of_hardware


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    path = tmp_path_factory.mktemp("hardware") / "a.mp4"
    write_coded(path, range(12))
    return path


def pictures(path, hwaccel):
    facts = probe(path)
    reader = VideoReader(facts, hwaccel=hwaccel)
    try:
        return [to_planes(frame, facts).y.copy() for _, frame in reader.read(facts.start_s)]
    finally:
        reader.close()


@pytest.mark.parametrize("hwaccel", [AUTO, "cuda", "vaapi", "videotoolbox", "d3d11va", *hwdevices_available()])
def test_the_pictures_are_the_same_whatever_decodes_them(film, hwaccel):
    check_hwaccel(hwaccel)
    made = pictures(film, hwaccel)
    assert [read_number(picture) for picture in made] == list(range(12))
    assert all(np.array_equal(a, b) for a, b in zip(made, pictures(film, NONE), strict=True))


def test_what_no_machine_has_is_refused_and_what_this_one_may_have_is_named():
    with pytest.raises(UsageError, match=r"no decoding hardware called 'magic'.*auto, none"):
        check_hwaccel("magic")
    assert list(accelerations(NONE)) == []
    assert len(list(accelerations(AUTO))) == len(hwdevices_available())


def test_nothing_is_told_where_nothing_was_asked_for(film):
    told = Notes()
    tell_of_hardware(NONE, [(film, None)], told)
    assert told.notes == []


def test_what_hardware_does_not_decode_is_told(film):
    with open_file(film, hwaccel=AUTO) as container:
        there = container.streams.video[0].codec_context.is_hwaccel
    told = Notes()
    tell_of_hardware(AUTO, [(film, None)], told)
    expected = [] if there else ["hardware (auto) decodes no file; the processor decodes 1 file"]
    assert told.notes == expected


def test_a_file_that_is_none_is_told_as_without_hardware(tmp_path):
    path = tmp_path / "b.mp4"
    path.write_bytes(b"no video at all")
    with pytest.raises(MediaError, match="cannot be opened as a video"):
        open_file(path, hwaccel=AUTO)
