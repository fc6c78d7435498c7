"""Pictures by programme time: numbers drawn into the pictures say which one came, the clock says which should."""

import math
import sys
import threading
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
import pytest
from coded_video import DATA, SIZE, coded_picture, read_number, write_coded

from mcsl_core.edl import Camera, Clock, Media
from mcsl_core.imaging.planes import bgr_to_planes, planes_to_bgr
from mcsl_core.media.probing import probe
from mcsl_core.media.reading import VideoReader
from mcsl_core.recording.decoder import Decoder
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.keyframe_sampling import sample_cameras
from mcsl_core.timing import FrameRange

NTSC = Fraction(30000, 1001)


def camera(name, *paths, size=SIZE, rate=Fraction(30), clock=None, gaps=()):
    media = tuple(Media(str(p), 1) for p in paths)
    return Camera(name=name, media=media, size=size, rate=rate, clock=clock or Clock(), gaps=gaps)


def footage(*cameras, rate=Fraction(30), frames=200):
    return Footage(cameras, rate=rate, frames=frames, base=Path("/"))


def numbers(planes):
    return [None if p is None else read_number(p.y) for p in planes]


@pytest.mark.parametrize("suffix", [".mp4", ".mkv", ".ts"])
@pytest.mark.parametrize("rate", [Fraction(30), NTSC])
@pytest.mark.parametrize("options", [None, {"preset": "veryfast", "bf": "3", "x264-params": "open-gop=1:b-pyramid=2"}])
def test_any_piece_has_the_right_pictures(tmp_path, suffix, rate, options):
    """B-frames, open and closed GOPs; every start, so that seeks land everywhere in a GOP."""
    path = write_coded(tmp_path / f"a{suffix}", range(80), rate=rate, gop=25, options=options)
    f = footage(camera("a", path), rate=rate, frames=90)
    assert numbers(f.planes("a", FrameRange(0, 90))) == [*range(80), *[None] * 10]
    for start in (1, 23, 24, 25, 26, 49, 50, 51, 77, 79):
        assert numbers(f.planes("a", FrameRange(start, min(start + 3, 80)))) == list(range(start, min(start + 3, 80)))


def test_a_closed_decoder_holds_no_frame(tmp_path):
    f = footage(camera("a", write_coded(tmp_path / "a.mp4", range(20))))
    decoder = Decoder(f.parts("a"), threads=1)
    shown = [f.shown("a", decoder, frame) for frame in (0, 1)]
    decoder.close()
    assert all(sys.getrefcount(one.frame) == 2 for one in shown)  # what was handed out, and the call's own
    assert read_number(f.full_picture("a", f.shown("a", decoder, 5)).y) == 5  # opened anew
    decoder.close()


def test_pictures_at_random_rising_frames(tmp_path):
    path = write_coded(tmp_path / "a.mp4", range(150), gop=30)
    f = footage(camera("a", path))
    wanted = [0, 1, 5, 37, 38, 90, 91, 149, 150, 199]
    got = list(f.pictures("a", wanted, height=72))
    assert [n for n, _ in got] == wanted
    assert [None if p is None else read_number(p) for _, p in got] == [0, 1, 5, 37, 38, 90, 91, 149, None, None]
    assert got[0][1].shape == (72, 128, 3)
    assert next(f.pictures("a", [3], height=9999))[1].shape == (144, 256, 3)
    with pytest.raises(ValueError, match="rise"):
        list(f.pictures("a", [5, 5]))


B_FRAMES = {"preset": "veryfast", "bf": "3", "x264-params": "b-pyramid=2"}


@pytest.mark.parametrize("early_s", [0.0, 0.2])
def test_a_glance_says_when_its_picture_was_taken(tmp_path, early_s):
    path = write_coded(tmp_path / "a.mp4", range(150), gop=30, options=B_FRAMES)
    f = footage(camera("a", path, clock=Clock(offset_s=0.5)))
    wanted = [20, 21, 26, 58, 59, 110, 111, 164, 165, 199]
    got = list(f.glances("a", wanted, height=144, early_s=early_s))
    assert [n for n, (picture, _) in zip(wanted, got, strict=True) if picture is None] == [165, 199]
    for asked, (picture, taken) in zip(wanted, got, strict=True):
        if picture is not None:
            assert taken == read_number(picture) + 15
            assert 0 <= asked - taken <= early_s * 30
    early = [asked - taken for asked, (_, taken) in zip(wanted, got, strict=True)]
    assert any(early) == (early_s > 0)


def test_a_slow_cameras_glance_is_of_the_very_picture(tmp_path):
    """Three pictures of fifteen a second that are left out would be more than the fifth of a second."""
    path = write_coded(tmp_path / "a.mp4", range(60), rate=Fraction(15), options=B_FRAMES)
    f = footage(camera("a", path, rate=Fraction(15)), rate=Fraction(15), frames=60)
    assert [read_number(p) for p, _ in f.glances("a", range(60), height=144, early_s=0.2)] == list(range(60))


def test_a_glance_is_nearly_the_picture(tmp_path):
    """Blocks' edges are not smoothed, which shows less than that it was coded."""
    path = write_coded(tmp_path / "a.mp4", range(60), gop=60, options={"preset": "medium", "crf": "28", "bf": "0"})
    f = footage(camera("a", path))
    smooth = [p for _, p in f.pictures("a", range(60), height=72)]
    rough = [p for p, _ in f.glances("a", range(60), height=72, early_s=0.0)]
    for number, (a, b) in enumerate(zip(smooth, rough, strict=True)):
        true = cv2.resize(coded_picture(number), (128, 72), interpolation=cv2.INTER_AREA)
        coding, skipped = (np.abs(a.astype(int) - other).mean() for other in (true, b))
        assert 0 < skipped < coding
    assert all(
        np.array_equal(a, b)
        for (_, a), (b, _) in zip(
            f.pictures("a", range(60), height=100), f.glances("a", range(60), height=100, early_s=0.0), strict=True
        )
    ), "what is hardly scaled is whole"


def test_pictures_have_the_colours_that_were_written(tmp_path):
    path = write_coded(tmp_path / "a.mkv", [7], options={"qp": "0", "preset": "veryfast"}, size=(1280, 720))
    f = footage(camera("a", path, size=(1280, 720)))
    _, full = next(f.pictures("a", [0]))
    expected = coded_picture(7, (1280, 720))
    assert np.abs(full[200:].astype(int) - expected[200:]).mean() < 1.5
    _, small = next(f.pictures("a", [0], height=180))
    assert (
        np.abs(small[50:].astype(int) - cv2.resize(expected, (320, 180), interpolation=cv2.INTER_AREA)[50:]).mean()
        < 1.5
    )


def test_offset_drift_and_rates(tmp_path):
    """Which frame is due follows from the clock alone, computed here in floats away from the edges."""
    path = write_coded(tmp_path / "a.mp4", range(250), rate=Fraction(25))
    clock = Clock(offset_s=1.013, drift_ppm=900.0)
    f = footage(camera("a", path, clock=clock), rate=NTSC, frames=330)
    got = numbers(f.planes("a", FrameRange(0, 330)))
    for n, number in enumerate(got):
        own = (n / float(NTSC) - 1.013) * (1 + 900e-6) * 25
        if abs(own - round(own)) < 0.01:
            continue
        expected = math.floor(own) if 0 <= own < 250 else None
        assert number == expected, n


def test_decimal_offsets_hit_the_frame(tmp_path):
    """0.2 s is six frames; the float 0.2 is not."""
    path = write_coded(tmp_path / "a.mp4", range(30))
    f = footage(camera("a", path, clock=Clock(offset_s=0.2)), frames=36)
    assert numbers(f.planes("a", FrameRange(0, 36))) == [*[None] * 6, *range(30)]
    f = footage(camera("a", path, clock=Clock(offset_s=-0.1)), frames=30)
    assert numbers(f.planes("a", FrameRange(0, 30))) == [*range(3, 30), *[None] * 3]


def test_variable_rate_shows_the_latest_that_has_come(tmp_path):
    rng = np.random.default_rng(5)
    stamps = [0, *np.cumsum(rng.integers(15, 90, 79)).tolist()]
    path = write_coded(tmp_path / "a.mp4", range(80), stamps=stamps, time_base=Fraction(1, 1000))
    f = footage(camera("a", path), frames=400)
    got = numbers(f.planes("a", FrameRange(0, 100)))
    assert got == [sum(s * 30 <= n * 1000 for s in stamps) - 1 for n in range(100)]
    some = [11, 40, 41, 70, 99]
    assert [read_number(p) for _, p in f.pictures("a", some)] == [got[n] for n in some]


def test_late_start_has_no_picture_before_it(tmp_path):
    stamps = [n + 30 for n in range(60)]
    path = write_coded(tmp_path / "late.mp4", range(60), stamps=stamps, gop=20)
    f = footage(camera("a", path), frames=90)
    assert numbers(f.planes("a", FrameRange(0, 90))) == [*[None] * 30, *range(60)]
    slightly = write_coded(
        tmp_path / "bit.mkv", range(10), stamps=[n * 33 + 23 for n in range(10)], time_base=Fraction(1, 1000)
    )
    f = footage(camera("a", slightly), frames=9)
    assert numbers(f.planes("a", FrameRange(0, 3)))[0] == 0


def test_several_files_play_one_after_another_and_gaps_are_empty(tmp_path):
    one = write_coded(tmp_path / "a_000.mp4", range(40), rate=NTSC)
    two = write_coded(tmp_path / "a_001.mkv", range(40, 70), rate=NTSC)
    three = write_coded(tmp_path / "a_002.ts", range(70, 100), rate=NTSC)
    f = footage(camera("a", one, two, three, gaps=(FrameRange(90, 95),)), rate=NTSC, frames=110)
    expected = [*range(90), *[None] * 5, *range(95, 100), *[None] * 10]
    assert numbers(f.planes("a", FrameRange(0, 110))) == expected
    assert numbers(f.planes("a", FrameRange(38, 42))) == [38, 39, 40, 41]
    some = [3, 39, 40, 69, 70, 92, 99]
    assert [None if p is None else read_number(p) for _, p in f.pictures("a", some)] == [3, 39, 40, 69, 70, None, 99]


def test_a_file_cut_short_ends_early_and_the_next_keeps_its_place(tmp_path):
    whole = write_coded(tmp_path / "w.mp4", range(200), container_options={"movflags": "faststart"})
    part = tmp_path / "a_000.mp4"
    part.write_bytes(whole.read_bytes()[: whole.stat().st_size * 6 // 10])
    after = write_coded(tmp_path / "a_001.mp4", range(200, 210))
    got = numbers(footage(camera("a", part, after), frames=210).planes("a", FrameRange(0, 210)))
    assert got[:40] == list(range(40))
    assert got[200:] == list(range(200, 210))
    last = max(n for n in got[:200] if n is not None)
    assert set(got[last + 3 : 200]) == {None}


@pytest.mark.parametrize("degrees", [90, 180, 270])
def test_rotated_files_come_upright(tmp_path, degrees):
    path = write_coded(tmp_path / "a.mp4", [5, 6], rotate=degrees)
    size = SIZE if degrees == 180 else SIZE[::-1]
    f = footage(camera("a", path, size=size))
    _, picture = next(f.pictures("a", [1]))
    assert picture.shape[1::-1] == size
    back = {90: cv2.ROTATE_90_CLOCKWISE, 180: cv2.ROTATE_180, 270: cv2.ROTATE_90_COUNTERCLOCKWISE}[degrees]
    assert read_number(cv2.rotate(picture, back)) == 6
    # The colours stand where the lightness stands: against turning the full-resolution picture.
    _, straight = next(footage(camera("b", write_coded(tmp_path / "b.mp4", [5, 6]))).pictures("b", [1]))
    assert np.abs(cv2.rotate(picture, back).astype(int) - straight)[40:].mean() < 2


def test_non_square_pixels_and_other_formats(tmp_path):
    path = write_coded(tmp_path / "a.mp4", [9, 10], aspect=Fraction(3, 2))
    _, picture = next(footage(camera("a", path, size=(384, 144))).pictures("a", [1]))
    assert picture.shape == (144, 384, 3)
    assert read_number(picture) == 10
    wide = write_coded(tmp_path / "b.mp4", [9, 10], pix_fmt="yuv422p", size=(1280, 720))
    _, picture = next(footage(camera("a", wide, size=(1280, 720))).pictures("a", [1]))
    assert np.abs(picture[200:].astype(int) - coded_picture(10, (1280, 720))[200:]).mean() < 3


def test_planes_are_views_of_what_the_decoder_made(tmp_path):
    path = write_coded(tmp_path / "a.mp4", range(3), size=(1280, 720), bframes=0)
    f = footage(camera("a", path, size=(1280, 720)))
    kept = [p for p in f.planes("a", FrameRange(0, 3)) if p is not None]
    assert all(not p.y.flags.owndata for p in kept)
    assert numbers(kept) == [0, 1, 2]  # still there after the decoder has gone on and closed


def test_samples_by_keyframes_and_by_sequence(tmp_path):
    short = write_coded(tmp_path / "short.mp4", range(300), gop=15)
    long = write_coded(tmp_path / "long.mkv", range(300), gop=250)
    f = footage(camera("s", short), camera("l", long, clock=Clock(offset_s=2.0)), frames=400)
    samples = list(sample_cameras(f, step_s=1.0, height=72))
    assert [s.frame for s in samples] == list(range(0, 400, 30))
    for s in samples:
        picture = s.pictures["s"]
        if s.frame >= 300:
            assert picture is None
        else:
            number = read_number(picture)
            assert number % 15 == 0
            assert abs(number - s.frame) <= 8
            assert number == s.shown_frames["s"]
            assert picture.shape == (72, 128, 3)
        if 60 <= s.frame < 360:
            # B-frames are left out, so the picture may be two or three old
            assert 0 <= s.frame - 60 - read_number(s.pictures["l"]) <= 3
            assert s.shown_frames["l"] - 60 == read_number(s.pictures["l"])
        elif s.frame < 60:
            assert s.pictures["l"] is None


def test_samples_stop_cleanly_and_raise_here(tmp_path):
    path = write_coded(tmp_path / "a.mp4", range(300), gop=15)
    f = footage(camera("a", path), camera("b", path), frames=300)
    before = threading.active_count()
    for sample in sample_cameras(f):
        assert sample.pictures["b"] is not None
        break
    assert threading.active_count() == before
    iterator = sample_cameras(f)
    next(iterator)
    iterator.close()
    assert threading.active_count() == before

    class Broken(Footage):
        def picture(self, *args):
            raise RuntimeError("decoder fell over")

    broken = Broken(f.cameras, rate=f.rate, frames=300, base=Path("/"))
    with pytest.raises(RuntimeError, match="fell over"):
        list(sample_cameras(broken))
    assert threading.active_count() == before


def chirp(seconds, rate=48000):
    t = np.arange(int(seconds * rate)) / rate
    return (0.5 * np.sin(2 * np.pi * (300 * t + 60 * t**2))).astype(np.float32)


@pytest.mark.parametrize("sound_rate", [48000, 44100])
@pytest.mark.parametrize(("suffix", "bound"), [(".mkv", 1e-3), (".mp4", 0.03)])
def test_audio_on_the_programme_clock(tmp_path, sound_rate, suffix, bound):
    """A chirp's phase tells the time to microseconds: offset and drift must put it where the clock says.

    One sample of lateness is an error of 0.04 rms. PCM shows the resampling alone; AAC by itself leaves 0.02.
    """
    path = write_coded(tmp_path / f"a{suffix}", range(300), sound=chirp(10, sound_rate), sound_rate=sound_rate)
    clock = Clock(offset_s=0.5, drift_ppm=200.0)
    f = footage(camera("a", path, clock=clock), frames=330)
    got = f.audio("a", 0.0, 11.0)
    assert got.shape == (11 * 48000,)
    assert np.abs(got[: int(0.49 * 48000)]).max() < 1e-3
    own = (np.arange(len(got)) / 48000 - 0.5) * (1 + 200e-6)
    expected = 0.5 * np.sin(2 * np.pi * (300 * own + 60 * own**2))
    inside = (own > 0.1) & (own < 9.8)
    error = got[inside] - expected[inside]
    assert np.sqrt(np.mean(error**2)) < bound
    assert np.abs(got[own > 10.05]).max() < 1e-3
    blocks = list(f.audio_blocks("a", 0.0, 11.0, block_s=0.7))
    assert np.allclose(np.concatenate(blocks), got, atol=2e-3)
    if suffix == ".mp4":  # Matroska's clock of 1 ms shows where reading begins inside a file
        late = f.audio("a", 6.0, 7.0)
        assert np.sqrt(np.mean((late - got[6 * 48000 : 7 * 48000]) ** 2)) < 0.02  # half a sample at most


def test_audio_of_several_files_and_of_none(tmp_path):
    sound = chirp(10)
    one = write_coded(tmp_path / "a_000.mkv", range(150), sound=sound[: 5 * 48000])
    two = write_coded(tmp_path / "a_001.mkv", range(150), sound=sound[5 * 48000 :])
    mute = write_coded(tmp_path / "m.mp4", range(30))
    f = footage(camera("a", one, two), camera("m", mute), frames=300)
    got = f.audio("a", 0, 10)
    assert np.abs(got - sound).max() < 2e-3
    assert not f.audio("m", 0, 1).any()


def test_frames_reach_the_same_picture_from_both_sides():
    pair = DATA / "four_cameras" / "pair"
    if not pair.is_dir():
        pytest.skip("the folder ../shared/data/four_cameras is not here")
    path = pair / "cam02.mp4"
    facts = probe(path)
    reader = VideoReader(facts)
    whole = {time: frame.to_ndarray()[:99].copy() for time, frame in reader.read(Fraction(0))}
    assert len(whole) == facts.frames
    for goal in (Fraction(1, 2), Fraction(1), Fraction(3, 2)):
        time, frame = next(iter(VideoReader(facts).read(goal)))
        assert time <= goal < time + 1 / facts.rate
        assert np.array_equal(frame.to_ndarray()[:99], whole[time])
    reader.close()


@pytest.mark.parametrize(
    "name", ["SAR-2by3.mp4", "h264-png.mp4", "test_yuv422p.mp4", "testsrc-hevc.mp4", "counter.mp4"]
)
def test_odd_files_play(name):
    path = DATA / "odd" / name
    if not path.is_file():
        pytest.skip("the folder ../shared/data/odd is not here")
    facts = probe(path)
    f = footage(camera("a", path, size=facts.size), rate=facts.rate, frames=facts.frames)
    shown = list(f.planes("a", FrameRange(0, facts.frames)))
    assert all(p is not None and p.size == facts.size for p in shown)
    assert len({id(p) for p in shown}) == facts.frames


def test_round_trip_of_planes_at_reduced_height():
    picture = cv2.GaussianBlur(np.random.default_rng(0).integers(0, 256, (200, 320, 3), dtype=np.uint8), (0, 0), 4)
    small = planes_to_bgr(bgr_to_planes(picture), height=50)
    expected = cv2.resize(picture, (80, 50), interpolation=cv2.INTER_AREA)
    assert np.abs(small.astype(int) - expected).mean() < 1.5
