"""Conformed media read back with PyAV and `wave` alone; keys change with what the pixels depend on and nothing else."""

import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
import wave
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import attrs
import av
import numpy as np
import pytest
from coded_video import SIZE, read_number, write_coded

from mcsl_core import edl as document
from mcsl_core.blender.timeline import in_place
from mcsl_core.compositing.placement import fully_covered
from mcsl_core.delivery import chunk_keys as chunking
from mcsl_core.delivery.chunk_keys import plan_chunks
from mcsl_core.delivery.conform import conform, default_folder
from mcsl_core.delivery.direct import programme_frames, write_direct
from mcsl_core.delivery.quality import DRAFT, FINE, QUALITIES, STANDARD, quality_named
from mcsl_core.edl import Camera, Clock, Colour, Edl, Look, Media, Override, Pose, Shot
from mcsl_core.errors import Cancelled, InputError, UsageError
from mcsl_core.filling.paper import PaperFiller
from mcsl_core.media.writing import Encoding
from mcsl_core.progress import Silent
from mcsl_core.timing import FrameRange

EYE = ((1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0))
FRAMES = 130
RATE = Fraction(30)
CLICK_S = 2.0


@pytest.fixture(autouse=True)
def short_chunks(monkeypatch):
    monkeypatch.setattr(chunking, "CHUNK_S", 1)


def click_track(seconds, at_s):
    sound = np.zeros(int(seconds * 48000), np.float32)
    start = round(at_s * 48000)
    sound[start : start + 480] = 0.7 * np.sin(2 * np.pi * 1000 * np.arange(480) / 48000)
    return sound


@pytest.fixture(scope="module")
def sources(tmp_path_factory):
    """Camera a shows n at programme frame n; b's clock began a second later, so that it shows n - 30."""
    folder = tmp_path_factory.mktemp("quellen ü")
    write_coded(folder / "a.mp4", range(FRAMES), sound=click_track(FRAMES / 30, CLICK_S))
    write_coded(folder / "b.mp4", range(FRAMES), gop=40)
    return folder


def make(**changes):
    cameras = (
        Camera("a", (Media("a.mp4", FRAMES),), SIZE, RATE),
        Camera("b", (Media("b.mp4", FRAMES),), SIZE, RATE, clock=Clock(offset_s=1.0)),
    )
    values = {
        "rate": RATE,
        "size": SIZE,
        "frames": FRAMES,
        "reference": "a",
        "cameras": cameras,
        "poses": (Pose(FrameRange(0, FRAMES), {"a": EYE, "b": EYE}),),
        "shots": (Shot(FrameRange(0, 50), "a"), Shot(FrameRange(50, FRAMES), "b")),
        "look": Look(centering=False, fill=False, colour=False),
        **changes,
    }
    return Edl(**values)


def shown(path):
    """The numbers in a file's pictures, and that its timestamps are 0, 1, 2 / rate."""
    with av.open(str(path)) as container:
        frames = list(container.decode(video=0))
    assert [round(f.time * 30, 3) for f in frames] == list(range(len(frames)))
    return [read_number(f.to_ndarray(format="gray")) for f in frames]


EXPECTED = [*range(50), *range(20, FRAMES - 30)]


def changed(before, after):
    return [a.range.start for a, b in zip(before, after, strict=True) if a.key != b.key]


def test_chunks_tile_the_programme(sources):
    chunks = plan_chunks(make(), sources)
    assert [c.range for c in chunks] == [FrameRange(s, min(s + 30, FRAMES)) for s in range(0, FRAMES, 30)]
    assert len({c.name for c in chunks}) == len(chunks)
    assert plan_chunks(make(), sources) == chunks


def test_keys_follow_what_the_pixels_depend_on(sources, tmp_path):
    base = plan_chunks(make(), sources)

    def diff(**changes):
        return changed(base, plan_chunks(make(**changes), sources))

    every = [0, 30, 60, 90, 120]
    assert diff(overrides=(Override(FrameRange(70, 75), camera="a"),)) == [60]
    assert diff(overrides=(Override(FrameRange(10, 40), camera="a"),)) == []  # what was chosen anyway
    assert diff(overrides=(Override(FrameRange(10, 40), note="nice"),)) == []
    assert diff(overrides=(Override(FrameRange(55, 95), fill=True),)) == [30, 60, 90]
    assert diff(shots=(Shot(FrameRange(0, 45), "a"), Shot(FrameRange(45, FRAMES), "b"))) == [30]
    assert diff(centering=((0, 5.0, 5.0),)) == []  # centering is off
    assert diff(poses=(Pose(FrameRange(0, FRAMES), {"a": EYE, "b": ((1.0, 0, 1), (0, 1.0, 0), (0, 0, 1.0))}),)) == [
        30,
        60,
        90,
        120,
    ]
    assert (
        diff(poses=(Pose(FrameRange(0, FRAMES), {"a": EYE, "b": EYE}, anchor=((1.0, 0, 1), (0, 1.0, 0), (0, 0, 1.0))),))
        == every
    )
    grey = Colour(((1.0, 0, 0, 0), (0, 0, 0, 128.0), (0, 0, 0, 128.0)))
    assert diff(poses=(Pose(FrameRange(0, FRAMES), {"a": EYE, "b": EYE}, colour={"b": grey}),)) == []  # colour is off
    cameras = make().cameras
    late = attrs.evolve(cameras[1], clock=Clock(offset_s=1.1))
    assert diff(cameras=(cameras[0], late)) == [30, 60, 90, 120]
    centred = make(look=Look(True, False, False), centering=((0, 0.0, 0.0), (60, 0.0, 0.0), (90, 9.0, 0.0)))
    moved = attrs.evolve(centred, centering=((0, 0.0, 0.0), (60, 0.0, 0.0), (90, 12.0, 0.0)))
    assert changed(plan_chunks(centred, sources), plan_chunks(moved, sources)) == [60, 90, 120]
    assert changed(base, plan_chunks(make(), sources, quality=DRAFT)) == every
    assert changed(base, plan_chunks(make(), sources, quality=attrs.evolve(STANDARD, resampling="lanczos"))) == every
    assert changed(base, plan_chunks(make(), sources, quality=attrs.evolve(STANDARD, group=7))) == every
    # Where the filler remembers the frames before, those of its block of ten seconds count too.
    remembered = plan_chunks(make(), sources, filler=PaperFiller())
    touched = plan_chunks(make(overrides=(Override(FrameRange(50, 59), camera="a"),)), sources, filler=PaperFiller())
    assert changed(remembered, touched) == [30, 60, 90, 120]


def test_a_plan_looks_at_the_cameras_footprints_once_a_pose_however_many_shots(sources, monkeypatch):
    asked = []
    covered = fully_covered
    monkeypatch.setattr(
        "mcsl_core.delivery.chunk_keys.fully_covered", lambda *given: asked.append(given) or covered(*given)
    )
    shots = tuple(Shot(FrameRange(n, n + 2), "ab"[n // 2 % 2]) for n in range(0, FRAMES, 2))
    edl = make(shots=shots, look=Look(True, True, False), centering=((0, 0.0, 0.0), (FRAMES - 1, 13.0, -5.0)))
    assert len(plan_chunks(edl, sources)) == 5
    assert [given[2] for given in asked] == [((0.0, -5.0), (13.0, 0.0))]


def test_keys_follow_the_content_of_sources_not_their_place(sources, tmp_path):
    elsewhere = tmp_path / "moved"
    shutil.copytree(sources, elsewhere)
    base = plan_chunks(make(), sources)
    assert plan_chunks(make(), elsewhere) == base
    with (elsewhere / "b.mp4").open("ab") as stream:
        stream.write(b"x")
    assert changed(base, plan_chunks(make(), elsewhere)) == [30, 60, 90, 120]
    (elsewhere / "b.mp4").unlink()
    with pytest.raises(InputError, match=r"b\.mp4"):
        plan_chunks(make(), elsewhere)


@pytest.mark.parametrize("jobs", [1, 2])
def test_chunks_hold_the_programme_and_runs_resume(sources, tmp_path, jobs):
    out = tmp_path / "out"
    done = conform(make(), sources, out, jobs=jobs)
    assert done.made == 5
    assert [n for chunk in done.chunks for n in shown(done.path(chunk))] == EXPECTED
    with av.open(str(done.path(done.chunks[0]))) as container:
        context = container.streams.video[0].codec_context
        assert (context.colorspace, context.color_range, context.pix_fmt) == (1, 1, "yuv420p")
    before = {p.name: p.stat().st_mtime_ns for p in out.iterdir()}
    assert conform(make(), sources, out, jobs=jobs).made == 0
    done.path(done.chunks[2]).unlink()
    assert conform(make(), sources, out, jobs=jobs).made == 1
    after = {p.name: p.stat().st_mtime_ns for p in out.iterdir()}
    assert set(before) == set(after)
    assert [n for n in before if before[n] != after[n]] == [done.chunks[2].name]


def test_an_override_makes_one_chunk_and_prune_removes_the_old(sources, tmp_path):
    first = conform(make(), sources, tmp_path)
    (tmp_path / "notes.txt").write_text("an editor's own file")
    edl = make(overrides=(Override(FrameRange(70, 75), camera="a"),))
    second = conform(edl, sources, tmp_path)
    assert second.made == 1
    expected = list(EXPECTED)
    expected[70:75] = range(70, 75)
    assert [n for chunk in second.chunks for n in shown(second.path(chunk))] == expected
    assert first.path(first.chunks[2]).is_file()
    third = conform(edl, sources, tmp_path, prune=True)
    assert third.made == 0
    assert {p.name for p in tmp_path.iterdir()} == {"notes.txt", second.audio.name, *(c.name for c in second.chunks)}


class StopsAfter(Silent):
    """Cancels once that many frames are reported."""

    def __init__(self, frames):
        super().__init__()
        self.frames, self.conforming = frames, False

    def stage(self, name, total=None, unit=""):
        self.conforming = name == "Conforming"

    def advance(self, done):
        if self.conforming and done >= self.frames:
            raise Cancelled


def test_a_stopped_run_leaves_whole_chunks_only(sources, tmp_path):
    with pytest.raises(Cancelled):
        conform(make(), sources, tmp_path, jobs=2, progress=StopsAfter(1))
    assert not list(tmp_path.glob(".*"))
    for path in tmp_path.glob("*.mp4"):
        shown(path)
    done = conform(make(), sources, tmp_path)
    assert [n for chunk in done.chunks for n in shown(done.path(chunk))] == EXPECTED


def test_stopping_does_not_wait_for_the_chunk_to_end(sources, tmp_path, monkeypatch):
    class Slow(PaperFiller):
        def fill(self, view):
            time.sleep(0.02)
            return view.front

    monkeypatch.setattr(chunking, "CHUNK_S", 100)
    edl = make(look=Look(False, True, False))
    with pytest.raises(Cancelled):
        conform(edl, sources, tmp_path, filler=Slow(), jobs=2, progress=StopsAfter(0))
    assert not list(tmp_path.glob("*.mp4"))


# A conform of a second a chunk that takes its time: 30 ms a frame, so that there is something to interrupt.
SLOWLY = """
import sys, time
from mcsl_core import chunks, filling
from mcsl_core.cli import main
chunks.CHUNK_S = 1
filling.FootprintFiller.fill = lambda self, view: time.sleep(0.03) or view.front
sys.exit(main(sys.argv[1:]))
"""


def slowly(edl, path, out):
    """A child process that conforms ``edl``, one chunk after another, and tells how far it is."""
    document.save(edl, path)
    call = [sys.executable, "-c", SLOWLY, "--progress", "json", "conform", path, "-o", out, "--jobs", "1"]
    return subprocess.Popen(call, cwd=Path(__file__).parents[3], stdout=subprocess.PIPE, text=True)


def test_a_killed_run_loses_what_it_was_at(sources, tmp_path):
    out, edl = tmp_path / "out", make(look=Look(False, True, False))
    child = slowly(edl, sources / "killed.json", out)
    until = time.monotonic() + 60
    while not list(out.glob("*.mp4")) and time.monotonic() < until:
        time.sleep(0.005)
    child.send_signal(signal.SIGKILL)
    assert child.stdout is not None
    child.stdout.close()
    assert child.wait() == -signal.SIGKILL
    survived = {path: path.stat().st_mtime_ns for path in out.glob("*.mp4")}
    assert 1 <= len(survived) < 5
    for path in survived:
        assert len(shown(path)) in (30, 10)
    for part in out.glob(".*.part"):
        os.utime(part, (1, 1))  # as if it were long ago
    done = conform(edl, sources, out)
    assert done.made == 5 - len(survived)
    assert {path: path.stat().st_mtime_ns for path in survived} == survived
    assert not list(out.glob(".*"))
    assert [n for chunk in done.chunks for n in shown(done.path(chunk))] == EXPECTED


def test_a_fault_in_a_job_comes_out_and_leaves_nothing_half_made(sources, tmp_path):
    class Fails(PaperFiller):
        def fill(self, view):
            if view.frame == 64:
                raise RuntimeError("no paint left")
            return super().fill(view)

    with pytest.raises(RuntimeError, match="no paint"):
        conform(make(look=Look(False, True, False)), sources, tmp_path, filler=Fails())
    assert not list(tmp_path.glob(".*"))


def workers():
    return [thread.name for thread in threading.enumerate() if thread.name.startswith("conform")]


def test_no_thread_is_left_however_it_ends(sources, tmp_path):
    before = threading.active_count()
    conform(make(), sources, tmp_path / "whole", jobs=2)
    assert not workers()
    with pytest.raises(Cancelled):
        conform(make(), sources, tmp_path / "stopped", jobs=2, progress=StopsAfter(1))
    assert not workers()
    assert threading.active_count() == before


def test_ctrl_c_leaves_whole_files_and_the_same_command_carries_on(sources, tmp_path):
    out, edl = tmp_path / "out", make(look=Look(False, True, False))
    child = slowly(edl, sources / "stopped.json", out)
    assert child.stdout is not None
    lines = (json.loads(line) for line in child.stdout)
    assert any(line.get("stage") == "Conforming" for line in lines)
    assert any(line.get("done") for line in lines)
    child.send_signal(signal.SIGINT)
    last = list(lines)[-1]
    child.stdout.close()
    assert child.wait() == 130
    assert last["error"]["exit_code"] == 130
    assert not list(out.glob(".*"))
    assert len(list(out.glob("*.mp4"))) < 5
    for path in out.glob("*.mp4"):
        assert len(shown(path)) in (30, 10)
    done = conform(edl, sources, out)
    assert [n for chunk in done.chunks for n in shown(done.path(chunk))] == EXPECTED


def test_only_the_cameras_that_are_needed_must_be_there(sources, tmp_path):
    folder = tmp_path / "one camera"
    folder.mkdir()
    shutil.copy(sources / "a.mp4", folder)
    edl = make(shots=(Shot(FrameRange(0, FRAMES), "a"),))
    done = conform(edl, folder, tmp_path / "out")
    assert [n for chunk in done.chunks for n in shown(done.path(chunk))] == list(range(FRAMES))
    with pytest.raises(InputError, match=r"b\.mp4"):  # the fill may look at it
        conform(attrs.evolve(edl, look=Look(False, True, False)), folder, tmp_path / "filled")


def groups(path):
    """How many frames lie between the keyframes of a file."""
    with av.open(str(path)) as container:
        packets = [packet for packet in container.demux(video=0) if packet.size]
    assert all(packet.pts == packet.dts for packet in packets)  # no B-frames: decoding order is showing order
    starts = [index for index, packet in enumerate(packets) if packet.is_keyframe]
    return {b - a for a, b in pairwise(starts)}


def test_qualities_lie_beside_each_other_and_a_timeline_takes_the_finest(sources, tmp_path):
    made = {name: conform(make(), sources, tmp_path, quality=quality) for name, quality in QUALITIES.items()}
    assert [done.made for done in made.values()] == [5, 5, 5]
    names = [chunk.name for done in made.values() for chunk in done.chunks]
    assert len(set(names)) == len(names)
    sizes = [sum(done.path(chunk).stat().st_size for chunk in done.chunks) for done in made.values()]
    assert sizes == sorted(sizes)

    def there(edl=None):
        pieces, _ = in_place(edl or make(), sources, tmp_path)
        return [Path(piece["path"]).name for piece in pieces]

    fine, standard, draft = ([c.name for c in made[name].chunks] for name in ("fine", "standard", "draft"))
    assert there() == fine
    made["fine"].path(made["fine"].chunks[1]).unlink()
    made["fine"].path(made["fine"].chunks[3]).unlink()
    made["standard"].path(made["standard"].chunks[3]).unlink()
    assert there() == [fine[0], standard[1], fine[2], draft[3], fine[4]]
    decided = make(overrides=(Override(FrameRange(70, 75), camera="a"),))
    assert there(decided) == [fine[0], standard[1], draft[3], fine[4]]
    again = conform(decided, sources, tmp_path, quality=DRAFT)
    assert again.made == 1
    assert there(decided) == [fine[0], standard[1], again.chunks[2].name, draft[3], fine[4]]


def test_groups_are_as_long_as_the_quality_says(sources, tmp_path, monkeypatch):
    monkeypatch.setattr(chunking, "CHUNK_S", 100)
    for quality in (STANDARD, attrs.evolve(STANDARD, group=13)):
        done = conform(make(), sources, tmp_path, quality=quality, jobs=1)
        assert groups(done.path(done.chunks[0])) == {quality.group}


def test_prune_keeps_what_is_as_good(sources, tmp_path):
    fine, draft = (conform(make(), sources, tmp_path, quality=quality) for quality in (FINE, DRAFT))
    conform(make(), sources, tmp_path, quality=DRAFT, prune=True)
    assert all(done.path(chunk).is_file() for done in (fine, draft) for chunk in done.chunks)
    conform(make(), sources, tmp_path, quality=FINE, prune=True)
    assert {path.name for path in tmp_path.glob("*.mp4")} == {chunk.name for chunk in fine.chunks}


def test_a_quality_has_a_name():
    assert quality_named("draft") is DRAFT
    assert [quality.name for quality in QUALITIES.values()] == list(QUALITIES)
    with pytest.raises(UsageError, match="draft, standard, fine"):
        quality_named("best")


def wav(path):
    with wave.open(str(path)) as sound:
        assert (sound.getnchannels(), sound.getsampwidth(), sound.getframerate()) == (1, 2, 48000)
        return np.frombuffer(sound.readframes(sound.getnframes()), "<i2") / 32768


def test_the_sound_lies_on_the_programme_clock(sources, tmp_path):
    done = conform(make(), sources, tmp_path / "one")
    sound = wav(done.audio)
    assert len(sound) == round(FRAMES / 30 * 48000)
    assert abs(int(np.argmax(np.abs(sound) > 0.2)) - CLICK_S * 48000) < 48 * 2
    cameras = make().cameras
    edl = make(cameras=(attrs.evolve(cameras[0], clock=Clock(offset_s=-0.5)), cameras[1]))
    moved = conform(edl, sources, tmp_path / "two")
    found = np.correlate(wav(moved.audio), click_track(0.2, 0)[:480]).argmax()
    assert abs(int(found) - (CLICK_S - 0.5) * 48000) <= 2
    assert moved.audio.name != done.audio.name
    assert conform(make(), sources, tmp_path / "three", audio_from="b").audio is None
    with pytest.raises(UsageError, match="'c'"):
        conform(make(), sources, tmp_path / "four", audio_from="c")


def test_direct_and_conformed_pictures_agree_and_sound_is_in_sync(sources, tmp_path):
    edl = make(look=Look(True, True, False), centering=((0, 0.0, 0.0), (40, 14.0, -6.0)))
    lossless = Encoding(options={"preset": "ultrafast", "qp": "0"})
    write_direct(edl, sources, tmp_path / "direct.mp4", encoding=lossless, audio_channels=2)
    planes = [p.y for p in programme_frames(edl, sources)]
    with av.open(str(tmp_path / "direct.mp4")) as container:
        frames = [f.to_ndarray(format="yuv420p")[: SIZE[1]] for f in container.decode(video=0)]
    assert len(frames) == FRAMES
    assert all(np.array_equal(a, b) for a, b in zip(frames, planes, strict=True))
    done = conform(edl, sources, tmp_path / "out")
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
    write_direct(make(), sources, tmp_path / "small.mp4", size=(128, 72), piece=FrameRange(45, 60))
    assert shown(tmp_path / "small.mp4") == EXPECTED[45:60]

    class Stops(Silent):
        def advance(self, done):
            if done > 3:
                raise Cancelled

    with pytest.raises(Cancelled):
        write_direct(make(), sources, tmp_path / "stopped.mp4", progress=Stops())
    assert [p.name for p in tmp_path.iterdir()] == ["small.mp4"]


def test_default_folder():
    assert default_folder(Path("/a/edl.json")) == Path("/a/edl.conformed")
