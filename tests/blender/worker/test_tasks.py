"""The child process: what it is told, how it is stopped, and what is said when it dies."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import pytest
from attrs import frozen
from blender_recording import in_blender

from mcsl_core.blender import child
from mcsl_core.blender.child import run_task
from mcsl_core.blender.messages import ReadRequest, RenderRequest, Request
from mcsl_core.delivery.presets import load_preset
from mcsl_core.errors import BlenderError, Cancelled, DocumentError, InputError
from mcsl_core.progress import CancelToken, Silent


class Recorder(Silent):
    """Keeps what was reported; stops the work at the given count."""

    def __init__(self, stop_at: int | None = None) -> None:
        super().__init__(CancelToken())
        self.seen: list = []
        self.stop_at = stop_at

    def stage(self, name, total=None, unit=""):
        self.seen.append((name, total, unit))
        self.token.check()

    def advance(self, done):
        self.seen.append(done)
        if self.stop_at is not None and done >= self.stop_at:
            self.token.cancel()
        self.token.check()


def render_request(built, out):
    return RenderRequest(blend=built, preset=load_preset("h264"), output=out)


def children(of: int = os.getpid()) -> list[int]:
    """Blender children of a process, this one by default, that are still there."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((process / "stat").read_text().rpartition(")")[2].split()[1])
            arguments = (process / "cmdline").read_bytes()
        except OSError:  # ended while we looked
            continue
        if parent == of and b"__main__.py" in arguments:
            found.append(int(process.name))
    return found


def test_progress_comes_as_it_happens(built, blender, tmp_path):
    progress = Recorder()
    result = run_task(blender, render_request(built, tmp_path / "out.mp4"), progress)
    assert result.frames == 60
    assert progress.seen[0] == ("render", 60, "frames")
    assert progress.seen[-1] == 60


def test_a_cancel_ends_the_child(built, blender, tmp_path):
    with pytest.raises(Cancelled):
        run_task(blender, render_request(built, tmp_path / "out.mp4"), Recorder(stop_at=1))
    assert children() == []


def test_a_cancel_while_the_child_says_nothing(built, blender, tmp_path):
    progress = Recorder()
    threading.Timer(0.3, progress.token.cancel).start()  # Blender is still starting then
    begun = time.monotonic()
    with pytest.raises(Cancelled):
        run_task(blender, render_request(built, tmp_path / "out.mp4"), progress)
    assert time.monotonic() - begun < 5
    assert children() == []


def test_a_child_leaves_no_temporary_files(built, blender, tmp_path, monkeypatch):
    """Blender makes a folder of its own among them, and leaves it there when it is ended: after any task here."""
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    for name in ("TMPDIR", "TEMP", "TMP"):
        monkeypatch.setenv(name, str(temporary))

    class Watching(Recorder):
        def stage(self, name, total=None, unit=""):
            assert [path.parent.name for path in temporary.rglob("blender_*")] == ["tmp"]
            super().stage(name, total, unit)

    run_task(blender, render_request(built, tmp_path / "out.mp4"), Watching())
    with pytest.raises(Cancelled):
        run_task(blender, render_request(built, tmp_path / "out.mp4"), Watching(stop_at=1))
    assert list(temporary.iterdir()) == []


def test_a_killed_child_is_told_as_such(built, blender, tmp_path):
    def kill() -> None:
        while not (started := children()):
            time.sleep(0.01)
        os.kill(started[0], signal.SIGSEGV)

    killer = threading.Thread(target=kill, daemon=True)  # what the child reports may come when it has ended
    killer.start()
    with pytest.raises(BlenderError, match="was killed by SIGSEGV"):
        run_task(blender, render_request(built, tmp_path / "out.mp4"))
    killer.join()


@frozen
class NoSuchTask(Request[dict]):
    task = "no such task"
    answer = dict


def test_an_unexpected_failure_brings_the_childs_last_words(blender, tmp_path):
    with pytest.raises(BlenderError, match=r"KeyError: 'no such task'[\s\S]*Traceback|Traceback[\s\S]*no such task"):
        run_task(blender, NoSuchTask(tmp_path / "edit.blend"))


def test_a_refusal_keeps_its_kind_place_and_remedy(blender, tmp_path):
    with pytest.raises(InputError) as caught:
        run_task(blender, ReadRequest(tmp_path / "none.blend"))
    assert caught.value.what == "is missing"
    assert caught.value.where == str(tmp_path / "none.blend")
    assert "mcsl timeline" in caught.value.remedy
    assert caught.value.exit_code == 3


def test_a_wrong_request_is_refused_with_the_path_to_the_value(blender, tmp_path):
    """What the child is handed is checked there too: here by a request that stands in for another task's."""

    @frozen
    class Lame(Request[dict]):
        task = "read"
        answer = dict
        instead: int = 3

    with pytest.raises(InputError, match=r"the request of the task read at \$\.instead: expected a text, got 3"):
        run_task(blender, Lame(tmp_path / "edit.blend"))


def test_a_wrong_answer_is_refused_with_the_path_to_the_value(built, blender):
    @frozen
    class Expecting:
        edl: int

    @frozen
    class Reading(Request[Expecting]):
        task = "read"
        answer = Expecting
        blend: Path

    with pytest.raises(DocumentError, match=r"Blender's answer to the task read at \$"):
        run_task(blender, Reading(built))


def test_the_users_settings_play_no_part(built, blender, tmp_path, monkeypatch):
    for folder in (tmp_path / "user" / "scripts" / "startup", tmp_path / "packages"):
        folder.mkdir(parents=True)
        for name in ("mine.py", "sitecustomize.py"):
            (folder / name).write_text(f"open({str(tmp_path / 'the user was here')!r}, 'w')")
    monkeypatch.setenv("BLENDER_USER_RESOURCES", str(tmp_path / "user"))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "packages"))
    assert run_task(blender, ReadRequest(built)).changed is False
    assert not (tmp_path / "the user was here").exists()


def test_the_child_searches_blenders_own_packages_first(blender, tmp_path, monkeypatch):
    """A probe in the place of the add-on tells what the child sees; our numpy lies on the paths it is given."""
    package = tmp_path / "blender_addon" / "worker"
    package.mkdir(parents=True)
    (package / "tasks.py").write_text(
        "import sys, numpy\ndef carry_out(*_): return {'path': sys.path, 'numpy': numpy.__file__}\n"
    )
    for folder in (package, package.parent):
        (folder / "__init__.py").touch()
    ours = child.search_paths()
    monkeypatch.setattr(child, "search_paths", lambda: [str(tmp_path), *ours])
    seen = run_task(blender, NoSuchTask(tmp_path / "edit.blend"))
    assert str(child.script().parent) not in seen["path"]
    assert seen["path"][-len(ours) :] == ours
    assert Path(seen["numpy"]).parents[1] not in [Path(p) for p in ours]


def test_a_render_that_stops_short_is_an_error(built, blender, tmp_path):
    """A codec that takes no such size writes no file; Blender itself may end such a render without a word."""
    request = render_request(built, tmp_path / "nowhere" / "out.mp4")
    (tmp_path / "nowhere").write_text("a file where a folder is needed")
    with pytest.raises(BlenderError):
        run_task(blender, request)


PARENT = """
import os, sys
from pathlib import Path
from mcsl_core.blender.child import run_task
from mcsl_core.blender.installation import find
from mcsl_core.blender.messages import RenderRequest
from mcsl_core.delivery.presets import load_preset
from mcsl_core.progress import Silent

class Telling(Silent):
    def stage(self, name, total=None, unit=""):
        print("rendering", flush=True)

run_task(find(sys.argv[1]), RenderRequest(Path(sys.argv[2]), load_preset("archive"), Path(sys.argv[3])), Telling())
"""


@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")
@pytest.mark.parametrize("moment", ["start", "render"])
def test_a_child_ends_with_a_parent_that_is_killed(built, blender, tmp_path, moment):
    """SIGKILL leaves the parent no chance to end its child."""
    in_blender(blender, built, "scene.frame_end = 100000")
    arguments = [PARENT, blender.command[0], str(built), str(tmp_path / "out.mkv")]
    parent = subprocess.Popen([sys.executable, "-c", *arguments], stdout=subprocess.PIPE)
    assert parent.stdout is not None
    if moment == "render":
        assert parent.stdout.readline() == b"rendering\n"
    until = time.monotonic() + 60
    while not (there := children(parent.pid)) and time.monotonic() < until:
        time.sleep(0.05)
    parent.kill()
    parent.wait()
    parent.stdout.close()
    while any(Path(f"/proc/{child}").exists() for child in there) and time.monotonic() < until:
        time.sleep(0.05)
    assert there
    assert not [child for child in there if Path(f"/proc/{child}").exists()]
