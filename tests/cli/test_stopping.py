"""Signals end every command with code 130 and one line, whatever its main thread is at; real processes throughout."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from mcsl_core.temporary import temporary_beside

ROOT = Path(__file__).parents[2]
SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]

# Native code that hears nothing for minutes, as fitting or preparing a fill may for seconds.
DEAF = "hashlib.pbkdf2_hmac('sha256', b'', b'', 10**9)"
BEGUN = "stopping.begin(lambda: print('mcsl: stopped', file=sys.stderr, flush=True))"


def start(*lines: str, ignoring: tuple[int, ...] = ()) -> subprocess.Popen[str]:
    """A process that has run all of ``lines`` but the last."""
    head = ["import hashlib, os, subprocess, sys, time", "from mcsl_core.cli import stopping", "stopping.install()"]
    code = "\n".join([*head, *lines[:-1], "print('ready', flush=True)", lines[-1]])

    def as_a_terminal() -> None:
        for number in SIGNALS:
            signal.signal(number, signal.SIG_IGN if number in ignoring else signal.SIG_DFL)

    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    child = subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
        preexec_fn=as_a_terminal,
    )
    assert child.stdout is not None
    while (line := child.stdout.readline()) != "ready\n":
        assert line, child.communicate()[1]
    return child


def stopped(child: subprocess.Popen[str], *numbers: int) -> tuple[int, str]:
    """Its exit code and what it said, after these signals."""
    try:
        for number in numbers:
            time.sleep(0.5)  # until it is at its last line
            child.send_signal(number)
        said = child.communicate(timeout=60)[1]
    finally:
        child.kill()
    return child.returncode, said


@pytest.mark.parametrize("number", SIGNALS)
def test_work_that_hears_nothing_ends_too(number):
    assert stopped(start(BEGUN, DEAF), number) == (130, "mcsl: stopped\n")


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_during_the_start_has_no_traceback(number):
    assert stopped(start("time.sleep(600)"), number) == (130, "mcsl: stopped\n")


def test_ctrl_c_before_signals_are_heard_is_told_too():
    """Python raises it by itself then, here at the import of what hears them."""
    hook = "lambda name, *_: os.kill(os.getpid(), 2) if name.endswith('.stopping') else None"
    code = f"""import os, runpy, sys
sys.meta_path.insert(0, type("", (), {{"find_spec": {hook}}}))
runpy.run_module("mcsl_core.cli", run_name="__main__")"""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=False)
    assert (done.returncode, done.stderr) == (130, "mcsl: stopped\n")


def test_a_second_one_ends_at_once():
    began = time.monotonic()
    assert stopped(start(BEGUN, DEAF), signal.SIGINT, signal.SIGINT) == (130, "mcsl: stopped\n")
    assert time.monotonic() - began < 30


def test_the_orderly_way_is_left_its_time():
    work = [
        "try:",
        "    time.sleep(600)",
        "except KeyboardInterrupt:",
        "    time.sleep(0.5); os.write(2, b'in order'); os._exit(7)",
    ]
    assert stopped(start(BEGUN, "\n".join(work)), signal.SIGTERM) == (7, "in order")


def test_children_and_those_of_sessions_of_their_own_end_with_it():
    begun = "subprocess.Popen(['sleep', '600'], start_new_session=new, stderr=subprocess.DEVNULL)"
    made = f"[{begun} for new in (True, False)]"
    kept = "from mcsl_core.children import ended_afterwards"
    entered = f"made = {made}; [ended_afterwards(child).__enter__() for child in made]"
    told = "print(*[child.pid for child in made], flush=True)"
    child = start(BEGUN, kept, entered, f"{told}; {DEAF}")
    assert child.stdout is not None
    numbers = [int(word) for word in child.stdout.readline().split()]
    assert stopped(child, signal.SIGTERM) == (130, "mcsl: stopped\n")
    for number in numbers:
        assert is_gone(number)


def test_what_is_half_written_goes_with_it(tmp_path, monkeypatch):
    """What this process was given a name for, in whatever folder and thread, and nothing that others write."""
    monkeypatch.setenv("TMPDIR", str(tmp_path / "tmp"))
    theirs = ["film.mp4", ".film.mp4.part", temporary_beside(tmp_path / "film.mp4", ".mp4").name, "tmp", "tmp/mcsl-a-b"]
    for name in theirs:
        (tmp_path / name).write_bytes(b"theirs") if name != "tmp" else (tmp_path / name).mkdir()
    monkeypatch.chdir(tmp_path)
    begun = [
        "from mcsl_core.temporary import temporary_beside, temporary_folder; from pathlib import Path",
        "film = open(temporary_beside(Path('film.mp4'), '.mp4'), 'wb'); film.write(b'half of it'); film.flush()",
        "made = temporary_beside(Path('plugin')); (made / 'src').mkdir(parents=True)",
        "closed = temporary_beside(Path('tmp/film.wav')); closed.write_bytes(b'half of it')",
        "room = temporary_folder('render'); (room.__enter__() / 'a').write_bytes(b'half of it'); os.chdir('/')",
    ]
    child = start(BEGUN, *begun, DEAF)
    assert len(list(tmp_path.rglob("*"))) == len(theirs) + 6
    assert stopped(child, signal.SIGTERM) == (130, "mcsl: stopped\n")
    assert sorted(path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*")) == sorted(theirs)


def is_gone(process: int) -> bool:
    for _ in range(100):
        try:
            state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
        except (FileNotFoundError, ProcessLookupError):
            return True
        if state == "Z":
            return True
        time.sleep(0.05)
    return False


def test_what_is_ignored_stays_ignored():
    """`nohup mcsl ...` outlives its terminal."""
    child = start(BEGUN, "time.sleep(2); os._exit(5)", ignoring=(signal.SIGHUP,))
    assert stopped(child, signal.SIGHUP) == (5, "")


def test_after_the_end_a_signal_changes_nothing():
    assert stopped(start(BEGUN, "stopping.finish(3)", "time.sleep(1); sys.exit(3)"), signal.SIGINT) == (3, "")


def test_a_thread_that_lingers_does_not_keep_a_finished_process():
    work = "import threading; threading.Thread(target=time.sleep, args=(600,)).start(); stopping.finish(3)"
    assert stopped(start(BEGUN, f"{work}; sys.exit(3)")) == (3, "")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["analyse", "rec", "-o", "edl.json"], "The same command carries on where it stopped"),
        (["analyse", "rec", "-o", "edl.json", "--no-cache"], "Nothing half-written is left"),
        (["--progress", "none", "conform", "edl.json"], "The same command carries on where it stopped"),
        (["report", "edl.json", "-o", "page.html"], "Nothing half-written is left"),
    ],
)
def test_it_says_whether_it_would_carry_on(arguments, said):
    from mcsl_core.cli.main import _stopped

    assert _stopped(arguments).remedy == said


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_a_command_stopped_at_random_leaves_nothing_behind():
    """By hand with --times 20 and every command; docs/reliability.md has what came out."""
    done = subprocess.run(
        [sys.executable, ROOT / "benchmarks" / "stops.py", "--times", "2", "analyse"],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])},
    )
    assert done.returncode == 0, done.stdout + done.stderr
