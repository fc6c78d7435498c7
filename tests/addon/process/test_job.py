"""A child process as a job: its messages, its ends, and what is said of each. Real children, no Blender."""

from __future__ import annotations

import os
import shutil
import sys
import time
from pathlib import Path

import pytest

import mcsl_core
from blender_addon.process.job import STOPPED, Job, Status, one_line
from mcsl_core.errors import McslError

SAYS = """
import json, sys, time
def say(**message): print(json.dumps(message), flush=True)
"""


def child(code: str) -> Job:
    return Job([sys.executable, "-c", SAYS + code])


def mcsl(*arguments: str) -> Job:
    command = shutil.which("mcsl", path=str(Path(sys.executable).parent))
    assert command, "the command line is installed beside the tests' Python"
    return Job([command, "--progress", "json", *arguments])


def ended(job: Job, timeout_s: float) -> Status:
    until = time.monotonic() + timeout_s
    while job.pump().outcome == "running":
        assert time.monotonic() < until, f"the job still runs after {timeout_s} s"
        time.sleep(0.02)
    return job.status


def test_a_stage_knows_its_step_and_the_time_left_follows_the_pace():
    job = child(
        'say(step=2, of=3); say(stage="b", total=1000); say(step=3, of=3)\n'
        "for i in range(1000): say(done=i); time.sleep(0.05)"
    )
    until = time.monotonic() + 30
    while (left := job.left_s()) is None and time.monotonic() < until:
        job.pump()
        time.sleep(0.01)
    status = job.pump()
    assert (status.stage, status.step, status.steps) == ("b", 2, 3), "a step is shown with its first stage"
    assert left is not None
    assert left > 20  # 50 s at the least for all of it, of which little more than PACE_S has gone by
    job.kill()
    assert ended(job, 30).outcome == "stopped"
    assert job.left_s() is None


def test_stage_count_note_and_result_are_read_as_they_come(tmp_path):
    go = tmp_path / "go"
    job = child(
        f"""
import os
say(stage="aligning", total=8, unit="poses"); say(done=2); say(note="cam3 is weak"); print("not for us")
while not os.path.exists({str(go)!r}): time.sleep(0.01)
say(done=8); say(result={{"edl": "x.json"}})
"""
    )
    until = time.monotonic() + 30
    while not job.pump().notes and time.monotonic() < until:
        time.sleep(0.01)
    status = job.pump()
    assert (status.stage, status.done, status.total, status.unit) == ("aligning", 2, 8, "poses")
    assert (status.fraction, status.notes, status.outcome) == (0.25, ("cam3 is weak",), "running")
    go.touch()
    status = ended(job, 30)
    assert (status.outcome, status.fraction, dict(status.result)) == ("done", 1.0, {"edl": "x.json"})


def test_an_error_is_one_line_that_says_what_where_and_what_to_do():
    job = child(
        'say(error={"what": "is\\nmissing", "where": "cam1.mp4", "remedy": "Put it back", "exit_code": 3}); sys.exit(3)'
    )
    status = ended(job, 30)
    assert (status.outcome, status.message) == ("failed", "cam1.mp4: is missing. Put it back")


def test_a_message_with_a_wrong_value_ends_the_job_and_names_it():
    status = ended(child("say(stage='x', total='many'); time.sleep(60)"), 30)
    assert status.outcome == "failed"
    assert status.message.startswith('a line of progress at $.total: expected a whole number, got "many". mcsl and its')


def test_a_child_that_fails_without_a_word_is_told_by_its_last_line():
    assert ended(child("sys.exit('no module named cv2')"), 30).message == "mcsl failed: no module named cv2"
    assert ended(child("sys.exit(9)"), 30).message == "mcsl failed: it ended with code 9 and said nothing"


@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_a_child_killed_from_outside_is_told_so():
    status = ended(child("import os, signal; os.kill(os.getpid(), signal.SIGKILL)"), 30)
    assert status.outcome == "failed"
    assert status.message.startswith("mcsl was ended from outside (SIGKILL). Start it again")


def test_cancelling_asks_first_and_kills_after_the_grace(monkeypatch):
    monkeypatch.setattr("blender_addon.process.job.GRACE_S", 0.3)
    job = child("import signal; signal.signal(signal.SIGTERM, signal.SIG_IGN); say(note='deaf'); time.sleep(60)")
    while not job.pump().notes:
        time.sleep(0.01)
    job.cancel()
    assert job.stopping
    assert ended(job, 10).outcome == "stopped"
    assert job.status.message == STOPPED


def test_killing_ends_what_the_child_started_too(tmp_path):
    pid = tmp_path / "pid"
    job = child(
        f"""
import subprocess
grandchild = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
open({str(pid)!r}, "w").write(str(grandchild.pid)); say(note="started"); time.sleep(60)
"""
    )
    while not job.pump().notes:
        time.sleep(0.01)
    job.kill()
    assert ended(job, 10).outcome == "stopped"
    deadline = time.monotonic() + 5
    while _alive(int(pid.read_text())) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not _alive(int(pid.read_text()))


def _alive(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


def test_a_stopped_mcsl_leaves_nothing_half_written(tmp_path):
    job = mcsl("simulate", str(tmp_path / "out"), "--duration", "60", "--size", "320x180")
    until = time.monotonic() + 60
    while not job.pump().done and time.monotonic() < until:
        time.sleep(0.02)
    assert job.status.outcome == "running"
    job.cancel()
    assert ended(job, 30).outcome == "stopped"
    assert not list(tmp_path.rglob("*.mp4"))
    assert not list(tmp_path.rglob("*.part"))


def test_mcsl_that_refuses_says_why_in_a_line(tmp_path):
    status = ended(mcsl("conform", str(tmp_path / "none.json")), 60)
    assert status.outcome == "failed"
    assert "none.json" in status.message
    assert len(status.message.splitlines()) == 1


def test_mcsl_speaks_the_language_it_is_asked_to(tmp_path):
    tree = str(Path(mcsl_core.__file__).parents[1])  # not another that is installed
    code = (
        f"import sys; sys.path.insert(0, {tree!r}); from mcsl_core.cli.main import main; sys.exit(main(sys.argv[1:]))"
    )
    command = [sys.executable, "-c", code, "--progress", "json", "look", str(tmp_path / "none.json")]
    job = Job(command, language="ja_JP")
    status = ended(job, 120)
    assert status.message == f"{tmp_path}/none.json: 見つかりません。パスを確認してください"


def test_a_stage_is_shown_in_the_language_of_the_person(tmp_path):
    job = child('say(stage="Scoring the views", total=8, unit="samples", shown="画像の採点"); time.sleep(60)')
    until = time.monotonic() + 30
    while not job.pump().stage and time.monotonic() < until:
        time.sleep(0.01)
    assert (job.status.stage, job.status.total, job.status.unit) == ("画像の採点", 8, "")
    job.kill()
    ended(job, 30)


def test_the_text_of_a_command_that_is_no_long_work():
    job = child("print('[1,'); print('2]')")
    assert ended(job, 30).outcome == "done"
    assert job.output() == "[1,\n2]\n"


def test_what_cannot_be_started_is_said(tmp_path):
    with pytest.raises(McslError, match="cannot be started"):
        Job([str(tmp_path / "no-such-mcsl")])


def test_the_childs_python_is_its_own(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", "/of/blender")
    job = child("import os; say(result={'path': os.environ.get('PYTHONPATH')})")
    assert ended(job, 30).result == {"path": None}


def test_one_line():
    assert one_line("a\n  b\tc ") == "a b c"
