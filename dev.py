#!/usr/bin/env python3
"""Sets the project up and runs it, from a fresh checkout with nothing but Python and git.

    python3 dev.py demo [DIR]       the whole way once: simulated recording, analysis, Blender timeline, video
    python3 dev.py test [ARGS]      all checks and all tests (ARGS go to pytest)
    python3 dev.py fast [ARGS]      the quick tests only, without Blender
    python3 dev.py addon [OUT.zip]  builds the Blender extension (default: dist/mcsl-VERSION.zip)
    python3 dev.py test-addon [ARGS]   the tests of the extension, those inside Blender too
    python3 dev.py lint             ruff, pyright, generated pages up to date
    python3 dev.py docs             writes the generated pages
    python3 dev.py setup            only sets up
    python3 dev.py mcsl ARGS        the command line itself

Set-up is done by whichever comes first and again when pyproject.toml changes: an environment in .venv (another
folder: MCSL_VENV) and, where no Blender is found, one as a Python module (`mcsl blender install`, under MCSL_HOME);
for tests the oldest supported Blender as well (another: MCSL_BLENDER_OLDEST). Standard library only.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent
OLDEST = (3, 11)
OLDEST_BLENDER = "4.5"
NAMES = ("python3.11", "python3.12", "python3.13", "python3.14")

# Asked in the environment: is there a Blender, and which Debian packages would bpy still need?
ASK_BLENDER = """
import ctypes, json, sys
from mcsl_core.blender import PACKAGES, find
from mcsl_core.errors import BlenderError
try:
    kind = find().kind
except BlenderError:
    kind = ""
packages = set()
for library, package in PACKAGES.items() if sys.platform == "linux" and kind != "binary" else ():
    try:
        ctypes.CDLL(library)
    except OSError:
        packages.add(package)
print(json.dumps({"found": bool(kind), "packages": sorted(packages)}))
"""


class Failure(Exception):
    """Ends the command with one line for a person."""


def say(text: str) -> None:
    print(f"dev.py: {text}", flush=True)


# ------------------------------------------------------------------------------------------- finding a Python


def version_of(python: str) -> tuple[int, ...]:
    """(3, 12) of a Python that runs; () of one that does not (a shim may be there and still not run)."""
    try:
        done = subprocess.run(
            [python, "-c", "import sys; print(*sys.version_info[:2])"],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        return tuple(int(part) for part in done.stdout.split())
    except (OSError, ValueError):
        return ()


def fitting_python() -> str:
    """This Python when it is new enough, else a newer one on PATH."""
    if sys.version_info[:2] >= OLDEST:
        return sys.executable
    for name in NAMES:
        path = shutil.which(name)
        if path and version_of(path) >= OLDEST:
            return path
    own = "{}.{}".format(*sys.version_info[:2])
    raise Failure(f"Python 3.11 or newer is needed; this is {own}, and none of {', '.join(NAMES)} is on PATH")


# ----------------------------------------------------------------------------------------- the system's packages


def as_root() -> list[str] | None:
    """What to put before a command that needs root: nothing, sudo where it asks for no password, None where neither."""
    if hasattr(os, "geteuid") and os.geteuid() == 0:
        return []
    sudo = shutil.which("sudo")
    if sudo and subprocess.run([sudo, "-n", "true"], stderr=subprocess.DEVNULL).returncode == 0:
        return [sudo, "-n"]
    return None


def install_system_packages(packages: list[str], reason: str) -> None:
    """Brings Debian packages, or says the one line that does."""
    line = "apt-get install -y " + " ".join(packages)
    root = as_root()
    if shutil.which("apt-get") is None:
        raise Failure(f"{reason}; bring what Debian calls {' '.join(packages)} with this system's package manager")
    if root is None:
        raise Failure(f"{reason}; run as root: {line}")
    say(f"{reason}: {line}")
    environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    for arguments in (["update"], ["install", "-y", "--no-install-recommends", *packages]):
        done = subprocess.run(
            [*root, "apt-get", "-q", *arguments],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        if done.returncode:
            raise Failure(f"{reason}; apt-get {arguments[0]} failed: {last_line(done.stdout)}; run as root: {line}")


def last_line(output: bytes) -> str:
    """What a failed program said at the end: its last line that speaks of an error, else its last line."""
    lines = [line.strip() for line in output.decode("utf-8", "replace").splitlines() if line.strip()]
    errors = [line for line in lines if line.lower().startswith(("error", "e:"))]
    return (errors or lines or ["nothing was said"])[-1]


# --------------------------------------------------------------------------------------------- the environment


class Environment:
    """The project's own Python environment."""

    def __init__(self) -> None:
        self.folder = Path(os.environ.get("MCSL_VENV") or ROOT / ".venv").absolute()
        self.programs = self.folder / ("Scripts" if os.name == "nt" else "bin")
        self.python = str(self.programs / ("python.exe" if os.name == "nt" else "python"))
        self.stamp = self.folder / "mcsl-setup"

    def variables(self) -> dict[str, str]:
        """For programs run in it: its programs come first, and no other environment shines through."""
        kept = {k: v for k, v in os.environ.items() if k not in ("PYTHONHOME", "PYTHONPATH")}
        path = str(self.programs) + os.pathsep + kept.get("PATH", "")
        return {**kept, "VIRTUAL_ENV": str(self.folder), "PATH": path}

    def call(self, *arguments: str) -> int:
        """Runs its Python with arguments, from the project's folder or (for mcsl) where the user stands."""
        return subprocess.run([self.python, *arguments], env=self.variables(), cwd=ROOT).returncode

    def mcsl(self, *arguments: str) -> int:
        command = [self.python, "-c", "import sys; from mcsl_core.cli.main import main; sys.exit(main())", *arguments]
        return subprocess.run(command, env=self.variables()).returncode

    def wanted(self) -> str:
        """A text that changes when what is to be installed does."""
        digest = hashlib.sha256(f"{ROOT}\n".encode())
        for file in [ROOT / "pyproject.toml", *plugin_projects()]:
            digest.update(f"{file.relative_to(ROOT)}\n".encode() + file.read_bytes())
        return digest.hexdigest()

    def ready(self) -> bool:
        return self.stamp.is_file() and self.stamp.read_text() == self.wanted() and version_of(self.python) >= OLDEST

    def make(self) -> None:
        """Makes it and installs the project, its plugins and the tools for tests; quick when that was done before."""
        if self.ready():
            return
        if version_of(self.python) < OLDEST:
            self._create()
        say(f"installing the Python packages into {self.folder} (minutes, the first time)")
        projects = [part for file in plugin_projects() for part in ("-e", str(file.parent))]
        done = subprocess.run(
            [self.python, "-m", "pip", "install", "--disable-pip-version-check", "-e", f"{ROOT}[test]", *projects],
            env=self.variables(),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        if done.returncode:
            log = self.folder / "mcsl-setup.log"
            log.write_bytes(done.stdout)
            raise Failure(f"the Python packages could not be installed: {last_line(done.stdout)} (all of it: {log})")
        self.stamp.write_text(self.wanted())

    def _create(self) -> None:
        known = (self.folder / "pyvenv.cfg").is_file()
        if self.folder.is_dir() and any(self.folder.iterdir()) and not known:
            raise Failure(f"{self.folder} is there and is no Python environment; name another folder by MCSL_VENV")
        python = fitting_python()
        if subprocess.run([python, "-c", "import ensurepip, venv"], stderr=subprocess.DEVNULL).returncode:
            package = "python{}.{}-venv".format(*version_of(python))
            install_system_packages([package], "Python's venv module is missing")
        say(f"making an environment with {python}")
        done = subprocess.run(
            [python, "-m", "venv", "--clear", str(self.folder)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT
        )
        if done.returncode:
            raise Failure(f"no environment could be made in {self.folder}: {last_line(done.stdout)}")


def plugin_projects() -> list[Path]:
    return sorted(ROOT.glob("plugins/*/pyproject.toml"))


def bring_blender(environment: Environment) -> None:
    """Makes sure that a Blender is found and has its libraries; one as a Python module where there is none."""
    done = subprocess.run(
        [environment.python, "-c", ASK_BLENDER], env=environment.variables(), stdout=subprocess.PIPE, cwd=ROOT
    )
    if done.returncode:
        raise Failure("mcsl cannot say which Blender there is (its own words stand above)")
    answer = json.loads(done.stdout)
    if answer["packages"]:
        try:
            install_system_packages(answer["packages"], "Blender needs system libraries")
        except Failure as failure:  # it may do without some of them; where it does not, it says so itself
            say(str(failure))
    if not answer["found"]:
        say("bringing Blender as a Python module (several hundred megabytes, once)")
        if environment.mcsl("blender", "install"):
            raise Failure("Blender could not be brought; `python3 dev.py mcsl blender` says more")


def bring_oldest_blender(environment: Environment) -> None:
    """Makes sure that the tests which run in two Blenders have the second. Where it cannot be had they are skipped."""
    if not os.environ.get("MCSL_BLENDER_OLDEST") and environment.mcsl(
        "blender", "install", "--version", OLDEST_BLENDER
    ):
        say(f"without Blender {OLDEST_BLENDER} the tests that want it are skipped")


# ------------------------------------------------------------------------------------------------- the commands


def lint(environment: Environment) -> list[str]:
    """Runs every check; the names of those that failed."""
    checks = {
        "ruff check": ("-m", "ruff", "check", "."),
        "ruff format": ("-m", "ruff", "format", "--check", "--quiet", "."),
        "pyright": ("-m", "pyright", "--pythonpath", environment.python),
        "docs/generate.py --check": ("docs/generate.py", "--check"),
    }
    failed = []
    for name, arguments in checks.items():
        say(name)
        if environment.call(*arguments):
            failed.append(name)
    return failed


def pytest(environment: Environment, *arguments: str) -> list[str]:
    say("pytest")
    return ["pytest"] if environment.call("-m", "pytest", *arguments) else []


def which_tests(arguments: list[str]) -> list[str]:
    """``arguments`` for pytest; all tests where they name no file or folder of tests."""
    if any((ROOT / argument.split("::")[0]).exists() for argument in arguments if not argument.startswith("-")):
        return arguments
    return [*all_tests(), *arguments]


def all_tests() -> list[str]:
    return ["tests", *(str(f.parent / "tests") for f in plugin_projects() if (f.parent / "tests").is_dir())]


COMMANDS = ("demo", "test", "fast", "addon", "test-addon", "lint", "docs", "setup", "mcsl")
NEED_BLENDER = ("demo", "test", "addon", "test-addon", "setup")
NEED_THE_OLDEST = ("test", "test-addon")
TAKE_ARGUMENTS = ("demo", "test", "fast", "addon", "test-addon", "mcsl")


def run(command: str, arguments: list[str]) -> int:
    environment = Environment()
    environment.make()
    if command in NEED_BLENDER:
        bring_blender(environment)
    if command in NEED_THE_OLDEST:
        bring_oldest_blender(environment)
    if command in ("demo", "mcsl"):
        return environment.mcsl(*(["demo"] if command == "demo" else []), *arguments)
    failed: list[str] = []
    if command == "setup":
        say(f"ready: {environment.programs}")
    elif command == "docs":
        return environment.call("docs/generate.py")
    elif command == "lint":
        failed = lint(environment)
    elif command == "test":
        failed = [*lint(environment), *pytest(environment, *which_tests(arguments))]
    elif command == "fast":
        failed = pytest(environment, "-m", "not slow and not blender", *which_tests(arguments))
    elif command == "addon":
        return environment.call("tools/extension.py", *(str(Path(argument).absolute()) for argument in arguments))
    elif command == "test-addon":
        failed = pytest(environment, "tests/addon", "tests/blender", *arguments)
    if failed:
        raise Failure(f"failed: {', '.join(failed)}")
    return 0


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
        return run(command, rest)
    except Failure as failure:
        print(f"dev.py: {failure}", file=sys.stderr, flush=True)
        return 1
    except KeyboardInterrupt:
        print("dev.py: stopped", file=sys.stderr, flush=True)
        return 130


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
