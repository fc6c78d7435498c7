"""The programme written without Blender: its pictures are the conformed ones, its sound is in time."""

import av
import numpy as np
import pytest
from coded_video import SIZE
from pictures import programme_frames
from two_cameras import CLICK_S, EXPECTED, FRAMES, click_track, make, shown

from mcsl_core.delivery.conform import conform
from mcsl_core.delivery.direct import VideoFormat, write_direct
from mcsl_core.delivery.quality import QUALITIES, STANDARD
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.edl import Look, Override
from mcsl_core.errors import Cancelled
from mcsl_core.media.writing import Encoding
from mcsl_core.progress import Silent
from mcsl_core.timing import FrameRange


def test_direct_and_conformed_pictures_agree_and_sound_is_in_sync(sources, tmp_path):
    edl = make(look=Look(True, True, False), centering=((0, 0.0, 0.0), (40, 14.0, -6.0)))
    lossless = Encoding(options={"preset": "ultrafast", "qp": "0"})
    source = ProgrammeSource(edl, sources)
    write_direct(source, tmp_path / "direct.mp4", video=VideoFormat(lossless, audio_channels=2))
    planes = [p.y for p in programme_frames(edl, sources)]
    with av.open(str(tmp_path / "direct.mp4")) as container:
        frames = [f.to_ndarray(format="yuv420p")[: SIZE[1]] for f in container.decode(video=0)]
    assert len(frames) == FRAMES
    assert all(np.array_equal(a, b) for a, b in zip(frames, planes, strict=True))
    done = conform(source, tmp_path / "out")
    conformed = []
    for chunk in done.chunks:
        with av.open(str(done.path(chunk))) as container:
            conformed += [f.to_ndarray(format="yuv420p")[: SIZE[1]] for f in container.decode(video=0)]
    worst = max(float(np.mean((a.astype(float) - b) ** 2)) for a, b in zip(conformed, planes, strict=True))
    assert 10 * np.log10(255**2 / worst) > 38
    sound = np.zeros(FRAMES * 1600 + 4096)
    with av.open(str(tmp_path / "direct.mp4")) as container:
        assert container.streams.audio[0].channels == 2
        for frame in container.decode(audio=0):
            start, data = round(frame.time * 48000), frame.to_ndarray()[0]
            sound[start : start + len(data)] = data
    found = np.correlate(sound, click_track(0.2, 0)[:480]).argmax()
    assert abs(int(found) - CLICK_S * 48000) <= 4


def test_direct_writes_other_sizes_and_stretches_and_leaves_nothing_when_stopped(sources, tmp_path):
    source = ProgrammeSource(make(), sources)
    write_direct(source, tmp_path / "small.mp4", video=VideoFormat(size=(128, 72)), piece=FrameRange(45, 60))
    assert shown(tmp_path / "small.mp4") == EXPECTED[45:60]

    class Stops(Silent):
        def advance(self, done):
            if done > 3:
                raise Cancelled

    with pytest.raises(Cancelled):
        write_direct(source, tmp_path / "stopped.mp4", progress=Stops())
    assert [p.name for p in tmp_path.iterdir()] == ["small.mp4"]


def luma(path):
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="yuv420p")[: SIZE[1]] for frame in container.decode(video=0)]


LOSSLESS = VideoFormat(Encoding(options={"preset": "ultrafast", "qp": "0"}))


def test_what_is_conformed_is_taken_from_there_and_the_rest_is_made(sources, tmp_path):
    source, folder = ProgrammeSource(make(), sources), tmp_path / "out"
    done = conform(source, folder)
    assert len(done.chunks) > 1, "for one to be there and one not"
    chunks = {chunk.range: luma(done.path(chunk)) for chunk in done.chunks}
    done.path(done.chunks[1]).unlink()
    write_direct(source, tmp_path / "anew.mp4", video=LOSSLESS)
    write_direct(source, tmp_path / "taken.mp4", video=LOSSLESS, conformed=folder)
    anew, taken = luma(tmp_path / "anew.mp4"), luma(tmp_path / "taken.mp4")
    assert len(taken) == FRAMES
    for n, chunk in enumerate(done.chunks):
        for frame in chunk.range:
            expected = anew[frame] if n == 1 else chunks[chunk.range][frame - chunk.range.start]
            assert np.array_equal(taken[frame], expected), frame
    some = FrameRange(done.chunks[0].range.stop - 5, done.chunks[1].range.start + 7)
    write_direct(source, tmp_path / "some.mp4", video=LOSSLESS, piece=some, conformed=folder)
    assert all(np.array_equal(a, taken[n]) for a, n in zip(luma(tmp_path / "some.mp4"), some, strict=True))


def test_conformed_pictures_of_other_decisions_or_another_quality_are_not_taken(sources, tmp_path):
    folder = tmp_path / "out"
    conform(ProgrammeSource(make(), sources), folder)
    changed = make(overrides=(Override(FrameRange(0, 5), camera="b"), Override(FrameRange(40, FRAMES), camera="a")))
    for name, edl, quality in (("changed", changed, STANDARD), ("fine", make(), QUALITIES["fine"])):
        source = ProgrammeSource(edl, sources)
        write_direct(source, tmp_path / f"{name}.mp4", video=LOSSLESS)
        write_direct(source, tmp_path / f"{name}-2.mp4", video=LOSSLESS, conformed=folder, quality=quality)
        both = (luma(tmp_path / f"{name}.mp4"), luma(tmp_path / f"{name}-2.mp4"))
        assert all(
            np.array_equal(a, b) for a, b in list(zip(*both, strict=True))[: 30 if name == "changed" else FRAMES]
        )
