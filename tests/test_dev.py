"""dev.py, run as a newcomer runs it: a real process, a real environment, real pip and nox; only the project is tiny.

The tiny project builds itself (its own build backend) and its lock file is empty, so no package is fetched from
anywhere; nox is the one these tests run with, its sessions are the real ones. Programs that would change the system
(apt-get, sudo) are stand-ins that write down how they were called.
"""

from __future__ import annotations

import ast
import json
import os
import re
import runpy
import shutil
import signal
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from tiny_project import BACKEND, PYPROJECT, ROOT, Project

SIDE_BY_SIDE = ("-n", "auto", "--maxprocesses", "4", "--dist", "loadfile", "--no-loadscope-reorder")
pytestmark = [
    pytest.mark.slow,  # an environment takes seconds to make
    pytest.mark.skipif(os.name == "nt", reason="the stand-ins are shell scripts"),
]


@pytest.fixture
def project(tmp_path: Path) -> Project:
    return Project(tmp_path)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Project:
    project = Project(tmp_path_factory.mktemp("made"))
    done = project.dev("mcsl")
    assert done.returncode == 0, done.stderr
    return project


@pytest.fixture
def ready(made: Project) -> Iterator[Project]:
    """A project whose environment is there already, for what comes after; the next test finds it as this one did."""
    yield made
    shutil.rmtree(made.home, ignore_errors=True)
    for path in (made.log, made.bin / "sudo"):
        path.unlink(missing_ok=True)
    made.stand_in("apt-get")


def only_line(text: str) -> str:
    lines = text.splitlines()
    assert len(lines) == 1, text
    return lines[0]


def test_set_up_once_then_quick_then_again_when_the_project_changes(project):
    first = project.dev("mcsl", "plugins", "--x")
    assert first.returncode == 0, first.stdout + first.stderr
    assert f"mcsl plugins --x in {project.root.parent}\n" in first.stdout, "run where the user stands"
    assert "installing the Python packages" in first.stdout

    second = project.dev("mcsl", "plugins")
    assert only_line(second.stdout) == f"mcsl plugins in {project.root.parent}"

    for name in ("pyproject.toml", "requirements.lock", "mcsl_core/__init__.py"):  # the last one has the version
        with (project.root / name).open("a") as stream:
            stream.write("# changed\n")
        third = project.dev("mcsl", "plugins")
        assert "installing the Python packages" in third.stdout
        assert "making an environment" not in third.stdout

    (project.venv / "bin" / "python").unlink()
    fourth = project.dev("mcsl", "plugins")
    assert "making an environment" in fourth.stdout
    assert fourth.returncode == 0, fourth.stderr
    assert project.system_calls == []


def test_the_demo_brings_blender_and_its_libraries_once(ready):
    ready.stand_in("sudo", 'shift; exec "$@"')
    first = ready.dev("demo", "out")
    assert first.returncode == 0, first.stdout + first.stderr
    order = [line for line in first.stdout.splitlines() if line.startswith("mcsl ")]
    assert [line.split(" in ")[0] for line in order] == ["mcsl blender install", "mcsl demo out"]
    calls = [c for c in ready.system_calls if c.startswith("apt-get")]
    assert calls == ["apt-get -q update", "apt-get -q install -y --no-install-recommends libmcsl1"]
    second = ready.dev("demo")
    assert "blender install" not in second.stdout


def test_libraries_that_cannot_be_brought_are_named_and_do_not_stop_the_rest(ready):
    ready.stand_in("apt-get", "echo 'E: no network'; exit 100")
    ready.stand_in("sudo", 'shift; exec "$@"')
    done = ready.dev("setup")
    assert done.returncode == 0
    assert "apt-get update failed: E: no network; run as root: apt-get install -y libmcsl1" in done.stdout
    assert done.stdout.splitlines()[-1] == f"tools/bring_blender.py: ready: {ready.venv / 'bin'}"


def test_a_failing_command_hands_its_code_on(ready):
    assert ready.dev("mcsl", "fail").returncode == 7
    assert ready.dev("run", "mcsl", "fail").returncode == 7
    missing = ready.dev("run", "mcls")
    assert missing.returncode == 1
    assert only_line(missing.stderr) == f"dev.py: {ready.venv / 'bin' / 'mcls'} is not there, or does not run"


@pytest.mark.parametrize("command", ["mcsl", "demo"])
def test_ctrl_c_lets_what_runs_end_well_and_gives_130(ready, command):
    ready.home.mkdir()
    with ready.start(command, "wait") as child:
        assert child.stdout is not None
        while not (line := child.stdout.readline()).startswith("mcsl"):
            assert line, child.communicate()
        os.killpg(child.pid, signal.SIGINT)  # as the terminal does: every process of the foreground gets it
        out, _ = child.communicate(timeout=60)
    assert (child.returncode, out) == (130, "ended well\n")


def test_a_blender_that_cannot_be_brought_is_one_line(project):
    (project.root / "mcsl_core" / "cli.py").write_text("def main(): return 4\n")
    done = project.dev("setup")
    assert done.returncode == 1
    words = "tools/bring_blender.py: Blender could not be brought; `python3 dev.py mcsl blender` says more"
    assert done.stdout.splitlines()[-1] == words


def test_packages_that_cannot_be_installed_are_one_line_and_a_log(project):
    (project.root / "backend.py").write_text("raise ImportError('broken on purpose')\n")
    done = project.dev("mcsl")
    assert done.returncode == 1
    line = only_line(done.stderr)
    assert line.startswith("dev.py: the Python packages could not be installed: ")
    log = project.venv / "mcsl-setup.log"
    assert str(log) in line
    assert "broken on purpose" in log.read_text()
    (project.root / "backend.py").write_text(BACKEND)
    assert project.dev("mcsl").returncode == 0, "mended, it goes on"


def test_a_folder_with_other_things_in_it_is_never_touched(project):
    project.venv.mkdir()
    (project.venv / "thesis.txt").write_text("mine")
    done = project.dev("mcsl")
    assert (done.returncode, (project.venv / "thesis.txt").read_text()) == (1, "mine")
    assert "is there and is no Python environment; name another folder by MCSL_VENV" in only_line(done.stderr)


@pytest.fixture
def without_venv(project: Project) -> Project:
    """As on a fresh Debian: Python is there, its venv module's other half is not."""
    broken = project.root.parent / "broken"
    broken.mkdir()
    (broken / "ensurepip.py").write_text("raise ImportError('No module named ensurepip')\n")
    variables = {"PYTHONPATH": str(broken)}
    plain = project.dev
    project.dev = lambda *arguments, **more: plain(*arguments, **{**variables, **more})
    return project


PACKAGE = f"python{sys.version_info.major}.{sys.version_info.minor}-venv"


def test_a_missing_venv_module_is_brought(without_venv):
    broken = without_venv.root.parent / "broken" / "ensurepip.py"
    without_venv.stand_in("apt-get", f'case "$*" in *install*) rm "{broken}";; esac')
    without_venv.stand_in("sudo", 'shift; exec "$@"')
    done = without_venv.dev("mcsl")
    assert done.returncode == 0, done.stderr
    assert f"apt-get -q install -y --no-install-recommends {PACKAGE}" in without_venv.system_calls


def test_a_missing_venv_module_that_cannot_be_brought_is_one_line(without_venv):
    without_venv.stand_in("apt-get", "echo 'Reading lists'; echo 'E: Unable to locate package'; exit 100")
    without_venv.stand_in("sudo", 'shift; exec "$@"')
    done = without_venv.dev("mcsl")
    assert done.returncode == 1
    assert only_line(done.stderr) == (
        "dev.py: Python's venv module is missing; apt-get update failed: E: Unable to locate package; "
        f"run as root: apt-get install -y {PACKAGE}"
    )


@pytest.mark.skipif(os.name == "nt" or os.geteuid() != 0, reason="becoming nobody takes root")
def test_without_root_and_sudo_the_line_to_run_is_told(without_venv):
    without_venv.stand_in("sudo", "exit 1")
    as_nobody = (
        "import os, runpy, sys; os.setgid(65534); os.setuid(65534); sys.argv = sys.argv[1:]; "
        "runpy.run_path(sys.argv[0], run_name='__main__')"
    )
    # Where nobody may read: a copy outside of root's own folders.
    with tempfile.TemporaryDirectory() as name:
        os.chmod(name, 0o755)
        shutil.copy(ROOT / "dev.py", name)
        (Path(name) / "mcsl_core").mkdir()
        for empty in ("requirements.lock", "mcsl_core/__init__.py"):
            (Path(name) / empty).touch()
        shutil.copytree(without_venv.root.parent / "broken", Path(name) / "broken")
        shutil.copytree(without_venv.bin, Path(name) / "bin")
        (Path(name) / "pyproject.toml").write_text(PYPROJECT)
        system = shutil.which("python3", path="/usr/bin:/bin")
        if system is None:
            pytest.skip("root's own Python is not for others, and the system has none")
        done = subprocess.run(
            [system, "-c", as_nobody, f"{name}/dev.py", "mcsl"],
            env={"PATH": f"{name}/bin:/usr/bin:/bin", "PYTHONPATH": f"{name}/broken", "MCSL_VENV": f"{name}/venv"},
            capture_output=True,
            text=True,
        )
    assert done.returncode == 1
    assert only_line(done.stderr).startswith("dev.py: Python's venv module is missing; run as root: apt-get install -y")


def test_wrong_calls_are_one_line_and_code_2(project):
    for arguments in ((), ("tset",), ("setup", "now"), ("lint", "--fix")):
        done = project.dev(*arguments)
        assert done.returncode == 2
        assert "one of demo, test, fast, addon, test-addon, mcsl, run, lint, lowest, docs" in only_line(done.stderr)
    assert not project.venv.exists()
    assert "python3 dev.py test" in project.dev("--help").stdout


def test_an_old_python_can_read_the_script_and_says_what_it_needs(project):
    source = (ROOT / "dev.py").read_text("utf-8")
    ast.parse(source, feature_version=(3, 7))
    # An old Python as the script sees it: the same interpreter that claims to be 3.9, and nothing newer on PATH.
    old = (
        "import runpy, sys; sys.version_info = (3, 9, 2); sys.argv = sys.argv[1:]; "
        "runpy.run_path(sys.argv[0], run_name='__main__')"
    )
    empty = project.root.parent / "empty"
    empty.mkdir()
    environment = {"PATH": str(empty), "MCSL_VENV": str(project.venv)}
    command = [sys.executable, "-c", old, str(project.root / "dev.py"), "mcsl"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 1
    assert only_line(done.stderr) == (
        "dev.py: Python 3.11 or newer is needed; this is 3.9, "
        "and none of python3.11, python3.12, python3.13, python3.14 is on PATH"
    )
    # A shim that does not run is passed over, a newer one is taken.
    (empty / "python3.11").write_text("#!/bin/sh\nexit 127\n")
    (empty / "python3.11").chmod(0o755)
    (empty / "python3.12").symlink_to(sys.executable)
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert f"making an environment with {empty / 'python3.12'}" in done.stdout


def test_the_question_about_blender_is_understood_by_the_real_mcsl(tmp_path):
    """The tiny project's answer is made up; the real one must answer to the same words."""
    code = "import json, runpy; t = runpy.run_path('tools/bring_blender.py')\n"
    code += "print(json.dumps([t['kind_found'](), t['lacking']()]))"
    environment = {**os.environ, "MCSL_HOME": str(tmp_path), "MCSL_BLENDER": str(tmp_path / "none")}
    done = subprocess.run([sys.executable, "-c", code], env=environment, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    kind, packages = json.loads(done.stdout)
    assert kind == ""
    assert all(name.startswith("lib") for name in packages)


# ----------------------------------------------------------------------------------------------- the sessions


def test_every_command_is_a_session():
    dev = runpy.run_path(str(ROOT / "dev.py"))
    command = [sys.executable, "-m", "nox", "-f", str(ROOT / "noxfile.py"), "--list"]
    listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert set(dev["COMMANDS"]) - {"mcsl", "run"} <= set(re.findall(r"^[*-] (\S+)", listed, re.MULTILINE))
    for command in dev["COMMANDS"]:
        assert f"python3 dev.py {command} " in dev["__doc__"]


def test_every_check_runs_and_those_that_fail_are_named(project):
    """Stand-ins for the tools, as modules of the tiny project: what is tested is that no failure gets lost."""
    for name, code in (("ruff", 0), ("pyright", 1), ("pytest", 5)):
        (project.root / f"{name}.py").write_text(f"import sys; print('{name}', *sys.argv[1:]); sys.exit({code})\n")
    (project.root / "lint_imports.py").write_text(
        "def main(): import sys; print('lint-imports', *sys.argv[1:]); return 1\n"
    )
    (project.root / "docs").mkdir()
    (project.root / "docs" / "generate.py").write_text("import sys; print('generate', *sys.argv[1:])\n")
    plugin = project.root / "plugins" / "one"
    (plugin / "tests").mkdir(parents=True)
    (plugin / "pyproject.toml").write_text(PYPROJECT.replace('"mcsl"', '"one"'))
    (plugin / "backend.py").write_text(BACKEND.replace("mcsl-0.0", "one-0.0").replace("Name: mcsl", "Name: one"))
    project.home.mkdir()
    done = project.dev("test", "-k", "edl", MCSL_BLENDER_OLDEST="")
    assert done.returncode == 1
    assert list(project.venv.glob("lib/*/site-packages/one-0.0.dist-info")), "a plugin is installed before it is tested"
    said = [line for line in done.stdout.splitlines() if not line.startswith(("dev.py", "tools/"))]
    assert said[0].startswith("mcsl blender install --version 4.5 in"), "tests run in the oldest Blender too"
    assert said[1:] == [
        "ruff check .",
        "ruff format --check --quiet .",
        f"pyright --pythonpath {project.venv / 'bin' / 'python'}",
        "lint-imports --no-logo",
        "generate --check",
        f"pytest {' '.join(SIDE_BY_SIDE)} tests plugins/one/tests -k edl",
    ]
    assert "nox > failed: pyright, lint-imports, pytest\n" in done.stderr
    quick = project.dev("fast", "plugins/one/tests::that")
    expected = f"pytest {' '.join(SIDE_BY_SIDE)} -m not slow and not blender plugins/one/tests::that\n"
    assert expected in quick.stdout, "only what is named"
    alone = project.dev("fast", "-n0", "plugins")
    assert "pytest -m not slow and not blender -n0 plugins\n" in alone.stdout, "one's own -n wins"


def test_ci_uses_fresh_environments_and_takes_them_away(project, tmp_path):
    (project.root / ".ci").mkdir()
    shutil.copy(ROOT / ".ci" / "run", project.root / ".ci" / "run")
    (project.root / "dev.py").write_text(
        "import os, sys\n"
        "for name in ('MCSL_VENV', 'MCSL_HOME'):\n"
        "    path = os.environ[name]; assert not os.path.exists(path); os.makedirs(path); print(path)\n"
        "print(os.getcwd(), *sys.argv[1:])\n"
        "sys.exit(3)\n"
    )
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    environment = {**os.environ, "TMPDIR": str(scratch), "MCSL_VENV": "/elsewhere", "CI": "true"}
    done = subprocess.run(
        ["bash", str(project.root / ".ci" / "run")], env=environment, cwd="/", capture_output=True, text=True
    )
    assert done.returncode == 3
    venv, home, last = done.stdout.splitlines()
    assert venv.startswith(str(scratch))
    assert home.startswith(str(scratch))
    assert last == f"{project.root} test"
    assert list(scratch.iterdir()) == []


# -------------------------------------------------------------------------------------------------- the lock


def test_the_lock_pins_what_the_projects_ask_for_with_hashes_and_names_no_index():
    text = (ROOT / "requirements.lock").read_text("utf-8")
    assert "://" not in text
    entries = re.findall(r"^(\S+?)==(\S+).*\\\n((?:    --hash=sha256:[0-9a-f]{64}(?: \\)?\n)+)", text, re.MULTILINE)
    assert len(entries) == len(re.findall(r"^[^\s#]", text, re.MULTILINE)), "each entry has its hashes"
    pinned = {name: version for name, version, _ in entries}
    own = {"mcsl"}
    wanted = []
    for path in (ROOT / "pyproject.toml", *ROOT.glob("plugins/*/pyproject.toml")):
        project = tomllib.loads(path.read_text("utf-8"))["project"]
        extras = project.get("optional-dependencies", {}) if path.parent == ROOT else {}
        locked = [name for name in extras if name not in ("bpy", "photographs", "yardstick")]
        wanted += project["dependencies"] + [line for name in locked for line in extras[name]]
    for requirement in map(Requirement, wanted):
        if requirement.name not in own:
            assert pinned.get(requirement.name) in requirement.specifier, f"{requirement}: run python3 dev.py lock"
