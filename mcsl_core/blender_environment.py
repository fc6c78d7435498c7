"""The private environment with bpy that `mcsl blender install` makes, and what a Blender lacks to start.

bpy is Blender as a Python module; each version has a wheel for one Python only, so it lives in an environment of its
own. It links against system libraries that a bare Debian lacks.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from attrs import frozen

from .blender import Blender, find, home, private_python
from .errors import BlenderError, McslError
from .progress import Progress, Silent

# Python -> the bpy that has a wheel for it. In order of preference: what the tests use first.
WHEELS = {"3.11": "bpy==5.0.1", "3.13": "bpy>=5.2,<5.3"}
BESIDE = ("attrs>=24.2", "cattrs>=24.1")

# Shared object -> Debian package (trixie and bookworm), of everything bpy links against outside the C library.
PACKAGES = {
    "libX11.so.6": "libx11-6",
    "libXrender.so.1": "libxrender1",
    "libXfixes.so.3": "libxfixes3",
    "libXi.so.6": "libxi6",
    "libXxf86vm.so.1": "libxxf86vm1",
    "libxkbcommon.so.0": "libxkbcommon0",
    "libSM.so.6": "libsm6",
    "libICE.so.6": "libice6",
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",
}


@frozen
class Diagnosis:
    """Whether a Blender starts. missing: shared objects it lacks. install: the line that brings them, or ''."""

    starts: bool
    missing: tuple[str, ...] = ()
    install: str = ""
    said: str = ""


def diagnose(blender: Blender) -> Diagnosis:
    """Starts ``blender`` once and, where it does not start, says which system libraries are missing."""
    ask = ["-b", "--factory-startup", "--version"] if blender.kind == "binary" else ["-c", "import bpy"]
    try:
        done = subprocess.run([blender.command, *ask], capture_output=True, text=True, timeout=120, check=False)
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
        where=blender.command,
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
    target = blender.command if blender.kind == "binary" else _bpy_library(blender.command)
    if target is None:
        return ()
    done = subprocess.run([ldd, target], capture_output=True, text=True, timeout=60, check=False)
    return tuple(not_found(done.stdout))


def _bpy_library(python: str) -> str | None:
    """The path of bpy's shared object, found without loading it."""
    code = "import importlib.util as u; print(u.find_spec('bpy').origin)"
    done = subprocess.run([python, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    return done.stdout.strip() or None


# ------------------------------------------------------------------------------------------------------ installing


def install(progress: Progress | None = None) -> Blender:
    """Makes the private environment and returns its Blender. Whole or not at all; one that is there is kept.

    Raises BlenderError when no Python with a wheel is found, pip fails, or the module does not start.
    """
    progress = progress or Silent()
    target = home() / "blender-env"
    if private_python().exists():
        progress.note(f"{target} is there already; delete it to make it anew")
        return find(str(private_python()))
    python, number = _python_with_wheel()
    home().mkdir(parents=True, exist_ok=True)
    part = Path(tempfile.mkdtemp(prefix="blender-env.part-", dir=home()))
    try:
        progress.stage(f"making an environment with Python {number}")
        _call([python, "-m", "venv", str(part)], progress.note)
        progress.stage(f"installing {WHEELS[number]}")
        inside = part / private_python().relative_to(target)
        _call(
            [str(inside), "-m", "pip", "install", "--disable-pip-version-check", WHEELS[number], *BESIDE],
            lambda line: progress.note(line) if line.startswith(("Downloading", "Successfully")) else None,
        )
        progress.stage("starting it once")
        diagnosis = diagnose(Blender("module", str(inside), "new", "just installed"))
        if not diagnosis.starts:
            raise BlenderError(
                f"bpy is installed but does not start: {diagnosis.said}",
                remedy=f"Run: {diagnosis.install}" if diagnosis.install else "See `mcsl blender`",
            )
        part.replace(target)
    except BaseException:
        shutil.rmtree(part, ignore_errors=True)
        raise
    return find(str(private_python()))


def _python_with_wheel() -> tuple[str, str]:
    """A Python that bpy has a wheel for: this one, else one on PATH that really runs (a pyenv shim may not)."""
    own = f"{sys.version_info.major}.{sys.version_info.minor}"
    if own in WHEELS:
        return sys.executable, own
    for number in WHEELS:
        if (path := shutil.which(f"python{number}")) is None:
            continue
        check = f"import sys, venv, ensurepip; assert sys.version_info[:2] == {tuple(map(int, number.split('.')))}"
        if subprocess.run([path, "-c", check], capture_output=True, timeout=60, check=False).returncode == 0:
            return path, number
    raise BlenderError(
        f"bpy has wheels for Python {' and '.join(WHEELS)} only; this is {own} and neither is on PATH",
        remedy=f"Install one of them (on Debian: apt-get install -y python{next(iter(WHEELS))}-venv), "
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
        try:
            for line in child.stdout:
                lines.append(line.rstrip())
                report(lines[-1].strip())
        except BaseException:
            child.kill()
            raise
    if child.returncode != 0:
        tail = "\n".join(lines[-6:])
        raise BlenderError(
            f"{' '.join(command[1:4])} failed:\n{tail}\n", where=command[0], remedy="See the lines above"
        )
