"""Conformed media read back with PyAV and `wave` alone: whole files, whatever stops a run, and sound in time."""

import json
import shutil
import signal
import subprocess
import sys
import threading
import time
import wave
from itertools import pairwise
from pathlib import Path

import attrs
import av
import numpy as np
import pytest
from cycles import left_in_cycles
from two_cameras import CLICK_S, EXPECTED, FRAMES, click_track, make, shown

from mcsl_core import edl as document
from mcsl_core.delivery import chunk_keys as chunking
from mcsl_core.delivery.conform import conform, default_folder
from mcsl_core.delivery.quality import DRAFT, FINE, STANDARD
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.edl import Clock, Look, Override, Shot
from mcsl_core.errors import Cancelled, InputError, UsageError
from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.filling.paper import PaperFiller
from mcsl_core.progress import Silent
from mcsl_core.timing import FrameRange


@pytest.mark.parametrize("jobs", [1, 2])
def test_chunks_hold_the_programme_and_runs_resume(sources, tmp_path, jobs):
    out = tmp_path / "out"
    done = conform(ProgrammeSource(make(), sources), out, jobs=jobs)
    assert done.made == 5
    assert [n for chunk in done.chunks for n in shown(done.path(chunk))] == EXPECTED
    with av.open(str(done.path(done.chunks[0]))) as container:
        context = container.streams.video[0].codec_context
        assert (context.colorspace, context.color_range, context.pix_fmt) == (1, 1, "yuv420p")
    before = {p.name: p.stat().st_mtime_ns for p in out.iterdir()}
    assert conform(ProgrammeSource(make(), sources), out, jobs=jobs).made == 0
    done.path(done.chunks[2]).unlink()
    assert conform(ProgrammeSource(make(), sources), out, jobs=jobs).made == 1
    after = {p.name: p.stat().st_mtime_ns for p in out.iterdir()}
    assert set(before) == set(after)
    assert {n for n in before if before[n] != after[n]} == {done.chunks[2].name, "mcsl-outputs.json"}


def test_an_override_makes_one_chunk_and_prune_removes_the_old(sources, tmp_path):
    first = conform(ProgrammeSource(make(), sources), tmp_path)
    (tmp_path / "notes.txt").write_text("an editor's own file")
    edl = make(overrides=(Override(FrameRange(70, 75), camera="a"),))
    second = conform(ProgrammeSource(edl, sources), tmp_path)
    assert second.made == 1
    expected = list(EXPECTED)
    expected[70:75] = range(70, 75)
    assert [n for chunk in second.chunks for n in shown(second.path(chunk))] == expected
    assert first.path(first.chunks[2]).is_file()
    third = conform(ProgrammeSource(edl, sources), tmp_path, prune=True)
    assert third.made == 0
    ours = {"mcsl-outputs.json", second.audio.name, *(c.name for c in second.chunks)}
    assert {p.name for p in tmp_path.iterdir()} == {"notes.txt", *ours}


@pytest.mark.parametrize("filler", [FootprintFiller(), PaperFiller()])
def test_what_chunks_are_made_with_is_freed_with_them(sources, tmp_path, filler):
    """Else the memory of a long recording grows until Python's garbage collector happens to come."""
    shutil.copytree(sources, tmp_path / "sources")  # files that nothing is known of yet
    edl = make(look=Look(centering=True, fill=True, colour=True))

    def run():
        assert conform(ProgrammeSource(edl, tmp_path / "sources", filler), tmp_path / "out", jobs=2).made == 5

    assert left_in_cycles(run) == set()


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
        conform(ProgrammeSource(make(), sources), tmp_path, jobs=2, progress=StopsAfter(1))
    assert not list(tmp_path.glob(".*"))
    for path in tmp_path.glob("*.mp4"):
        shown(path)
    done = conform(ProgrammeSource(make(), sources), tmp_path)
    assert [n for chunk in done.chunks for n in shown(done.path(chunk))] == EXPECTED


def test_stopping_does_not_wait_for_the_chunk_to_end(sources, tmp_path, monkeypatch):
    class Slow(PaperFiller):
        def fill(self, view):
            time.sleep(0.02)
            return view.front

    monkeypatch.setattr(chunking, "CHUNK_S", 100)
    edl = make(look=Look(False, True, False))
    with pytest.raises(Cancelled):
        conform(ProgrammeSource(edl, sources, Slow()), tmp_path, jobs=2, progress=StopsAfter(0))
    assert not list(tmp_path.glob("*.mp4"))


# A conform of a second a chunk. The first chunk takes a second; those after it take a minute, so that however late
# a busy machine lets the test look or signal, there is something to interrupt. A frame takes less than a stop waits.
SLOWLY = """
import sys, time
from mcsl_core.cli.main import main
from mcsl_core.delivery import chunk_keys
from mcsl_core.filling.footprint import FootprintFiller
chunk_keys.CHUNK_S = 1
FootprintFiller.fill = lambda self, view: time.sleep(0.03 if view.frame < 30 else 0.6) or view.front
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
    until = time.monotonic() + 300
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
    done = conform(ProgrammeSource(edl, sources), out)
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
        conform(ProgrammeSource(make(look=Look(False, True, False)), sources, Fails()), tmp_path)
    assert not list(tmp_path.glob(".*"))


def workers():
    return [thread.name for thread in threading.enumerate() if thread.name.startswith("conform")]


def test_no_thread_is_left_however_it_ends(sources, tmp_path):
    before = threading.active_count()
    conform(ProgrammeSource(make(), sources), tmp_path / "whole", jobs=2)
    assert not workers()
    with pytest.raises(Cancelled):
        conform(ProgrammeSource(make(), sources), tmp_path / "stopped", jobs=2, progress=StopsAfter(1))
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
    done = conform(ProgrammeSource(edl, sources), out)
    assert [n for chunk in done.chunks for n in shown(done.path(chunk))] == EXPECTED


def test_only_the_cameras_that_are_needed_must_be_there(sources, tmp_path):
    folder = tmp_path / "one camera"
    folder.mkdir()
    shutil.copy(sources / "a.mp4", folder)
    edl = make(shots=(Shot(FrameRange(0, FRAMES), "a"),))
    done = conform(ProgrammeSource(edl, folder), tmp_path / "out")
    assert [n for chunk in done.chunks for n in shown(done.path(chunk))] == list(range(FRAMES))
    with pytest.raises(InputError, match=r"b\.mp4"):  # the fill may look at it
        conform(ProgrammeSource(attrs.evolve(edl, look=Look(False, True, False)), folder), tmp_path / "filled")


def groups(path):
    """How many frames lie between the keyframes of a file."""
    with av.open(str(path)) as container:
        packets = [packet for packet in container.demux(video=0) if packet.size]
    assert all(packet.pts == packet.dts for packet in packets)  # no B-frames: decoding order is showing order
    starts = [index for index, packet in enumerate(packets) if packet.is_keyframe]
    return {b - a for a, b in pairwise(starts)}


def test_groups_are_as_long_as_the_quality_says(sources, tmp_path, monkeypatch):
    monkeypatch.setattr(chunking, "CHUNK_S", 100)
    for quality in (STANDARD, attrs.evolve(STANDARD, group=13)):
        done = conform(ProgrammeSource(make(), sources), tmp_path, quality=quality, jobs=1)
        assert groups(done.path(done.chunks[0])) == {quality.group}


def test_prune_keeps_what_is_as_good(sources, tmp_path):
    fine, draft = (conform(ProgrammeSource(make(), sources), tmp_path, quality=quality) for quality in (FINE, DRAFT))
    conform(ProgrammeSource(make(), sources), tmp_path, quality=DRAFT, prune=True)
    assert all(done.path(chunk).is_file() for done in (fine, draft) for chunk in done.chunks)
    conform(ProgrammeSource(make(), sources), tmp_path, quality=FINE, prune=True)
    assert {path.name for path in tmp_path.glob("*.mp4")} == {chunk.name for chunk in fine.chunks}


def wav(path):
    with wave.open(str(path)) as sound:
        assert (sound.getnchannels(), sound.getsampwidth(), sound.getframerate()) == (1, 2, 48000)
        return np.frombuffer(sound.readframes(sound.getnframes()), "<i2") / 32768


def test_the_sound_lies_on_the_programme_clock(sources, tmp_path):
    done = conform(ProgrammeSource(make(), sources), tmp_path / "one")
    sound = wav(done.audio)
    assert len(sound) == round(FRAMES / 30 * 48000)
    assert abs(int(np.argmax(np.abs(sound) > 0.2)) - CLICK_S * 48000) < 48 * 2
    cameras = make().cameras
    edl = make(cameras=(attrs.evolve(cameras[0], clock=Clock(offset_s=-0.5)), cameras[1]))
    moved = conform(ProgrammeSource(edl, sources), tmp_path / "two")
    found = np.correlate(wav(moved.audio), click_track(0.2, 0)[:480]).argmax()
    assert abs(int(found) - (CLICK_S - 0.5) * 48000) <= 2
    assert moved.audio.name != done.audio.name
    assert conform(ProgrammeSource(make(), sources, audio_from="b"), tmp_path / "three").audio is None
    with pytest.raises(UsageError, match="'c'"):
        conform(ProgrammeSource(make(), sources, audio_from="c"), tmp_path / "four")


def test_default_folder():
    assert default_folder(Path("/a/edl.json")) == Path("/a/edl.conformed")
