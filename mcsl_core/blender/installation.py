"""Blender as a tool of ours: which one is used and why, what it lacks to start, and making one of our own.

Blender is either a binary or a Python that has the module bpy. Nothing here imports bpy. Each bpy has a wheel for one
Python only, so ours lives in an environment of its own, and it links against system libraries that a bare Debian
lacks. Running a task in a Blender is child.py.
"""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Literal

import platformdirs
from attrs import frozen

from mcsl_core.children import ended_afterwards
from mcsl_core.errors import BlenderError, McslError, UsageError
from mcsl_core.progress import Progress, Silent
from mcsl_core.temporary import sweep, temporary_beside

SUPPORTED = {(4, 5): "4.5 LTS", (5, 0): "5.0", (5, 2): "5.2 LTS"}
SUPPORTED_TEXT = "4.5 LTS, 5.0 or 5.2 LTS"

PRIVATE = "the private environment of `mcsl blender install`"

# Blender -> the Python that its bpy has a wheel for, and the requirement. In order of preference.
WHEELS = {"5.0": ("3.11", "bpy==5.0.1"), "5.2": ("3.13", "bpy>=5.2,<5.3"), "4.5": ("3.11", "bpy>=4.5.15,<4.6")}
UNASKED = ("5.0", "5.2")  # what is installed where no version is asked for: what fits a Python that is here
BESIDE = ("attrs>=24.2", "cattrs>=24.1")

# Shared object -> Debian package (trixie and bookworm), of everything bpy links against outside the C library.
PACKAGES = {
    "libX11.so.6": "libx11-6",
    "libXrender.so.1": "libxrender1",
    "libXfixes.so.3": "libxfixes3",
    "libXi.so.6": "libxi6",
    "libXext.so.6": "libxext6",
    "libxcb.so.1": "libxcb1",
    "libXxf86vm.so.1": "libxxf86vm1",
    "libxkbcommon.so.0": "libxkbcommon0",
    "libSM.so.6": "libsm6",
    "libICE.so.6": "libice6",
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",
}


@frozen
class Blender:
    """A Blender that can be run.

    Attributes
    ----------
    kind
        A binary, or a Python with Blender as the module bpy.
    command
        The words that start it.
    version
        Such as 5.0.1.
    why
        Which rule found it.
    """

    kind: Literal["binary", "module"]
    command: tuple[str, ...]
    version: str
    why: str

    def __str__(self) -> str:
        what = "Blender" if self.kind == "binary" else "Python with Blender as a module,"
        return f"{what} {self.version}: {' '.join(self.command)} ({self.why})"


def home() -> Path:
    """mcsl's own folder for what it installs: MCSL_HOME, or the user's data folder."""
    given = os.environ.get("MCSL_HOME")
    return Path(given) if given else Path(platformdirs.user_data_dir("mcsl"))


def private_python(version: str | None = None) -> Path:
    """Where the Python of the private environment is, if `mcsl blender install` made one (with --version: for it)."""
    folder = home() / ("blender-env" if version is None else f"blender-env-{version}")
    return folder / "Scripts" / "python.exe" if os.name == "nt" else folder / "bin" / "python"


def find(explicit: str | None = None) -> Blender:
    """The Blender to use.

    Looked for in this order: ``explicit``, MCSL_BLENDER, `blender` on PATH, bpy in this Python, the private
    environment. What is named and unfit is an error; an unfit Blender that was only come across is passed over, and
    named if nothing else is found.

    Parameters
    ----------
    explicit
        A Blender binary, or a Python that has bpy.

    Raises
    ------
    BlenderError
        None was found, or the one that is named is unfit.
    """
    if explicit:
        return _probe(explicit, "given by --blender")
    if named := os.environ.get("MCSL_BLENDER"):
        return _probe(named, "named by MCSL_BLENDER")
    passed_over: list[str] = []
    if on_path := shutil.which("blender"):
        try:
            return _probe(on_path, "`blender` on PATH")
        except BlenderError as error:
            passed_over.append(str(error))
    if importlib.util.find_spec("bpy") is not None:
        try:
            return _checked("module", sys.executable, _own_bpy_version(), "bpy in this Python")
        except BlenderError as error:
            passed_over.append(str(error))
    if private_python().exists():
        return _probe(str(private_python()), PRIVATE)
    raise BlenderError(
        "no Blender was found" + (f" (passed over: {'; '.join(passed_over)})" if passed_over else ""),
        remedy=f"Run `mcsl blender install`, or name one ({SUPPORTED_TEXT}) by --blender or MCSL_BLENDER",
    )


def _own_bpy_version() -> str:
    try:
        return version("bpy")
    except PackageNotFoundError:
        return "unknown"


def _probe(command: str, why: str) -> Blender:
    """What ``command`` is, by asking it."""
    path = shutil.which(command)
    if path is None:
        raise BlenderError(f"{command} is not a program", where=why, remedy=f"Name a Blender {SUPPORTED_TEXT}")
    said = _ask([path, "--version"], why)
    if found := re.search(r"^Blender (\d+\.\d+\.\d+)", said, re.MULTILINE):
        return _checked("binary", path, found[1], why)
    if said.startswith("Python 3"):
        said = _ask([path, "-c", "from importlib.metadata import version as v; print('bpy', v('bpy'))"], why)
        if found := re.search(r"^bpy (\S+)", said, re.MULTILINE):
            return _checked("module", path, found[1], why)
        raise BlenderError(f"{path} is a Python without bpy", where=why, remedy="Run `mcsl blender install`")
    raise BlenderError(
        f"{path} is neither a Blender nor a Python", where=why, remedy=f"Name a Blender {SUPPORTED_TEXT}"
    )


def _ask(command: list[str], why: str) -> str:
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise BlenderError(f"{command[0]} does not run ({error})", where=why) from error
    return done.stdout + done.stderr


def _checked(kind: Literal["binary", "module"], command: str, number: str, why: str) -> Blender:
    parts = tuple(int(p) for p in re.findall(r"\d+", number)[:2])
    if parts not in SUPPORTED:
        raise BlenderError(
            f"Blender {number} at {command} is not supported",
            where=why,
            remedy=f"Use {SUPPORTED_TEXT}, or run `mcsl blender install`",
        )
    return Blender(kind, (command,), number, why)


# -------------------------------------------------------------------------------------------------------- what it lacks


@frozen
class Diagnosis:
    """Whether a Blender starts.

    Attributes
    ----------
    missing
        Shared objects that the system lacks.
    install
        The line that brings them, or ''.
    said
        The last line of what it said instead of starting.
    """

    starts: bool
    missing: tuple[str, ...] = ()
    install: str = ""
    said: str = ""


def diagnose(blender: Blender) -> Diagnosis:
    """Starts ``blender`` once and, where it does not start, says which system libraries are missing."""
    ask = ["-b", "--factory-startup", "--version"] if blender.kind == "binary" else ["-c", "import bpy"]
    try:
        done = subprocess.run([*blender.command, *ask], capture_output=True, text=True, timeout=120, check=False)
    except (OSError, subprocess.TimeoutExpired) as error:
        return Diagnosis(False, said=str(error))
    said = done.stdout + done.stderr
    if done.returncode == 0:
        return Diagnosis(True)
    missing = _missing_of(blender) or tuple(named_by_loader(said))
    return Diagnosis(False, missing, install_line(missing), said.strip().splitlines()[-1] if said.strip() else "")


def explain_missing(blender: Blender, log: str) -> McslError | None:
    """The error to raise when ``log`` shows the loader missing a library; None when that is not what it shows."""
    if not (named := named_by_loader(log)):
        return None
    missing = _missing_of(blender) or tuple(named)
    return BlenderError(
        f"Blender {blender.version} cannot start: the system lacks {', '.join(missing)}",
        where=" ".join(blender.command),
        remedy=f"Run: {install_line(missing)}",
    )


def named_by_loader(text: str) -> list[str]:
    """The shared object the dynamic loader says it cannot open; it names only the first."""
    return re.findall(r"([\w.+-]+\.so[\w.]*): cannot open shared object file", text)


def not_found(listing: str) -> list[str]:
    """The shared objects that ldd's listing has as not found, each once."""
    return list(dict.fromkeys(re.findall(r"^\s*(\S+) => not found", listing, re.MULTILINE)))


def install_line(missing: tuple[str, ...] | list[str]) -> str:
    """The one line that brings them on Debian; what no package is known for is named after it."""
    packages = sorted({PACKAGES[name] for name in missing if name in PACKAGES})
    unknown = [name for name in missing if name not in PACKAGES]
    line = f"apt-get install -y {' '.join(packages)}" if packages else ""
    if unknown:
        line += f"{' ; ' if line else ''}# and the packages that hold {' '.join(unknown)}"
    return line


def _missing_of(blender: Blender) -> tuple[str, ...]:
    """All missing libraries at once, by ldd; () where there is no ldd."""
    if (ldd := shutil.which("ldd")) is None:
        return ()
    target = blender.command[0] if blender.kind == "binary" else _bpy_library(blender.command)
    if target is None:
        return ()
    done = subprocess.run([ldd, target], capture_output=True, text=True, timeout=60, check=False)
    return tuple(not_found(done.stdout))


def _bpy_library(python: tuple[str, ...]) -> str | None:
    """The path of bpy's shared object, found without loading it."""
    code = "import importlib.util as u; print(u.find_spec('bpy').origin)"
    done = subprocess.run([*python, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    return done.stdout.strip() or None


# ------------------------------------------------------------------------------------------------------ installing


def install(progress: Progress | None = None, version: str | None = None) -> Blender:
    """Makes the private environment and returns its Blender. Whole or not at all; one that is there is kept.

    Parameters
    ----------
    progress
        Where the work reports to.
    version
        Such as 4.5. It gets an environment of its own, which is used only where it is named.

    Raises
    ------
    UsageError
        There is no such version to install.
    BlenderError
        No Python with a wheel was found, pip failed, or the module does not start.
    """
    progress = progress or Silent()
    if version is not None and version not in WHEELS:
        raise UsageError(f"there is no Blender {version} to install", remedy=f"Take one of {', '.join(sorted(WHEELS))}")
    own = private_python(version)
    target = own.parents[1]
    sweep(target.parent)
    if own.exists():
        progress.note(f"{target} is there already; delete it to make it anew")
        return _probe(str(own), PRIVATE)
    python, number, requirement = _python_with_wheel(UNASKED if version is None else (version,))
    home().mkdir(parents=True, exist_ok=True)
    part = temporary_beside(target)
    try:
        progress.stage(f"making an environment with Python {number}")
        _call([python, "-m", "venv", str(part)], progress.note)
        progress.stage(f"installing {requirement}")
        inside = part / own.relative_to(target)
        _call(
            [str(inside), "-m", "pip", "install", "--disable-pip-version-check", requirement, *BESIDE],
            lambda line: progress.note(line) if line.startswith(("Downloading", "Successfully")) else None,
        )
        progress.stage("starting it once")
        diagnosis = diagnose(Blender("module", (str(inside),), "new", "just installed"))
        if not diagnosis.starts:
            raise BlenderError(
                f"bpy is installed but does not start: {diagnosis.said}",
                remedy=f"Run: {diagnosis.install}" if diagnosis.install else "See `mcsl blender`",
            )
        part.replace(target)
    except BaseException:
        shutil.rmtree(part, ignore_errors=True)
        raise
    return _probe(str(own), PRIVATE)


def _python_with_wheel(versions: tuple[str, ...]) -> tuple[str, str, str]:
    """A Python that one of these bpy has a wheel for, its number, and the requirement.

    This Python, else one on PATH that really runs (a pyenv shim may not).
    """
    own = f"{sys.version_info.major}.{sys.version_info.minor}"
    wheels = dict(WHEELS[version] for version in versions)
    if own in wheels:
        return sys.executable, own, wheels[own]
    for number, requirement in wheels.items():
        if (path := shutil.which(f"python{number}")) is None:
            continue
        check = f"import sys, venv, ensurepip; assert sys.version_info[:2] == {tuple(map(int, number.split('.')))}"
        if subprocess.run([path, "-c", check], capture_output=True, timeout=60, check=False).returncode == 0:
            return path, number, requirement
    raise BlenderError(
        f"bpy has wheels for Python {' and '.join(wheels)} only; this is {own}, and none of them is on PATH",
        remedy=f"Install one of them (on Debian: apt-get install -y python{next(iter(wheels))}-venv), "
        "or name a Blender by --blender or MCSL_BLENDER",
    )


def _call(command: list[str], report: Callable[[str], None]) -> None:
    """Runs a command, handing its lines on as they come; BlenderError with its last lines when it fails."""
    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "PYTHONHOME")}
    lines: list[str] = []
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True, env=environment
    ) as child:
        assert child.stdout is not None
        with ended_afterwards(child):
            for line in child.stdout:
                lines.append(line.rstrip())
                report(lines[-1].strip())
            child.wait()
    if child.returncode != 0:
        tail = "\n".join(lines[-6:])
        raise BlenderError(
            f"{' '.join(command[1:4])} failed:\n{tail}\n", where=command[0], remedy="See the lines above"
        )
