"""The command line as a person or a program meets it: real child processes, exit codes, one line per error."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from mcsl_core.cli.main import cli
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate


def mcsl(*arguments: object, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "mcsl_core.cli", *(str(a) for a in arguments)]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, timeout=300, check=False)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("cli") / "aufnahme – 手術"
    simulate(Scenario(seed=5, duration_s=6, movements=0, size=(320, 180), cameras=3), folder, Silent())
    return folder


def every_command(group: click.Group, *words: str) -> Iterator[tuple[str, ...]]:
    yield words
    for name, command in group.commands.items():
        yield from every_command(command, *words, name) if isinstance(command, click.Group) else [(*words, name)]


@pytest.mark.parametrize("words", [*every_command(cli)], ids=" ".join)
def test_help_is_there_and_fits_a_terminal(words: tuple[str, ...]) -> None:
    done = CliRunner().invoke(cli, [*words, "--help"], prog_name="mcsl", terminal_width=80)
    assert done.exit_code == 0
    usage, _, rest = done.output.partition("\n")
    assert usage.startswith(" ".join(("Usage: mcsl", *words)))
    assert max(map(len, done.output.splitlines())) <= 80
    assert "..." not in rest, "a sentence in a list is cut short"


def test_alone_it_shows_its_help() -> None:
    done = mcsl()
    assert "Usage: mcsl" in done.stdout + done.stderr
    assert "Traceback" not in done.stderr


def test_help_starts_at_once() -> None:
    """Help must not import the heavy packages."""
    heavy = {"cv2", "av", "sklearn", "scipy", "numpy"}
    code = f"import sys, mcsl_core.cli.main; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("arguments", "exit_code", "message"),
    [
        (["analyse"], 2, "Missing argument"),
        (["nonsense"], 2, "No such command"),
        (["analyse", "nowhere", "-o", "e.json"], 3, "nowhere: does not exist. Check the path"),
        (["conform", "nowhere.json"], 3, "nowhere.json: does not exist. Check the path"),
        (["conform", "nowhere.json", "--quality", "best"], 2, "draft, standard, fine"),
        (["render", "nowhere.json", "-o", "x.mp4", "--quality", "best"], 2, "draft, standard, fine"),
        (["simulate", "x", "--size", "wide"], 2, "--size wide is no size. Give it as 640x360"),
        (["simulate", "x", "--duration", "5", "--movements", "3"], 2, "make it longer"),
    ],
)
def test_a_wrong_call_is_told_in_one_line(tmp_path: Path, arguments: list[str], exit_code: int, message: str) -> None:
    done = mcsl(*arguments, cwd=tmp_path)
    assert done.returncode == exit_code
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir()), "a refused call leaves nothing behind"


def test_an_unknown_stage_name_lists_what_there_is(recording: Path, tmp_path: Path) -> None:
    done = mcsl("analyse", recording, "-o", tmp_path / "e.json", "--selector", "best")
    assert done.returncode == 2
    assert "shortest-path" in done.stderr


def test_a_broken_edl_is_refused_with_the_path_to_the_value(tmp_path: Path) -> None:
    (tmp_path / "e.json").write_text('{"schema": "mcsl.edl/9"}')
    done = mcsl("conform", tmp_path / "e.json")
    assert done.returncode == 3
    assert "$.schema" in done.stderr
    assert "newer mcsl" in done.stderr


def test_plugins_as_json_and_as_text() -> None:
    rows = json.loads(mcsl("plugins", "--json").stdout)
    assert {"stage", "name", "package", "version", "summary", "default"} == set(rows[0])
    text = mcsl("plugins").stdout
    assert all(row["name"] in text for row in rows)


def test_analysis_reports_json_lines_and_the_same_input_gives_the_same_bytes(recording: Path, tmp_path: Path) -> None:
    done = mcsl("--progress", "json", "analyse", recording, "-o", tmp_path / "e.json")
    assert done.returncode == 0, done.stdout + done.stderr
    messages = [json.loads(line) for line in done.stdout.splitlines()]
    stages = [m["stage"] for m in messages if "stage" in m]
    assert len(stages) >= 5
    steps = [(m["step"], m["of"]) for m in messages if "step" in m]
    assert steps == [(n, len(steps)) for n in range(1, len(steps) + 1)], "every step that was announced has come"
    last = next(n for n, m in enumerate(messages) if m.get("stage") == "Refining the switches")
    assert messages[last - 1] == {"step": len(steps), "of": len(steps)}
    result = messages[-1]["result"]
    assert result["cameras"] == ["cam1", "cam2", "cam3"]
    first = (tmp_path / "e.json").read_bytes()
    (tmp_path / "e.json").unlink()
    assert mcsl("analyse", recording, "-o", tmp_path / "e.json").returncode == 0
    assert (tmp_path / "e.json").read_bytes() == first


def test_steps_that_the_options_leave_out_are_not_counted(recording: Path, tmp_path: Path) -> None:
    how = ("-o", tmp_path / "e.json", "--movement-view", "hold", "--no-cache")
    done = mcsl("--progress", "json", "analyse", recording, *how)
    assert done.returncode == 0, done.stdout + done.stderr
    messages = [json.loads(line) for line in done.stdout.splitlines()]
    steps = [(m["step"], m["of"]) for m in messages if "step" in m]
    assert steps == [(n, len(steps)) for n in range(1, len(steps) + 1)]
    assert not [m for m in messages if m.get("stage") in ("Placing poses by the lamp", "Following the lamp")]


def test_an_error_as_json_has_the_remedy(tmp_path: Path) -> None:
    done = mcsl("--progress", "json", "analyse", tmp_path / "nowhere", "-o", tmp_path / "e.json")
    assert done.returncode == 3
    error = json.loads(done.stdout.splitlines()[-1])["error"]
    assert error["exit_code"] == 3
    assert error["remedy"]


def test_a_wrong_call_is_json_for_programs_too(tmp_path: Path) -> None:
    done = mcsl("--progress", "json", "analyse", cwd=tmp_path)
    assert done.returncode == 2
    assert "Missing argument" in json.loads(done.stdout)["error"]["what"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_stopping_leaves_nothing_half_written(tmp_path: Path, number: int) -> None:
    command = [sys.executable, "-m", "mcsl_core.cli", "--progress", "lines", "simulate", "out", "--duration", "600"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    # A shell's background job passes on that it ignores Ctrl-C; a person's terminal does not.
    child = subprocess.Popen(
        command,
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    try:
        assert child.stderr is not None
        while "film" not in child.stderr.readline():
            assert child.poll() is None
        time.sleep(1)
        child.send_signal(number)
        _, err = child.communicate(timeout=60)
    finally:
        child.kill()
    assert child.returncode == 130
    assert re.search(r"mcsl: stopped", err)
    assert "Traceback" not in err
    assert not list(tmp_path.rglob("*.mp4"))
