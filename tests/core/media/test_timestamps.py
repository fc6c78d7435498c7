"""The rate of a file's pictures from its timestamps: lost pictures, absurd declarations, jitter."""

from fractions import Fraction

import av
import numpy as np
import pytest
from coded_video import DATA, read_number, write_coded

from mcsl_core.edl import Camera, Media
from mcsl_core.errors import MediaError
from mcsl_core.media import probing
from mcsl_core.media.probing import probe
from mcsl_core.media.reading import VideoReader
from mcsl_core.media.timestamps import frame_rate, set_back
from mcsl_core.recording.footage import Footage
from mcsl_core.timing import FrameRange

NTSC = Fraction(30000, 1001)
MS = Fraction(1, 1000)


@pytest.mark.parametrize("suffix", [".mp4", ".mkv", ".ts"])
@pytest.mark.parametrize("lost", [{7}, {40}, {1}, {5, 6, 7, 30}, set(range(20, 34)), {2, 10, 18, 26, 34, 42}])
def test_lost_pictures_do_not_change_the_rate(tmp_path, suffix, lost):
    kept = [n for n in range(50) if n not in lost]
    stamps = [n * 1001 for n in kept]
    path = write_coded(tmp_path / f"a{suffix}", kept, rate=NTSC, stamps=stamps, time_base=Fraction(1, 30000))
    facts = probe(path)
    assert facts.rate == NTSC
    assert facts.duration_s == pytest.approx(50 / NTSC, abs=2e-3)


@pytest.mark.parametrize("declared", [None, Fraction(1000), Fraction(90000), Fraction(0), Fraction(1, 90000)])
@pytest.mark.parametrize("rate", [Fraction(25), NTSC, Fraction(30), Fraction(60), Fraction(15), Fraction(240)])
def test_an_absurd_declaration_is_not_believed(declared, rate):
    tick = Fraction(1, 90000)
    assert frame_rate([round(n / rate / tick) for n in range(200)], tick, declared) == rate


def test_jitter_without_a_declared_rate_gives_the_usual_one_nearest_to_the_mean():
    rng = np.random.default_rng(2)
    for mean_ms, rate in ((39.1, 25), (40.4, 25), (33, 30), (16.9, Fraction(60000, 1001)), (66, 15)):
        stamps = np.cumsum(rng.choice([0.7, 1.0, 1.25, 1.05], 4000) * mean_ms).astype(int).tolist()
        for declared in (None, Fraction(1000)):
            assert frame_rate(stamps, MS, declared) == rate, (mean_ms, declared)


def test_what_timestamps_leave_open_the_headers_say():
    stamps = [round(n * 1001 / 30) for n in range(30)]
    assert frame_rate(stamps, MS, NTSC) == NTSC
    phone = np.cumsum(np.random.default_rng(1).integers(20, 70, 60)).tolist()
    assert frame_rate(phone, MS, Fraction(30)) == 30
    assert frame_rate([0], MS, NTSC) == NTSC
    assert frame_rate([], MS, Fraction(1000)) == 25
    assert frame_rate([5, 5, 5], MS, None) == 25
    fast = [n * 2 for n in range(500)]  # 500 a second, really
    assert frame_rate(fast, MS, Fraction(500)) == 500


def test_timestamps_that_come_twice_are_read(tmp_path):
    """Of two pictures of one time the later is shown, and the rate is that of the times."""
    film = write_coded(tmp_path / "a.mp4", range(60), bframes=0, rate=Fraction(60))
    path = tmp_path / "twice.mkv"
    with av.open(str(film)) as source, av.open(str(path), "w") as out:
        copy = out.add_stream_from_template(source.streams.video[0])
        for packet in source.demux(video=0):
            if packet.dts is not None:
                number = round(packet.pts * packet.time_base * 60)
                packet.pts = packet.dts = round(Fraction(number // 2, 30) / packet.time_base)
                packet.stream = copy
                out.mux(packet)
    facts = probe(path)
    assert facts.rate == 30
    camera = Camera("a", (Media(str(path), 60),), facts.size, facts.rate)
    footage = Footage([camera], rate=facts.rate, frames=29, base=tmp_path)
    assert [read_number(p.y) for p in footage.planes("a", FrameRange(0, 29)) if p] == list(range(1, 59, 2))


def test_pictures_that_an_edit_list_leaves_out_are_left_out(tmp_path):
    """Timestamps below 0: players and editors begin with the picture at 0."""
    facts = probe(write_coded(tmp_path / "a.mp4", range(60), stamps=[n - 5 for n in range(60)]))
    assert facts.start_s == 0
    assert facts.duration_s == pytest.approx(55 / 30, abs=1e-3)
    for begin in (0, 11):
        time, frame = next(VideoReader(facts).read(Fraction(begin, 30)))
        assert (time, read_number(frame.to_ndarray(format="gray"))) == (Fraction(begin, 30), begin + 5)


def test_a_file_of_one_picture_is_read(tmp_path):
    one = probe(write_coded(tmp_path / "one.mp4", [7]))
    assert (one.frames, one.rate) == (1, 30)
    assert one.duration_s == pytest.approx(1 / 30, abs=1e-3)


def test_a_browser_s_recording_states_no_rate():
    path = DATA / "faults" / "webm-1000-fps" / "cam1.webm"
    if not path.is_file():
        pytest.skip("the folder ../shared/data/faults/webm-1000-fps is not here")
    facts = probe(path)
    assert facts.rate == 25
    assert 285 <= facts.duration_s * facts.rate <= 300


@pytest.mark.parametrize(
    ("suffix", "codec", "options"),
    [
        (".h264", "libx264", {"preset": "ultrafast"}),
        (".hevc", "libx265", {"x265-params": "log-level=none"}),
        (".m2v", "mpeg2video", {}),
    ],
)
def test_raw_streams_are_refused_by_name_with_a_remedy(tmp_path, suffix, codec, options):
    path = write_coded(tmp_path / f"cam1{suffix}", range(20), codec=codec, options=options)
    with pytest.raises(MediaError, match="no timestamps") as caught:
        probe(path)
    assert caught.value.where == str(path)
    assert f"cam1{suffix}" in caught.value.remedy
    renamed = path.rename(tmp_path / "cam1.mpg")  # what it is counts, not what it is called
    with av.open(str(renamed)) as container:
        assert container.format.name in ("h264", "hevc", "mpegvideo")
    with pytest.raises(MediaError, match="no timestamps"):
        probe(renamed)


@pytest.mark.parametrize("options", [{"bf": "0"}, {"bf": "2"}])
def test_pictures_without_a_time_in_a_programme_stream_are_refused(tmp_path, options):
    """Many small pictures of H.264 share one of its blocks, which has one time."""
    path = write_coded(tmp_path / "cam1.mpg", range(60), codec="libx264", options=options)
    with pytest.raises(MediaError, match=r"\d+ of 6\d pictures have no time") as caught:
        probe(path)
    assert "cam1.mpg" in caught.value.remedy
    assert probe(write_coded(tmp_path / "cam2.mpg", range(60), codec="mpeg2video", options=options)).frames == 60


@pytest.mark.parametrize("large", [False, True])
@pytest.mark.parametrize("suffix", [".ts", ".mpg"])
def test_files_joined_end_to_end_are_refused_where_the_clock_is_set_back(tmp_path, monkeypatch, suffix, large):
    codec = {"codec": "mpeg2video", "options": {"bf": "2", "b": "2M"}} if suffix == ".mpg" else {}
    one, two = (write_coded(tmp_path / f"{n}{suffix}", range(150), **codec) for n in "ab")
    if large:
        monkeypatch.setattr(probing, "_WHOLE_BYTES", 1000)
    assert probe(one).rate == 30
    joined = tmp_path / f"joined{suffix}"
    joined.write_bytes(one.read_bytes() + two.read_bytes())
    with pytest.raises(MediaError, match=r"set back after [45]\.\d s") as caught:
        probe(joined)
    assert "ffmpeg -i joined" in caught.value.remedy


@pytest.mark.parametrize("options", [{}, {"movflags": "faststart"}, {"movflags": "frag_keyframe+empty_moov"}])
@pytest.mark.parametrize("suffix", [".mp4", ".mov"])
def test_mp4s_joined_end_to_end_are_refused(tmp_path, suffix, options):
    """FFmpeg plays the first alone."""
    one, two = (write_coded(tmp_path / f"{n}{suffix}", range(60), container_options=options) for n in "ab")
    assert probe(one).duration_s == 2
    joined = tmp_path / f"joined{suffix}"
    joined.write_bytes(one.read_bytes() + two.read_bytes())
    with pytest.raises(MediaError, match="holds two films or more") as caught:
        probe(joined)
    assert caught.value.where == str(joined)
    joined.write_bytes(one.read_bytes() + bytes(300_000))  # a recorder's padding
    assert probe(joined).duration_s == 2


def test_an_mxf_without_its_index_is_refused_with_a_way_to_save_it(tmp_path):
    path = write_coded(tmp_path / "cam1.mxf", range(120), codec="mpeg2video", options={"b": "2M"}, gop=25)
    assert probe(path).duration_s == 4
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 6 // 10])
    with pytest.raises(MediaError, match="MXF file that was cut short") as caught:
        probe(path)
    assert "ffmpeg -i cam1.mxf" in caught.value.remedy


def test_one_wrong_timestamp_is_no_clock_set_back():
    stamps = list(range(0, 300000, 3000))
    assert set_back(stamps, Fraction(1, 90000), lasting=10) is None
    stamps[50] = 7
    assert set_back(stamps, Fraction(1, 90000), lasting=10) is None
    assert set_back(stamps + stamps[:30], Fraction(1, 90000), lasting=10) == Fraction(297000, 90000)


def test_a_recording_joined_by_cat():
    path = DATA / "faults" / "ts-joined-by-cat" / "cam1.ts"
    if not path.is_file():
        pytest.skip("the folder ../shared/data/faults/ts-joined-by-cat is not here")
    with pytest.raises(MediaError, match="set back after"):
        probe(path)
