"""Files with timestamps in decoding order: every picture is shown, in order, wherever reading begins."""

from fractions import Fraction

import av
import numpy as np
import pytest
from coded_video import DATA, read_number, write_coded
from remuxed import remux

from mcsl_core.media.probing import probe
from mcsl_core.media.reading import VideoReader

B_FRAMES = {"preset": "veryfast", "bf": "3", "x264-params": "b-pyramid=2:scenecut=0"}
OPEN = {**B_FRAMES, "x264-params": "open-gop=1:b-pyramid=2:scenecut=0"}


def read(facts, from_s=Fraction(0), **how):
    reader = VideoReader(facts, **how)
    got = [(time, read_number(frame.to_ndarray(format="gray"))) for time, frame in reader.read(from_s)]
    reader.close()
    return got


@pytest.mark.parametrize("options", [B_FRAMES, OPEN], ids=["closed", "open"])
@pytest.mark.parametrize("kind", ["avi", "mkv"])
@pytest.mark.parametrize("threads", [0, 1])
def test_every_picture_comes_in_order_from_anywhere(tmp_path, options, kind, threads):
    path = write_coded(tmp_path / "a.avi", range(120), options=options, gop=25)
    if kind == "mkv":
        path = remux(path, tmp_path / "a.mkv", pts_of_dts=True)
    facts = probe(path)
    assert facts.decoding_order
    assert facts.start_s == 0
    got = read(facts, threads=threads, skip="NONREF")
    assert [number for _, number in got] == list(range(120))
    assert [round(float(time * 30), 1) for time, _ in got] == pytest.approx(range(120), abs=0.1)
    for frame in (3, 24, 25, 26, 49, 52, 77, 110, 119):
        first = read(facts, Fraction(frame, 30), threads=threads)[:3]
        assert [number for _, number in first] == list(range(frame, min(120, frame + 3)))


@pytest.mark.parametrize("options", [{"bf": "2", "b": "800k"}, {"bf": "0", "b": "800k"}])
def test_mpeg_4_in_avi_comes_in_order(tmp_path, options):
    path = write_coded(tmp_path / "a.avi", range(60), codec="mpeg4", options=options)
    assert [number for _, number in read(probe(path))] == list(range(60))
    assert [number for _, number in read(probe(path), Fraction(31, 30))] == list(range(31, 60))


def test_right_timestamps_are_left_alone(tmp_path):
    for name in ("a.mp4", "a.mkv", "a.ts"):
        assert not probe(write_coded(tmp_path / name, range(40), options=OPEN)).decoding_order
    assert not probe(write_coded(tmp_path / "b.mp4", range(40), bframes=0)).decoding_order


def test_a_recorder_s_avi():
    path = DATA / "faults" / "avi-h264-bframes" / "cam1.avi"
    if not path.is_file():
        pytest.skip("the folder ../shared/data/faults/avi-h264-bframes is not here")
    with av.open(str(path)) as container:
        whole = [frame.to_ndarray(format="gray") for frame in container.decode(video=0)]
    reader = VideoReader(probe(path))
    for begin in (0, 37, 38, 151, 299):
        got = list(reader.read(Fraction(begin, 25)))
        assert [time for time, _ in got] == [Fraction(n, 25) for n in range(begin, 300)]
        assert all(np.array_equal(f.to_ndarray(format="gray"), w) for (_, f), w in zip(got, whole[begin:], strict=True))
