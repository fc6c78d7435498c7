"""What leaves the house says nothing of where it came from; searched for in the bytes, not with a reader of ours."""

from __future__ import annotations

import hashlib
from datetime import datetime
from fractions import Fraction
from pathlib import Path

import attrs
import av
import numpy as np
import pytest
from sound_files import RATE, voice
from traces import MARK, traces

from mcsl_core.errors import MediaError
from mcsl_core.imaging.planes import Planes
from mcsl_core.media.stripping import strip
from mcsl_core.media.writing import Encoding, VideoWriter


def content(path: Path) -> str:
    """A digest of all decoded pictures and samples with their times."""
    digest = hashlib.sha256()
    for kind in ("video", "audio"):
        with av.open(str(path)) as container:
            for frame in container.decode(**{kind: 0}):
                digest.update(frame.to_ndarray().tobytes())
                digest.update(f"{Fraction(frame.pts) * frame.time_base}".encode())
    return digest.hexdigest()


def pictures():
    rng = np.random.default_rng(1)
    return [np.roll(rng.integers(0, 255, (48, 64, 3), dtype=np.uint8), n, axis=1) for n in range(20)]


def write_marked(path: Path, codec: str, audio: str, pixel_format="yuv420p") -> Path:
    """A film as recorders write it: with banners, times, names, places, chapters, a time code, an attachment."""
    with av.open(str(path), "w", container_options={"movflags": "use_metadata_tags"}) as container:
        container.metadata.update(
            title=MARK,
            artist=MARK,
            creation_time="2026-11-25T08:15:00Z",
            location=f"+35.68+139.76/{MARK}",
            comment=MARK,
        )
        options = {"libx265": {"x265-params": "log-level=none"}, "libx264": {"preset": "veryfast"}}
        video = container.add_stream(codec, rate=25, options=options.get(codec, {}))
        video.width, video.height, video.pix_fmt = 64, 48, pixel_format
        video.metadata.update(title=MARK, handler_name=MARK, timecode="10:00:00:00", language="jpn")
        sound = container.add_stream(audio, rate=RATE, layout="stereo")
        sound.metadata.update(title=MARK, handler_name=MARK)
        if path.suffix == ".mkv":
            container.add_attachment(f"{MARK}.txt", "text/plain", MARK.encode())
        container.set_chapters(
            [{"id": 1, "start": 0, "end": 400, "time_base": Fraction(1, 1000), "metadata": {"title": MARK}}]
        )
        for index, picture in enumerate(pictures()):
            frame = av.VideoFrame.from_ndarray(picture, format="bgr24").reformat(format=pixel_format)
            frame.pts, frame.time_base = index, Fraction(1, 25)
            container.mux(video.encode(frame))
        container.mux(video.encode(None))
        samples = np.vstack([voice(0.8), voice(0.8, 1)]).T.reshape(1, -1)
        frame = av.AudioFrame.from_ndarray(np.ascontiguousarray(samples), format="flt", layout="stereo")
        frame.sample_rate, frame.pts, frame.time_base = RATE, 0, Fraction(1, RATE)
        container.mux(sound.encode(frame))
        container.mux(sound.encode(None))
    return path


@pytest.mark.parametrize(
    ("suffix", "codec", "audio", "pixel_format"),
    [
        (".mp4", "libx264", "aac", "yuv420p"),
        (".mov", "libx264", "pcm_s16le", "yuv420p"),
        (".mkv", "libx264", "flac", "yuv420p"),
        (".mp4", "libx265", "aac", "yuv420p"),
        (".mkv", "libx265", "libopus", "yuv420p"),
        (".mov", "prores_ks", "pcm_s16le", "yuv422p10le"),
        (".mp4", "libsvtav1", "libopus", "yuv420p"),
        (".mkv", "libvpx-vp9", "libopus", "yuv420p"),
        (".mkv", "ffv1", "flac", "yuv420p"),
    ],
)
def test_only_pictures_and_sound_are_left(tmp_path, suffix, codec, audio, pixel_format):
    path = write_marked(tmp_path / f"a{suffix}", codec, audio, pixel_format)
    assert MARK.encode() in traces(path)
    before = content(path)
    strip(path, tmp_path / f"clean{suffix}")
    assert traces(tmp_path / f"clean{suffix}") == []
    assert content(tmp_path / f"clean{suffix}") == before
    with av.open(str(tmp_path / f"clean{suffix}")) as container, av.open(str(path)) as source:
        assert [stream.type for stream in container.streams] == ["video", "audio"]
        assert not container.chapters()
        assert "creation_time" not in container.metadata
        video = container.streams.video[0]
        assert video.codec_context.codec_tag == source.streams.video[0].codec_context.codec_tag
        assert not {"timecode", "title"} & {name.lower() for s in container.streams for name in s.metadata}
    if suffix != ".mkv":
        data = (tmp_path / f"clean{suffix}").read_bytes()
        assert data.index(b"moov") < data.index(b"mdat")
        at = data.index(b"mvhd")
        assert data[at + 8 : at + 16] == bytes(8)  # neither made nor changed at any time


@pytest.mark.parametrize(
    ("suffix", "encoding", "audio"),
    [
        (".mp4", Encoding(), "aac"),
        (".mp4", Encoding(codec="libx265", options={"preset": "ultrafast", "x265-params": "log-level=none"}), "aac"),
        (".mov", Encoding(codec="prores_ks", options={}, pixel_format="yuv422p10le"), "pcm_s16le"),
        (".mkv", Encoding(codec="ffv1", options={}), "flac"),
        (".mkv", Encoding(codec="libvpx-vp9", options={"cpu-used": "8"}), "libopus"),
        (".mp4", Encoding(codec="libsvtav1", options={"preset": "12", "svtav1-params": "lp=1"}), "aac"),
        (".mkv", Encoding(codec="libx265", options={"preset": "ultrafast"}), "aac"),
    ],
)
def test_what_is_written_here_names_nobody(tmp_path, suffix, encoding, audio):
    encoding = attrs.evolve(encoding, audio_codec=audio, audio_options={})
    path = tmp_path / f"{MARK}{suffix}"
    with VideoWriter(path, size=(64, 48), rate=Fraction(25), encoding=encoding, audio_rate=RATE) as writer:
        for picture in pictures():
            writer.write(picture)
        writer.write_audio(voice(0.8)[0])
    assert traces(path) == []
    assert str(datetime.now().year).encode() not in path.read_bytes()[:4096]


def test_a_banner_gone_changes_no_picture(tmp_path):
    """Beside FFmpeg's own writing of the same pictures by the same encoder."""
    with av.open(str(tmp_path / "a.mp4"), "w") as container:
        stream = container.add_stream("libx264", rate=25, options={"preset": "superfast", "crf": "20"})
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        context = stream.codec_context
        context.color_primaries = context.color_trc = context.colorspace = context.color_range = 1
        frames = []
        for index, picture in enumerate(pictures()):
            frame = av.VideoFrame.from_ndarray(picture, format="bgr24").reformat(format="yuv420p")
            frames.append(frame.to_ndarray())
            frame.pts, frame.time_base = index, Fraction(1, 25)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    with VideoWriter(tmp_path / "b.mp4", size=(64, 48), rate=Fraction(25)) as writer:
        for array in frames:
            u, v = array[48:60].reshape(24, 32), array[60:].reshape(24, 32)
            writer.write(Planes(array[:48], u, v))
    decoded = []
    for name in "ab":
        with av.open(str(tmp_path / f"{name}.mp4")) as container:
            decoded.append(np.stack([frame.to_ndarray() for frame in container.decode(video=0)]))
    assert np.array_equal(*decoded)


def test_a_full_disk_is_told(tmp_path):
    path = write_marked(tmp_path / "a.mp4", "libx264", "aac")
    with pytest.raises(MediaError, match="freed of its metadata"):
        strip(path, tmp_path / "missing" / "b.mp4")
