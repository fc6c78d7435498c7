"""Several writers of one EDL and one folder, private files, leftovers: real files and processes."""

from __future__ import annotations

import json
import os
import signal
import stat
import subprocess
import sys
import threading
from pathlib import Path

import attrs
import pytest
from two_cameras import make, write_sources

import mcsl_core as mcsl
from mcsl_core import edl as edls
from mcsl_core.cli.commands.look import change_file
from mcsl_core.delivery import chunk_keys
from mcsl_core.delivery.conform import conform
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.edl import Look, Override
from mcsl_core.errors import DocumentError, InputError
from mcsl_core.outputs import locks
from mcsl_core.outputs.manifest import Manifest
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import footage_of
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.temporary import sweep, temporary_beside
from mcsl_core.timing import FrameRange


@pytest.fixture(scope="module")
def sources(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sources")
    write_sources(folder)
    return folder


@pytest.fixture(autouse=True)
def _short_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chunk_keys, "CHUNK_S", 1)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    edls.save(make(), tmp_path / "edl.json")
    return tmp_path / "edl.json"


def test_prune_leaves_what_mcsl_did_not_make(sources: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    theirs = ["2026-11-25.mp4", "sound-surgeon.wav", "0000000-0000030-cafe.mp4", "a-b-c.mp4", "1-2-3.mp4"]
    for name in theirs:
        (out / name).write_bytes(b"theirs")
    first = conform(ProgrammeSource(make(), sources), out)
    edl = make(overrides=(Override(FrameRange(70, 75), camera="a"),))
    edited = first.path(first.chunks[2])
    edited.write_bytes(edited.read_bytes() + b"by hand")
    done = conform(ProgrammeSource(edl, sources), out, prune=True)
    assert all((out / name).read_bytes() == b"theirs" for name in theirs)
    assert edited.exists(), "somebody changed it since"
    edited.unlink()
    assert done.audio is not None
    ours = {"mcsl-outputs.json", done.audio.name, *(chunk.name for chunk in done.chunks)}
    assert {p.name for p in out.iterdir()} == {*theirs, *ours}


def test_a_folder_of_a_version_without_a_list_is_taken_over(sources: Path, tmp_path: Path) -> None:
    done = conform(ProgrammeSource(make(), sources), tmp_path)
    (tmp_path / "mcsl-outputs.json").unlink()
    again = conform(ProgrammeSource(make(), sources), tmp_path, prune=True)
    assert again.made == 0
    assert {chunk.name for chunk in done.chunks} <= Manifest.inside(tmp_path).names()


def test_bytes_do_not_depend_on_jobs_or_on_what_is_missing(sources: Path, tmp_path: Path) -> None:
    source = ProgrammeSource(make(look=Look(True, True, True)), sources)
    done = conform(source, tmp_path / "one", jobs=1)
    whole = {chunk.name: done.path(chunk).read_bytes() for chunk in done.chunks}
    other = conform(source, tmp_path / "two", jobs=2)
    for gone in ((0,), (1, 3), (0, 2, 4)):
        for number in gone:
            other.path(other.chunks[number]).unlink()
        conform(source, tmp_path / "two", jobs=2)
        assert {chunk.name: other.path(chunk).read_bytes() for chunk in other.chunks} == whole


def test_sound_is_private_and_pictures_obey_the_umask(sources: Path, tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        done = conform(ProgrammeSource(make(), sources), tmp_path)
    finally:
        os.umask(before)
    assert done.audio is not None
    assert stat.S_IMODE(done.audio.stat().st_mode) == 0o600
    assert {stat.S_IMODE(done.path(chunk).stat().st_mode) for chunk in done.chunks} == {0o640}


def test_samples_are_private(sources: Path, tmp_path: Path) -> None:
    before = os.umask(0)
    try:
        SampleStore.record(footage_of(make(), sources), tmp_path / "cache" / "samples", Silent())
    finally:
        os.umask(before)
    assert {p.name: stat.S_IMODE(p.stat().st_mode) for p in (tmp_path / "cache").iterdir()} == {
        "samples": 0o600,
        "samples.json": 0o600,
    }
    assert stat.S_IMODE((tmp_path / "cache").stat().st_mode) == 0o700


def test_an_edl_keeps_its_permissions(path: Path) -> None:
    path.chmod(0o600)
    change_file(path, fill=True)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_saving_keeps_what_somebody_else_wrote(path: Path) -> None:
    programme = mcsl.open(path)
    programme.override((10, 20), camera="b", note="mine")
    change_file(path, colour=True)
    change_file(path, fill=False, start="0", stop="1")
    programme.save()
    edl = edls.load(path)
    assert edl.look.colour
    assert [override.note for override in edl.overrides] == ["", "mine"]
    assert programme.edl == edl


def test_saving_refuses_where_both_changed_the_same(path: Path) -> None:
    programme = mcsl.open(path)
    programme.edl = attrs.evolve(programme.edl, centering=((0, 1.0, 1.0),))
    edls.save(attrs.evolve(make(), centering=((0, 2.0, 2.0),)), path)
    with pytest.raises(DocumentError, match="centering was changed here, and in the file"):
        programme.save()
    assert edls.load(path).centering == ((0, 2.0, 2.0),)


def test_many_looks_at_once_lose_no_override(path: Path) -> None:
    def switch(second: int) -> None:
        change_file(path, fill=True, start=f"{second / 10}", stop=f"{second / 10 + 0.1}")

    threads = [threading.Thread(target=switch, args=(second,)) for second in range(12)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(edls.load(path).overrides) == 12
    assert sorted(p.name for p in path.parent.iterdir()) == ["edl.json"]


HOLD = """
import sys
from pathlib import Path
from mcsl_core.outputs import locks
with locks.alone(Path(sys.argv[1]), "analysis"):
    print("held", flush=True)
    sys.stdin.read()
"""


def test_a_second_analysis_is_refused_by_name_and_a_killed_one_lets_go(path: Path) -> None:
    child = subprocess.Popen([sys.executable, "-c", HOLD, str(path)], stdin=-1, stdout=-1, text=True)
    assert child.stdout is not None
    assert child.stdout.readline() == "held\n"
    with pytest.raises(InputError, match=rf"process {child.pid}\) is at work on it"), locks.alone(path, "analysis"):
        pass
    child.send_signal(signal.SIGKILL)
    child.wait()
    child.stdout.close()
    with locks.alone(path, "analysis"):
        pass
    assert sorted(p.name for p in path.parent.iterdir()) == ["edl.json"]


def test_only_leftovers_of_dead_processes_go(tmp_path: Path) -> None:
    code = "from mcsl_core.temporary import *; import sys; temporary_beside(Path(sys.argv[1])).touch()"
    subprocess.run([sys.executable, "-c", code, str(tmp_path / "x")], check=True)
    assert len(list(tmp_path.iterdir())) == 1
    mine = temporary_beside(tmp_path / "x")
    mine.touch()
    (tmp_path / ".mcsl-notes.tmp").touch()
    sweep(tmp_path)
    assert {p.name for p in tmp_path.iterdir()} == {mine.name, ".mcsl-notes.tmp"}


def test_what_a_killed_blender_was_writing_goes_as_well(tmp_path: Path) -> None:
    """It writes beside the name that it was told, with an @ behind it, until all is there."""
    code = (
        "from mcsl_core.temporary import *; import sys; part = temporary_beside(Path(sys.argv[1]), '.blend');"
        "part.with_name(part.name + '@').touch()"
    )
    subprocess.run([sys.executable, "-c", code, str(tmp_path / "x")], check=True)
    mine = temporary_beside(tmp_path / "x", ".blend")
    mine = mine.with_name(f"{mine.name}@")
    mine.touch()
    assert len(list(tmp_path.iterdir())) == 2
    sweep(tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == [mine.name]


def test_another_files_name_for_the_list_is_told(sources: Path, tmp_path: Path) -> None:
    (tmp_path / "mcsl-outputs.json").write_text(json.dumps({"mine": True}))
    with pytest.raises(InputError, match="is not mcsl's list"):
        conform(ProgrammeSource(make(), sources), tmp_path)
    assert json.loads((tmp_path / "mcsl-outputs.json").read_text()) == {"mine": True}
