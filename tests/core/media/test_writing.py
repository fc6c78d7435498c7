"""What `VideoWriter` writes, read back with PyAV directly."""

from fractions import Fraction

import av
import cv2
import numpy as np
import pytest

from mcsl_core.errors import InputError, McslError, UsageError
from mcsl_core.imaging.planes import Planes, bgr_to_planes, planes_to_bgr
from mcsl_core.media.writing import Encoding, VideoWriter

RATE = Fraction(30000, 1001)
LOSSLESS = Encoding(options={"preset": "superfast", "qp": "0"})
HEVC = {"preset": "ultrafast", "crf": "20", "x265-params": "log-level=none"}
# BT.709 limited range codes of pure colours, from the standard: Y = 16 + 219 E'y, C = 128 + 224 E'c.
COLOURS = {
    "black": ((0, 0, 0), (16, 128, 128)),
    "white": ((255, 255, 255), (235, 128, 128)),
    "red": ((0, 0, 255), (63, 102, 240)),
    "green": ((0, 255, 0), (173, 42, 26)),
    "blue": ((255, 0, 0), (32, 240, 118)),
}


def decoded(path):
    with av.open(str(path)) as container:
        return [(f.time, f.to_ndarray(format="yuv420p")) for f in container.decode(video=0)]


def noise(shape, seed=0):
    picture = np.random.default_rng(seed).integers(0, 256, (*shape, 3), dtype=np.uint8)
    return cv2.GaussianBlur(picture, (0, 0), 3)


@pytest.mark.parametrize("name", COLOURS)
def test_colours_are_bt709_limited(tmp_path, name):
    bgr, codes = COLOURS[name]
    with VideoWriter(tmp_path / "a.mp4", size=(64, 48), rate=RATE, encoding=LOSSLESS) as writer:
        writer.write(np.full((48, 64, 3), bgr, np.uint8))
    picture = decoded(tmp_path / "a.mp4")[0][1]
    found = picture[:48].mean(), picture[48:60].mean(), picture[60:].mean()
    assert np.abs(np.array(found) - codes).max() <= 1, found
    with av.open(str(tmp_path / "a.mp4")) as container:
        context = container.streams.video[0].codec_context
        assert (context.colorspace, context.color_primaries, context.color_trc, context.color_range) == (1, 1, 1, 1)


def test_bgr_to_planes_and_back_is_close_and_chroma_is_left_sited():
    picture = noise((96, 128))
    again = planes_to_bgr(bgr_to_planes(picture))
    assert np.abs(again.astype(int) - picture).mean() < 1.5
    # A red ramp along x: chroma column i must carry the colour of luma column 2i, not of 2i + 0.5.
    ramp = np.zeros((8, 128, 3), np.uint8)
    ramp[..., 2] = np.arange(128) * 2
    planes = bgr_to_planes(ramp)
    slope = 224 / 255 * 0.5 * 2
    expected = 128 + slope * np.arange(0, 128, 2)
    assert np.abs(planes.v[2, 4:-4] - expected[4:-4]).mean() < 0.35  # half a luma column would be 0.44 more


def test_planes_pass_unchanged_at_constant_rate_from_zero(tmp_path):
    pictures = [bgr_to_planes(noise((48, 64), seed)) for seed in range(20)]
    for suffix in (".mp4", ".mov", ".mkv"):
        path = tmp_path / f"größe 日本{suffix}"
        with VideoWriter(path, size=(64, 48), rate=RATE, encoding=LOSSLESS, keyframe_interval=5) as writer:
            for planes in pictures:
                writer.write(planes)
        frames = decoded(path)
        assert len(frames) == 20
        tolerance = 6e-4 if suffix == ".mkv" else 1e-9  # Matroska counts in milliseconds
        for n, ((time, got), planes) in enumerate(zip(frames, pictures, strict=True)):
            assert abs(time - n / float(RATE)) < tolerance
            assert np.array_equal(got[:48], planes.y)
        with av.open(str(path)) as container:
            stream = container.streams.video[0]
            keys = [p.pts for p in container.demux(stream) if p.is_keyframe]
            assert len(keys) >= 4
            assert stream.average_rate == RATE
            metadata = {k.lower(): v for k, v in container.metadata.items()}
            assert "creation_time" not in metadata
            assert metadata.get("encoder", "Lavf") == "Lavf"  # Matroska demands a name; it carries no version


def test_same_input_same_bytes(tmp_path):
    for name in ("a", "b"):
        for suffix in (".mp4", ".mkv"):
            with VideoWriter(tmp_path / (name + suffix), size=(64, 48), rate=RATE, audio_rate=48000) as writer:
                for n in range(10):
                    writer.write(noise((48, 64), n))
                writer.write_audio(np.sin(np.arange(16000) / 20).astype(np.float32))
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()
    assert (tmp_path / "a.mkv").read_bytes() == (tmp_path / "b.mkv").read_bytes()


@pytest.mark.parametrize(
    ("suffix", "codec", "channels"),
    [(".mp4", "aac", 1), (".mp4", "aac", 2), (".mkv", "aac", 1), (".mov", "pcm_s16le", 2), (".mkv", "flac", 1)],
)
def test_sound_starts_in_sync_at_zero(tmp_path, suffix, codec, channels):
    """Clicks at known times come back at those times, priming and edit list taken into account."""
    rate, clicks = 48000, [4800, 30000, 70000]
    sound = np.zeros((96000, channels), np.float32)
    for click in clicks:
        sound[click : click + 64] = np.sin(np.arange(64) * 2 * np.pi / 16)[:, None] * 0.8
    options = {"b": "192k"} if codec == "aac" else {}
    encoding = Encoding(audio_codec=codec, audio_options=options)
    path = tmp_path / f"a{suffix}"
    with VideoWriter(
        path, size=(64, 48), rate=Fraction(25), encoding=encoding, audio_rate=rate, audio_channels=channels
    ) as writer:
        for n in range(50):
            writer.write(noise((48, 64), n))
            writer.write_audio(sound[n * 1920 : (n + 1) * 1920])
    with av.open(str(path)) as container:
        video = next(container.decode(video=0))
        assert video.time == 0
    got = np.zeros(97000 + 2048, np.float32)
    with av.open(str(path)) as container:
        for frame in container.decode(audio=0):
            start = round(frame.time * rate)
            data = frame.to_ndarray().astype(np.float32)
            mono = data[0] if frame.format.is_planar else data.reshape(-1, channels)[:, 0]
            assert start >= 0
            got[start : start + len(mono)] += mono / (32768 if "s16" in frame.format.name else 1)
            end = start + len(mono)
    assert abs(end - 96000) <= 1024
    for click in clicks:
        window = got[click - 2000 : click + 2000]
        found = np.argmax(np.correlate(window, sound[click : click + 64, 0], "valid")) + click - 2000
        assert abs(found - click) <= 2 + (48 if suffix == ".mkv" and codec == "aac" else 0)  # 1 ms: Matroska's clock


@pytest.mark.parametrize(
    ("suffix", "encoding", "pixel_format"),
    [
        (".mp4", Encoding("libx265", HEVC, tag="hvc1"), "yuv420p"),
        (".mov", Encoding("prores_ks", {"profile": "3"}, "yuv422p10le", "pcm_s16le", {}), "yuv422p10le"),
        (".mkv", Encoding("ffv1", {"level": "3", "slicecrc": "1"}, "yuv420p", "flac", {}), "yuv420p"),
    ],
)
def test_delivery_codecs(tmp_path, suffix, encoding, pixel_format):
    path = tmp_path / f"a{suffix}"
    pictures = [noise((96, 128), seed) for seed in range(5)]
    with VideoWriter(path, size=(128, 96), rate=RATE, encoding=encoding, audio_rate=48000, audio_channels=2) as writer:
        for picture in pictures:
            writer.write(picture)
        writer.write_audio(np.zeros((8008, 2), np.float32))
    with av.open(str(path)) as container:
        assert container.streams.audio[0].codec_context.name == encoding.audio_codec
        frames = list(container.decode(video=0))
    assert [f.format.name for f in frames] == [pixel_format] * 5
    for frame, picture in zip(frames, pictures, strict=True):
        planes = bgr_to_planes(picture)
        got = frame.to_ndarray(format="yuv420p")
        assert np.abs(got[:96].astype(int) - planes.y).mean() < 2
        u = got[96:120].reshape(48, 64)
        assert np.abs(u.astype(int) - planes.u).mean() < 2
        assert frame.colorspace == 1


def test_nothing_is_left_of_a_failed_file(tmp_path):
    def fail():
        with VideoWriter(tmp_path / "a.mp4", size=(64, 48), rate=RATE) as writer:
            writer.write(noise((48, 64)))
            raise RuntimeError("on purpose")

    with pytest.raises(RuntimeError, match="on purpose"):
        fail()
    assert list(tmp_path.iterdir()) == []


def test_faults_are_named(tmp_path):
    with pytest.raises(UsageError, match=r"\.avi"):
        VideoWriter(tmp_path / "a.avi", size=(64, 48), rate=RATE)
    with pytest.raises(UsageError, match="even"):
        VideoWriter(tmp_path / "a.mp4", size=(63, 48), rate=RATE)
    with (
        pytest.raises(UsageError, match="nosuch"),
        VideoWriter(tmp_path / "a.mp4", size=(64, 48), rate=RATE, encoding=Encoding(codec="nosuch")),
    ):
        pass
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="written"), VideoWriter(tmp_path / "file" / "a.mp4", size=(64, 48), rate=RATE):
        pass
    with pytest.raises(McslError, match="no picture"), VideoWriter(tmp_path / "a.mp4", size=(64, 48), rate=RATE):
        pass
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


ODD = [
    ({"options": {"preset": "fast", "crff": "12"}}, "libx264 knows no option 'crff'"),
    ({"audio_options": {"b": "128k", "zork": "1"}}, "aac knows no option 'zork'"),
    ({"codec": "aac"}, "aac is no video encoder"),
    ({"audio_codec": "libx264"}, "libx264 is no audio encoder"),
    ({"codec": "h264_foo"}, "there is no encoder 'h264_foo'"),
    ({"audio_codec": "foo"}, "there is no encoder 'foo'"),
]


@pytest.mark.parametrize(("settings", "told"), ODD, ids=[told for _, told in ODD])
def test_a_codec_or_an_option_that_is_none_is_named(tmp_path, settings, told):
    """A misspelled option was passed over without a word, and the film had another quality than was asked for."""
    with (
        pytest.raises(UsageError, match=told),
        VideoWriter(tmp_path / "a.mp4", size=(64, 64), rate=25, encoding=Encoding(**settings), audio_rate=48000),
    ):
        pass
    assert list(tmp_path.iterdir()) == []


def test_wrong_sizes_are_refused(tmp_path):
    with pytest.raises(ValueError, match="even"):
        bgr_to_planes(np.zeros((5, 6, 3), np.uint8))
    y = np.zeros((8, 8), np.uint8)
    with pytest.raises(ValueError, match="half-size"):
        Planes(y, y, y)
