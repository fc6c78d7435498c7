#!/usr/bin/env python3
"""Makes the project's environment, from a fresh checkout with nothing but Python and git, and hands on to its tools.

    python3 dev.py demo [DIR]       the whole way once: simulated recording, analysis, Blender timeline, video
    python3 dev.py test [ARGS]      all checks and all tests (ARGS go to pytest)
    python3 dev.py fast [ARGS]      the quick tests only, without Blender
    python3 dev.py addon [OUT.zip]  builds the Blender extension (default: dist/mcsl-VERSION.zip)
    python3 dev.py test-addon [ARGS]   the tests of the extension, those inside Blender too
    python3 dev.py lint             the checks that run no test
    python3 dev.py lowest           the core's quick tests with the oldest packages that are allowed
    python3 dev.py docs             writes the generated pages
    python3 dev.py site             builds the documentation site
    python3 dev.py examples         runs the notebooks of examples/
    python3 dev.py lock             pins the newest packages that fit
    python3 dev.py setup            only sets up: the environment and Blender
    python3 dev.py mcsl ARGS        the command line itself
    python3 dev.py run PROGRAM ARGS    any program of the environment

The environment is .venv (another folder: MCSL_VENV), made from requirements.lock, and again when that, a pyproject.toml
or mcsl's version changes. All but the last two are sessions of nox there (noxfile.py). Standard library only.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent
OLDEST = (3, 11)
NAMES = ("python3.11", "python3.12", "python3.13", "python3.14")
TAKE_ARGUMENTS = ("demo", "test", "fast", "addon", "test-addon", "mcsl", "run")
COMMANDS = (*TAKE_ARGUMENTS, "lint", "lowest", "docs", "site", "examples", "lock", "setup")

VENV = Path(os.environ.get("MCSL_VENV") or ROOT / ".venv").absolute()
PROGRAMS = VENV / ("Scripts" if os.name == "nt" else "bin")
PYTHON = str(PROGRAMS / ("python.exe" if os.name == "nt" else "python"))
ALONE = {"PYTHONHOME": "", "PYTHONPATH": ""}  # no other environment shines through


class Failure(Exception):
    """Ends the command with one line for a person."""


def say(text: str) -> None:
    print(f"dev.py: {text}", flush=True)


def call(trouble: str, command: list[str], log: Path | None = None, **variables: str) -> None:
    """Runs a program in silence. Failure: ``trouble`` and what it said last; all that it said goes into ``log``."""
    environment = {**os.environ, **variables}
    done = subprocess.run(
        command, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    if done.returncode:
        lines = [line.strip() for line in done.stdout.decode("utf-8", "replace").splitlines() if line.strip()]
        errors = [line for line in lines if line.lower().startswith(("error", "e:"))]
        said = (errors or lines or ["nothing was said"])[-1]
        if log:
            log.write_bytes(done.stdout)
            said += f" (all of it: {log})"
        raise Failure(f"{trouble}: {said}")


def version_of(python: str) -> tuple[int, ...]:
    """(3, 12) of a Python that runs; () of one that does not (a shim may be there and still not run)."""
    try:
        command = [python, "-c", "import sys; print(*sys.version_info[:2])"]
        said = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout
        return tuple(int(part) for part in said.split())
    except (OSError, ValueError):
        return ()


def fitting_python() -> str:
    """This Python when it is new enough, else a newer one on PATH."""
    if sys.version_info[:2] >= OLDEST:
        return sys.executable
    for path in filter(None, map(shutil.which, NAMES)):
        if version_of(path) >= OLDEST:
            return path
    own = "{}.{}".format(*sys.version_info[:2])
    raise Failure(f"Python 3.11 or newer is needed; this is {own}, and none of {', '.join(NAMES)} is on PATH")


def install_system_packages(packages: list[str], reason: str) -> None:
    """Brings Debian packages where that is allowed, else Failure with the line that does."""
    line = "apt-get install -y " + " ".join(packages)
    if shutil.which("apt-get") is None:
        raise Failure(f"{reason}; bring what Debian calls {' '.join(packages)} with this system's package manager")
    root = [] if os.geteuid() == 0 else [shutil.which("sudo") or "false", "-n"]
    if root and subprocess.run([*root, "true"], stderr=subprocess.DEVNULL).returncode:
        raise Failure(f"{reason}; run as root: {line}")
    say(f"{reason}: {line}")
    for what in (["update"], ["install", "-y", "--no-install-recommends", *packages]):
        try:
            call(f"apt-get {what[0]} failed", [*root, "apt-get", "-q", *what], DEBIAN_FRONTEND="noninteractive")
        except Failure as failure:
            raise Failure(f"{reason}; {failure}; run as root: {line}") from None


def make_environment() -> None:
    """Installs what requirements.lock pins, the project and its plugins; quick when that was done before."""
    plugins = sorted(ROOT.glob("plugins/*/pyproject.toml"))
    wanted = hashlib.sha256(f"{ROOT}\n".encode())
    for file in (ROOT / "requirements.lock", ROOT / "pyproject.toml", ROOT / "mcsl_core" / "__init__.py", *plugins):
        wanted.update(f"{file.relative_to(ROOT)}\n".encode() + file.read_bytes())
    stamp, fits = VENV / "mcsl-setup", version_of(PYTHON) >= OLDEST
    if fits and stamp.is_file() and stamp.read_text() == wanted.hexdigest():
        return
    if not fits:
        if VENV.is_dir() and any(VENV.iterdir()) and not (VENV / "pyvenv.cfg").is_file():
            raise Failure(f"{VENV} is there and is no Python environment; name another folder by MCSL_VENV")
        python = fitting_python()
        if subprocess.run([python, "-c", "import ensurepip, venv"], stderr=subprocess.DEVNULL).returncode:
            package = "python{}.{}-venv".format(*version_of(python))
            install_system_packages([package], "Python's venv module is missing")
        say(f"making an environment with {python}")
        call(f"no environment could be made in {VENV}", [python, "-m", "venv", "--clear", str(VENV)])
    say(f"installing the Python packages into {VENV} (minutes, the first time)")
    projects = [part for file in (ROOT / "pyproject.toml", *plugins) for part in ("-e", str(file.parent))]
    for what in (
        ["--require-hashes", "-r", str(ROOT / "requirements.lock")],
        ["--no-deps", "--no-build-isolation", *projects],  # what they need, and what builds them, is there already
    ):
        command = [PYTHON, "-m", "pip", "install", "--disable-pip-version-check", *what]
        call("the Python packages could not be installed", command, VENV / "mcsl-setup.log", **ALONE)
    stamp.write_text(wanted.hexdigest())


def hand_on(command: list[str]) -> int:
    """Runs a program of the environment where the user stands. Ctrl-C goes to it as well: it ends when it has ended."""
    path = str(PROGRAMS) + os.pathsep + os.environ.get("PATH", "")
    try:
        child = subprocess.Popen(command, env={**os.environ, **ALONE, "VIRTUAL_ENV": str(VENV), "PATH": path})
    except OSError:
        raise Failure(f"{command[0]} is not there, or does not run") from None
    stopped = False
    while True:
        try:
            return 130 if child.wait() and stopped else child.returncode
        except KeyboardInterrupt:
            stopped = True


def main(arguments: list[str]) -> int:
    if arguments[:1] in (["-h"], ["--help"], ["help"]):
        print((__doc__ or "").strip())
        return 0
    command, rest = (arguments[0], arguments[1:]) if arguments else ("", [])
    if command not in COMMANDS or (rest and command not in TAKE_ARGUMENTS):
        wrong = f"unknown: {' '.join(arguments)}" if arguments else "what to do is missing"
        print(f"dev.py: {wrong}; one of {', '.join(COMMANDS)} (python3 dev.py --help tells more)", file=sys.stderr)
        return 2
    try:
        make_environment()
        if command == "mcsl":
            return hand_on([str(PROGRAMS / "mcsl"), *rest])
        if command == "run":
            return hand_on([str(PROGRAMS / "".join(rest[:1])), *rest[1:]])
        return hand_on([PYTHON, "-m", "nox", "-f", str(ROOT / "noxfile.py"), "-s", command, "--", *rest])
    except Failure as failure:
        print(f"dev.py: {failure}", file=sys.stderr, flush=True)
        return 1
    except KeyboardInterrupt:
        print("dev.py: stopped", file=sys.stderr, flush=True)
        return 130


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
