"""Interlaced films: each picture is its first field's moment, wherever it is read; the oracle is what was filmed."""

from fractions import Fraction

import av
import numpy as np
import pytest
from coded_video import DATA, write_coded
from interlaced_video import true_picture, write_interlaced

from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.media.frames import to_planes
from mcsl_core.media.probing import probe
from mcsl_core.media.reading import VideoReader
from mcsl_core.recording.decoder import Decoder, Part

FAULTS = DATA / "faults" / "interlaced"
WRITTEN = [
    ("h264", "a.mp4"), ("h264-open-gop", "a.ts"), ("mpeg2", "a.ts"), ("mpeg2", "a.mkv"), ("mpeg2-422", "a.mov"),
    ("prores", "a.mov"), ("ffv1", "a.mkv"),
]  # fmt: skip
# Woven pictures lie 27 to 29 dB from what was filmed, coded ones that were not interlaced 33 to 36.
GOOD_DB = 31.5


def psnr(picture, k) -> float:
    return 10 * np.log10(255**2 / np.mean((picture.astype(float) - true_picture(2 * k)) ** 2))


def all_pictures(reader):
    return [(time, to_planes(frame, reader.facts)) for time, frame in reader.read(Fraction(0))]


def keyframe(reader, near_s):
    found = reader.keyframe(near_s)
    assert found is not None
    return found


def same(a, b) -> bool:
    return all(np.array_equal(p, q) for p, q in zip(a, b, strict=True))


@pytest.mark.parametrize("first", ["top", "bottom"])
@pytest.mark.parametrize(("coding", "name"), WRITTEN)
def test_frames_are_whole_in_time_and_the_same_wherever_reading_begins(tmp_path, coding, name, first):
    facts = probe(write_interlaced(tmp_path / name, 30, coding=coding, first=first))
    reader = VideoReader(facts)
    pictures = all_pictures(reader)
    assert (len(pictures), facts.frames, facts.rate) == (30, 30, 25)
    assert [round(time * 25) for time, _ in pictures] == list(range(30))
    for k, (_, planes) in enumerate(pictures):
        assert psnr(planes_to_bgr(planes), k) > GOOD_DB
    for time, planes in pictures:
        found, frame = next(iter(reader.read(time)))
        assert found == time
        assert same(to_planes(frame, facts), planes)


@pytest.mark.parametrize(("coding", "name"), WRITTEN)
def test_single_keyframes_are_whole(tmp_path, coding, name):
    facts = probe(write_interlaced(tmp_path / name, 45, coding=coding))
    reader = VideoReader(facts)
    times = set()
    for asked in (Fraction(0), Fraction(1, 2), Fraction(1)):
        time, frame = keyframe(reader, asked)
        times.add(time)
        assert psnr(planes_to_bgr(to_planes(frame, facts)), round(time * 25)) > GOOD_DB
        assert same(to_planes(keyframe(reader, asked)[1], facts), to_planes(frame, facts))
    assert len(times) > 1


def test_pictures_are_whole_at_the_borders_of_parts(tmp_path):
    facts = [probe(write_interlaced(tmp_path / f"{part}.mp4", 20)) for part in range(2)]
    decoder = Decoder([Part(facts[0], Fraction(0)), Part(facts[1], facts[0].end_s)])
    for k in (0, 18, 19, 20, 21, 39):
        shown = decoder.at(Fraction(k, 25))
        assert shown is not None
        assert psnr(planes_to_bgr(to_planes(shown.frame, shown.facts)), k % 20) > GOOD_DB
    decoder.close()


@pytest.mark.parametrize("first", ["top", "bottom"])
def test_a_film_wrongly_called_progressive_is_found_by_its_motion(tmp_path, first):
    facts = probe(write_interlaced(tmp_path / "a.mp4", 30, first=first, flag="none"))
    with av.open(str(facts.path)) as container:
        assert not any(frame.interlaced_frame for frame in container.decode(video=0))
    assert facts.scan == first
    for k, (_, planes) in enumerate(all_pictures(VideoReader(facts))):
        assert psnr(planes_to_bgr(planes), k) > GOOD_DB - 1


@pytest.mark.parametrize(("coding", "name"), [("h264", "a.mp4"), ("mpeg2", "a.ts"), ("prores", "a.mov")])
def test_progressive_pictures_called_interlaced_stay_as_they_are(tmp_path, coding, name):
    facts = probe(write_interlaced(tmp_path / name, 20, coding=coding, content="progressive"))
    with av.open(str(facts.path)) as container:
        frames = list(container.decode(video=0))
    assert all(frame.interlaced_frame for frame in frames)
    for frame, (_, planes) in zip(frames, all_pictures(VideoReader(facts)), strict=True):
        assert same(to_planes(frame, facts), planes)


def test_a_progressive_film_is_read_without_the_filter(tmp_path):
    facts = probe(write_coded(tmp_path / "a.mp4", range(30)))
    assert (facts.scan, facts.conversions) == ("unflagged", ())
    with av.open(str(facts.path)) as container:
        for frame, (_, read) in zip(container.decode(video=0), VideoReader(facts).read(Fraction(0)), strict=True):
            assert read.pts == frame.pts  # untouched
            assert np.array_equal(read.to_ndarray(), frame.to_ndarray())


@pytest.mark.skipif(not FAULTS.is_dir(), reason="the folder ../shared/data/faults/interlaced is not here")
@pytest.mark.parametrize("name", ["cam1.mp4", "cam2.mp4"])
def test_a_filmed_lamp_does_not_comb(name):
    def combing(y):
        rows = y.astype(int)
        up, down = rows[1:-1] - rows[:-2], rows[1:-1] - rows[2:]
        return ((up * down > 0) & (np.minimum(abs(up), abs(down)) > 20)).sum()

    facts = probe(FAULTS / name)
    with av.open(str(facts.path)) as container:
        before = [combing(to_planes(frame, facts).y) for frame in container.decode(video=0)]
    after = [combing(planes.y) for _, planes in all_pictures(VideoReader(facts))]
    assert len(after) == len(before) == facts.frames
    assert sum(after) < 0.1 * sum(before)
