# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the `mcsl` program is: the one the preferences name, else found by itself. No bpy.

Blender has a Python of its own, and mcsl needs libraries that do not belong in it, so mcsl is a program of its own
that job.py starts. Looked for in this order: the path in the preferences, the environment variable MCSL, PATH, and
the places where pip, pipx, uv and the project's own set-up put programs. The first that is there is taken; whether it
runs is asked by `version_of`.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Iterator, Mapping
from pathlib import Path

from attrs import frozen

from mcsl_core.errors import InputError

INSTALL = "pipx install ."  # in the folder of mcsl's source
NEEDED = "mcsl is not installed here"
REMEDY = f"In the folder of mcsl's source run: {INSTALL}"


@frozen
class Found:
    """An `mcsl` that is there. why: which rule found it."""

    path: Path
    why: str


def find(preferred: str = "", environ: Mapping[str, str] = os.environ, home: Path | None = None) -> Found:
    """The `mcsl` to run.

    Parameters
    ----------
    preferred
        What the preferences name, or ''. What they or MCSL name must be there: another is not taken silently in its
        place.
    environ, home
        Stand for the environment and the user's folder.

    Raises
    ------
    InputError
        There is none; the error says by which command one is installed.
    """
    home = home or Path.home()
    for named, why in ((preferred.strip(), "the preferences"), (environ.get("MCSL", "").strip(), "MCSL")):
        if named:
            path = Path(os.path.expanduser(named))
            if not _runs(path):
                raise InputError(
                    "is not a program", where=f"{path} ({why})", remedy="Name the mcsl program, or leave it empty"
                )
            return Found(path, why)
    if on_path := shutil.which("mcsl", path=environ.get("PATH", "")):
        return Found(Path(on_path), "PATH")
    for folder in usual_places(environ, home):
        for name in ("mcsl", "mcsl.exe"):
            if _runs(folder / name):
                return Found(folder / name, "a usual place")
    raise InputError(NEEDED, remedy=REMEDY)


def usual_places(environ: Mapping[str, str], home: Path) -> Iterator[Path]:
    """The folders in which pip, pipx, uv, Homebrew and a virtual environment put programs, on every system."""
    inside = "Scripts" if os.name == "nt" else "bin"
    if environment := environ.get("VIRTUAL_ENV"):
        yield Path(environment) / inside
    yield home / ".local" / "bin"  # pip --user, pipx and uv on Linux and macOS; pipx and uv on Windows
    pipx = Path(environ["PIPX_HOME"]) if environ.get("PIPX_HOME") else None
    for base in (pipx, home / ".local" / "share" / "pipx", home / ".local" / "pipx", home / "pipx"):
        if base is not None:
            yield base / "venvs" / "mcsl" / inside
    yield home / ".local" / "share" / "uv" / "tools" / "mcsl" / inside
    for python in sorted((home / "Library" / "Python").glob("3.*"), reverse=True):  # pip --user on macOS
        yield python / "bin"
    if roaming := environ.get("APPDATA"):
        for python in sorted((Path(roaming) / "Python").glob("Python3*"), reverse=True):  # pip --user on Windows
            yield python / "Scripts"
        yield Path(roaming) / "uv" / "tools" / "mcsl" / inside
    if os.name != "nt":
        yield Path("/usr/local/bin")
        yield Path("/opt/homebrew/bin")


def _runs(path: Path) -> bool:
    return path.is_file() and os.access(path, os.X_OK)


def version_of(path: Path, timeout_s: float = 60.0) -> str:
    """What the program calls its version, such as 0.1.0.

    Raises
    ------
    InputError
        It does not run, or is something else.
    """
    try:
        done = subprocess.run(
            [str(path), "--version"],
            capture_output=True,
            text=True,
            timeout=timeout_s,
            check=False,
            stdin=subprocess.DEVNULL,
            env=child_environment(),
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise InputError(f"does not run ({error})", where=str(path), remedy=REMEDY) from error
    said = (done.stdout + done.stderr).strip()
    if done.returncode == 0 and (found := re.match(r"mcsl, version (\S+)", said)):
        return found[1]
    last = said.splitlines()[-1] if said else f"it ended with code {done.returncode}"
    raise InputError(f"is not an mcsl that runs ({last})", where=str(path), remedy=REMEDY)


def child_environment(environ: Mapping[str, str] = os.environ, *, language: str = "") -> dict[str, str]:
    """The environment without what points at Blender's own Python; with ``language``, in which mcsl then speaks."""
    kept = {k: v for k, v in environ.items() if k not in ("PYTHONPATH", "PYTHONHOME", "PYTHONSAFEPATH")}
    return kept | ({"LANGUAGE": language} if language else {})
