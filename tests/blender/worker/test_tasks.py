"""The child process: what it is told, how it is stopped, and what is said when it dies."""

from __future__ import annotations

import os
import signal
import threading
import time
from pathlib import Path

import pytest

from mcsl_core.blender import child as blender_child
from mcsl_core.blender.child import run_task
from mcsl_core.delivery import presets
from mcsl_core.errors import BlenderError, Cancelled, InputError
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
    preset = presets.load_preset("h264").for_blender()
    return {"task": "render", "blend": str(built), "preset": preset, "output": str(out)}


def children() -> list[int]:
    """Blender children of this process that are still there."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((process / "stat").read_text().rpartition(")")[2].split()[1])
            arguments = (process / "cmdline").read_bytes()
        except OSError:  # ended while we looked
            continue
        if parent == os.getpid() and b"background.py" in arguments:
            found.append(int(process.name))
    return found


def test_progress_comes_as_it_happens(built, blender, tmp_path):
    progress = Recorder()
    result = run_task(blender, render_request(built, tmp_path / "out.mp4"), progress)
    assert result["frames"] == 60
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


def test_a_killed_child_is_told_as_such(built, blender, tmp_path):
    class Killer(Recorder):
        def stage(self, name, total=None, unit=""):
            os.kill(children()[0], signal.SIGSEGV)

    with pytest.raises(BlenderError, match="was killed by SIGSEGV"):
        run_task(blender, render_request(built, tmp_path / "out.mp4"), Killer())


def test_an_unexpected_failure_brings_the_childs_last_words(blender, tmp_path):
    with pytest.raises(BlenderError, match=r"KeyError: 'no such task'[\s\S]*Traceback|Traceback[\s\S]*no such task"):
        run_task(blender, {"task": "no such task"})


def test_a_refusal_keeps_its_kind_place_and_remedy(blender, tmp_path):
    with pytest.raises(InputError) as caught:
        run_task(blender, {"task": "read", "blend": str(tmp_path / "none.blend")})
    assert caught.value.what == "is missing"
    assert caught.value.where == str(tmp_path / "none.blend")
    assert "mcsl timeline" in caught.value.remedy
    assert caught.value.exit_code == 3


def test_the_users_settings_play_no_part(built, blender, tmp_path, monkeypatch):
    for folder in (tmp_path / "user" / "scripts" / "startup", tmp_path / "packages"):
        folder.mkdir(parents=True)
        for name in ("mine.py", "sitecustomize.py"):
            (folder / name).write_text(f"open({str(tmp_path / 'the user was here')!r}, 'w')")
    monkeypatch.setenv("BLENDER_USER_RESOURCES", str(tmp_path / "user"))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "packages"))
    assert run_task(blender, {"task": "read", "blend": str(built)})["changed"] is False
    assert not (tmp_path / "the user was here").exists()


def test_the_child_searches_blenders_own_packages_first(blender, tmp_path, monkeypatch):
    """A probe in the place of the add-on tells what the child sees; our numpy lies on the paths it is given."""
    package = tmp_path / "blender_addon"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "tasks.py").write_text(
        "import sys, numpy\nTASKS = {'look': lambda request, progress: {'path': sys.path, 'numpy': numpy.__file__}}\n"
    )
    ours = blender_child.search_paths()
    monkeypatch.setattr(blender_child, "search_paths", lambda: [str(tmp_path), *ours])
    seen = run_task(blender, {"task": "look"})
    assert str(blender_child.script().parent) not in seen["path"]
    assert seen["path"][-len(ours) :] == ours
    assert Path(seen["numpy"]).parents[1] not in [Path(p) for p in ours]


def test_a_render_that_stops_short_is_an_error(built, blender, tmp_path):
    """A codec that takes no such size writes no file; Blender itself may end such a render without a word."""
    request = render_request(built, tmp_path / "nowhere" / "out.mp4")
    (tmp_path / "nowhere").write_text("a file where a folder is needed")
    with pytest.raises(BlenderError):
        run_task(blender, request)
