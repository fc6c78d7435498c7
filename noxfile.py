"""Everything but the making of the environment: `python3 dev.py NAME [ARGS]` makes it and runs the session NAME here.

In that environment, `nox --list` lists the sessions and `nox -s NAME -- ARGS` runs one. None but `lowest` and `newest`
makes an environment of its own: what is tested is what requirements.lock pins.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import nox
from nox.command import CommandFailed

nox.needs_version = ">=2025.2"
nox.options.default_venv_backend = "none"
nox.options.sessions = ["lint", "fast"]

ROOT = Path(__file__).parent
PYTHON = sys.executable
PROGRAMS = Path(PYTHON).parent
# What Ctrl-C leaves for ending well, in seconds.
PATIENT: dict[str, Any] = {"interrupt_timeout": 20, "terminate_timeout": 10}

CHECKS = {
    "ruff check": (PYTHON, "-m", "ruff", "check", "."),
    "ruff format": (PYTHON, "-m", "ruff", "format", "--check", "--quiet", "."),
    "pyright": (PYTHON, "-m", "pyright", "--pythonpath", PYTHON),
    "lint-imports": (str(PROGRAMS / "lint-imports"), "--no-logo"),
    "docs/generate.py": (PYTHON, "docs/generate.py", "--check"),
}
SITE = (PYTHON, "-m", "zensical", "build", "--strict")  # into build/site

# What pytest-xdist is told. A file's tests stay in one process, so that its recordings are simulated once,
# and files begin in the order in which tests/conftest.py puts them.
SIDE_BY_SIDE = ("-n", "auto", "--maxprocesses", "4", "--dist", "loadfile", "--no-loadscope-reorder")
# Where the core calls what it depends on: whether versions of these go together takes a minute, all of it ten.
CALLING_OTHERS = (
    *(f"tests/core/{name}" for name in ("alignment", "centering", "compositing", "imaging", "media", "outputs")),
    *(f"tests/core/{name}" for name in ("test_arrays.py", "test_documents.py", "blender/test_installation.py")),
    "tests/core/evaluation/test_questionnaire.py",
    "tests/cli/test_cli.py",
)
ENVIRONMENT: dict[str, str | None] = {
    # A process each core: threads inside of them would only take turns.
    **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"), "1"),
}


@nox.session
def setup(session: nox.Session) -> None:
    """Brings Blender and its system libraries where they are not there."""
    session.run(PYTHON, "tools/bring_blender.py", **PATIENT)


@nox.session
def oldest(session: nox.Session) -> None:
    """Brings the oldest supported Blender, beside the usual one."""
    session.run(PYTHON, "tools/bring_blender.py", "--oldest", **PATIENT)


@nox.session
def lint(session: nox.Session) -> None:
    """The checks that run no test."""
    run_each(session, CHECKS)


@nox.session(requires=["setup", "oldest"])
def test(session: nox.Session) -> None:
    """All checks and all tests (ARGS go to pytest)."""
    run_each(session, {**CHECKS, "pytest": pytest(*which_tests(session.posargs))})


@nox.session
def fast(session: nox.Session) -> None:
    """The quick tests, without Blender."""
    run_each(session, {"pytest": pytest("-m", "not slow and not blender", *which_tests(session.posargs))})


@nox.session
def lowest(session: nox.Session) -> None:
    """The quick tests of what calls other packages, with the oldest that pyproject.toml allows (ARGS: other tests)."""
    test_with(session, "lowest-direct")


@nox.session
def newest(session: nox.Session) -> None:
    """The same with the newest that pyproject.toml allows, whatever requirements.lock pins (ARGS: other tests)."""
    test_with(session, "highest")


def test_with(session: nox.Session, resolution: str) -> None:
    """Quick tests of the core in build/SESSION, an environment made anew."""
    folder, uv = ROOT / "build" / session.name, str(PROGRAMS / "uv")
    python = str(folder / PROGRAMS.name / Path(PYTHON).name)
    session.run(uv, "venv", "--quiet", "--clear", "--python", PYTHON, str(folder))
    session.run(uv, "pip", "install", "--python", python, "--resolution", resolution, "--editable", ".[test]")
    tests = session.posargs or CALLING_OTHERS
    session.run(python, "-m", "pytest", *SIDE_BY_SIDE, "-m", "not slow and not blender", *tests, env=ENVIRONMENT)


@nox.session(name="test-addon", requires=["setup", "oldest"])
def test_addon(session: nox.Session) -> None:
    """The tests of the Blender extension."""
    run_each(session, {"pytest": pytest("tests/addon", "tests/blender", *session.posargs)})


def run_each(session: nox.Session, commands: Mapping[str, Sequence[str]]) -> None:
    """Runs every command, whatever became of those before; those that failed are named at the end."""
    failed = []
    for name, command in commands.items():
        try:
            session.run(*command, env=ENVIRONMENT, **PATIENT)
        except CommandFailed:
            failed.append(name)
    if failed:
        session.warn(f"failed: {', '.join(failed)}")
        raise CommandFailed(f"failed: {', '.join(failed)}")


def pytest(*arguments: str) -> Sequence[str]:
    side_by_side = () if any(argument.startswith(("-n", "--dist")) for argument in arguments) else SIDE_BY_SIDE
    return (PYTHON, "-m", "pytest", *side_by_side, *arguments)


def execute_notebooks() -> Sequence[str]:
    return (str(PROGRAMS / "jupyter-execute"), *map(str, sorted(ROOT.glob("examples/*.ipynb"))))


def which_tests(arguments: list[str]) -> list[str]:
    """``arguments`` for pytest; all tests where they name no file or folder of tests."""
    if any((ROOT / argument.split("::")[0]).exists() for argument in arguments if not argument.startswith("-")):
        return arguments
    return ["tests", *(os.path.relpath(folder, ROOT) for folder in sorted(ROOT.glob("plugins/*/tests"))), *arguments]


@nox.session(requires=["setup"])
def addon(session: nox.Session) -> None:
    """Builds the Blender extension (ARGS: where to)."""
    session.chdir(session.invoked_from)
    session.run(PYTHON, str(ROOT / "tools" / "extension.py"), *session.posargs)


@nox.session(requires=["setup"])
def demo(session: nox.Session) -> None:
    """The whole way once, on a simulated recording (ARGS: the folder it goes to)."""
    session.chdir(session.invoked_from)
    session.run(str(PROGRAMS / "mcsl"), "demo", *session.posargs, **PATIENT)


@nox.session
def docs(session: nox.Session) -> None:
    """Writes the pages that are derived from the code."""
    session.run(PYTHON, "docs/generate.py")


@nox.session
def site(session: nox.Session) -> None:
    """Builds the documentation site into build/site; a link that leads nowhere is an error."""
    run_each(session, {"site": SITE})


@nox.session
def examples(session: nox.Session) -> None:
    """Runs every notebook of examples/ from top to bottom; what they show is not written back."""
    run_each(session, {"examples": execute_notebooks()})


@nox.session
def lock(session: nox.Session) -> None:
    """Pins the newest packages that fit, for every system and Python we support, with the hashes of their files."""
    session.run(PYTHON, "tools/lock.py")


@nox.session
def audit(session: nox.Session) -> None:
    """Asks public databases whether what requirements.lock pins has known holes; a note where none answers."""
    session.run(PYTHON, "tools/audit.py")
