"""Facts of files, against what PyAV finds by decoding them whole, and against the odd files others met."""

from fractions import Fraction

import av
import numpy as np
import pytest
from coded_video import DATA, SIZE, write_coded

from mcsl_core.errors import InputError, MediaError
from mcsl_core.media.facts import is_variable, nominal_rate
from mcsl_core.media.probing import probe
from mcsl_core.recording.discovery import discover

ODD = DATA / "odd"
needs_odd = pytest.mark.skipif(not ODD.is_dir(), reason="the folder ../shared/data/odd is not here")


@pytest.mark.parametrize("suffix", [".mp4", ".mkv", ".mov", ".ts", ".avi"])
@pytest.mark.parametrize("rate", [Fraction(30), Fraction(30000, 1001), Fraction(25)])
def test_rate_frames_and_duration(tmp_path, suffix, rate):
    path = write_coded(tmp_path / f"a{suffix}", range(70), rate=rate, bframes=0 if suffix == ".avi" else 2)
    facts = probe(path)
    assert facts.rate == rate
    assert facts.frames == 70
    assert facts.size == SIZE
    assert facts.start_s == 0
    assert abs(facts.duration_s - 70 / rate) < 0.002
    assert facts.usable_s == facts.end_s
    assert not facts.variable_rate
    assert not facts.truncated
    assert facts.keyframe_interval_s == pytest.approx(12 / rate, rel=0.15)
    assert not facts.has_audio


@pytest.mark.parametrize("text", ["00:00:1e9999999999", "0:0:9/0-----------", "N/A:N/A:N/A", "no:time:at:all"])
def test_a_matroska_duration_that_is_no_time_says_nothing(tmp_path, text):
    """The first of these never came back, the others were tracebacks."""
    path = write_coded(tmp_path / "a.mkv", range(70))
    written, said = path.read_bytes(), b"00:00:02.333000000"
    assert written.count(said) == 1
    path.write_bytes(written.replace(said, text.encode().ljust(len(said), b"\0")))
    facts = probe(path)
    assert (facts.frames, facts.truncated) == (70, False)


def test_variable_rate_is_told_from_rounding_and_from_a_slow_clock(tmp_path):
    rng = np.random.default_rng(3)
    stamps = np.cumsum(rng.integers(20, 70, 60)).tolist()
    assert probe(write_coded(tmp_path / "v.mp4", range(60), stamps=stamps, time_base=Fraction(1, 1000))).variable_rate
    slow = [round(i * 33.4001) for i in range(60)]
    assert not probe(write_coded(tmp_path / "s.mp4", range(60), stamps=slow, time_base=Fraction(1, 1000))).variable_rate
    assert is_variable(np.array([0, 1, 2, 3.6, 4, 5]))
    assert not is_variable(np.array([0, 1, 2, 3.4, 4, 5]))


def test_nominal_rate_keeps_ntsc_apart():
    assert nominal_rate(Fraction(29971, 1000)) == Fraction(30000, 1001)
    assert nominal_rate(Fraction(29999, 1000)) == 30
    assert nominal_rate(Fraction(1437, 100)) == Fraction(1437, 100)


def test_sound_rotation_and_aspect(tmp_path):
    path = write_coded(
        tmp_path / "a.mp4", range(30), sound=np.zeros(48000, np.float32), rotate=90, aspect=Fraction(4, 3)
    )
    facts = probe(path)
    assert facts.has_audio
    assert [(track.codec, track.rate, track.channels) for track in facts.audio_tracks] == [("aac", 48000, 1)]
    assert facts.coded_size == SIZE
    assert facts.rotation == 90
    assert facts.size == (144, 342)  # 256 * 4/3 = 341.3, then upright


@pytest.mark.parametrize("suffix", [".mp4", ".mov", ".mkv"])
@pytest.mark.parametrize("named", [True, False])
def test_a_cover_picture_is_not_the_film(tmp_path, suffix, named):
    """Named a cover, or a track of its own with a single picture in it, as large as it may be."""
    path = write_coded(tmp_path / "a.mp4", range(10))
    with av.open(str(path)) as film, av.open(str(tmp_path / f"b{suffix}"), "w") as both:
        cover = both.add_stream("mjpeg", rate=25)
        cover.width, cover.height, cover.pix_fmt = 800, 600, "yuvj420p"
        if named:
            cover.disposition = av.stream.Disposition.attached_pic
        copy = both.add_stream_from_template(film.streams.video[0])
        picture = av.VideoFrame.from_ndarray(np.zeros((600, 800, 3), np.uint8), format="bgr24")
        both.mux(cover.encode(picture.reformat(format="yuvj420p")))
        both.mux(cover.encode(None))
        for packet in film.demux(video=0):
            if packet.dts is not None:
                packet.stream = copy
                both.mux(packet)
    facts = probe(tmp_path / f"b{suffix}")
    assert (facts.codec, facts.size, facts.frames) == ("h264", SIZE, 10)


def test_truncated_files_are_named_and_used_as_far_as_they_go(tmp_path):
    whole = write_coded(tmp_path / "w.mp4", range(300), container_options={"movflags": "faststart"})
    part = tmp_path / "part.mp4"
    part.write_bytes(whole.read_bytes()[: whole.stat().st_size * 6 // 10])
    facts = probe(part)
    with av.open(str(part)) as container:
        there = 0
        try:
            for frame in container.decode(video=0):
                there = frame.time
        except av.error.FFmpegError:
            pass
    assert facts.truncated
    assert facts.duration_s == pytest.approx(10, abs=0.01)  # what it was to be: the next part starts there
    assert 2 < float(facts.usable_s) < 9
    assert float(facts.usable_s) == pytest.approx(there, abs=0.2)
    headless = tmp_path / "headless.mp4"
    headless.write_bytes(write_coded(tmp_path / "x.mp4", range(60)).read_bytes()[:9000])
    with pytest.raises(MediaError, match=r"headless\.mp4"):
        probe(headless)


def test_what_is_no_video_is_refused_with_a_remedy(tmp_path):
    (tmp_path / "text.mp4").write_text("not a film")
    with pytest.raises(MediaError, match="cannot be opened") as caught:
        probe(tmp_path / "text.mp4")
    assert caught.value.remedy
    with pytest.raises(MediaError):
        probe(tmp_path / "missing.mp4")


@needs_odd
@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("SAR-2by3.mp4", {"size": (426, 360), "rate": 30, "frames": 60, "has_audio": True}),
        ("counter.mp4", {"size": (1920, 1080), "rate": 10, "frames": 30, "has_audio": False}),
        ("delayed_start.mp4", {"size": (480, 320), "rate": 25, "frames": 24, "start_s": Fraction(43, 40)}),
        ("h264-png.mp4", {"size": (640, 360), "codec": "h264", "frames": 60}),
        ("test_yuv422p.mp4", {"pixel_format": "yuv422p", "frames": 60}),
        ("testsrc-hevc.mp4", {"codec": "hevc", "frames": 60}),
        ("testsrc_with_attachment.mkv", {"frames": 60, "rate": 30, "start_s": Fraction(23, 1000)}),
    ],
)
def test_odd_files(name, expected):
    facts = probe(ODD / name)
    assert {key: getattr(facts, key) for key in expected} == expected
    assert not facts.variable_rate
    assert not facts.truncated


def names(found):
    return [(name, [f.name for f in files]) for name, files in found]


def test_discover_a_folder(tmp_path):
    folder = tmp_path / "Größe 手術"
    folder.mkdir()
    film = write_coded(tmp_path / "film.mp4", range(5))
    for name in ("cam10.mp4", "cam2.mp4", "cam1_001.mp4", "cam1_000.mp4", "Kamera-Süd.MP4", ".hidden.mp4", "notes.txt"):
        (folder / name).write_bytes(film.read_bytes())
    (folder / "top").mkdir()
    for name in ("b.mp4", "a.mp4"):
        (folder / "top" / name).write_bytes(film.read_bytes())
    (folder / "empty").mkdir()
    assert names(discover([folder])) == [
        ("cam1", ["cam1_000.mp4", "cam1_001.mp4"]),
        ("cam2", ["cam2.mp4"]),
        ("cam10", ["cam10.mp4"]),
        ("Kamera-Süd", ["Kamera-Süd.MP4"]),
        ("top", ["a.mp4", "b.mp4"]),
    ]
    assert names(discover([folder / "cam2.mp4", folder / "cam10.mp4"])) == [
        ("cam2", ["cam2.mp4"]),
        ("cam10", ["cam10.mp4"]),
    ]


def test_discover_refuses(tmp_path):
    with pytest.raises(InputError, match="no video files"):
        discover([tmp_path])
    with pytest.raises(InputError, match="not exist"):
        discover([tmp_path / "nothing"])
    (tmp_path / "a.mp4").write_text("no film")
    with pytest.raises(InputError, match=r"a\.mp4"):
        discover([tmp_path])
    film = write_coded(tmp_path / "film.mp4", range(5))
    (tmp_path / "film.mkv").write_bytes(film.read_bytes())
    (tmp_path / "a.mp4").unlink()
    with pytest.raises(InputError, match="named 'film'"):
        discover([tmp_path])
