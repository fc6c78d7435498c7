"""Blender as a tool of ours: which one is used and why, and running a task in it as a child process.

Blender is either a binary or a Python that has the module bpy. Nothing here imports bpy. The child is
blender_addon/background.py; it is started as a separate program and spoken to in JSON.
"""

from __future__ import annotations

import importlib.util
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Literal, NoReturn

import platformdirs
from attrs import frozen

from .errors import BlenderError, InputError, UsageError
from .progress import CancelToken, Progress, Silent

SUPPORTED = {(4, 5): "4.5 LTS", (5, 0): "5.0", (5, 2): "5.2 LTS"}
SUPPORTED_TEXT = "4.5 LTS, 5.0 or 5.2 LTS"
_POLL_S = 0.05


@frozen
class Blender:
    """A Blender that can be run. kind: a binary, or a Python with bpy. why: where it was found, for a person."""

    kind: Literal["binary", "module"]
    command: str
    version: str
    why: str


def home() -> Path:
    """mcsl's own folder for what it installs: MCSL_HOME, or the user's data folder."""
    given = os.environ.get("MCSL_HOME")
    return Path(given) if given else Path(platformdirs.user_data_dir("mcsl"))


def private_python() -> Path:
    """Where the Python of the private environment is, if `mcsl blender install` made one."""
    folder = home() / "blender-env"
    return folder / "Scripts" / "python.exe" if os.name == "nt" else folder / "bin" / "python"


def find(explicit: str | None = None) -> Blender:
    """The Blender to use: ``explicit``, MCSL_BLENDER, `blender` on PATH, bpy in this Python, the private environment.

    The first two may name a Blender binary or a Python that has bpy. What is named there and unfit is an error; an
    unfit Blender that was only come across is passed over, and named if nothing else is found. Raises BlenderError.
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
        return _probe(str(private_python()), "the private environment of `mcsl blender install`")
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
    return Blender(kind, command, number, why)


# --------------------------------------------------------------------------------------------------------- running


def script() -> Path:
    """The child's script, blender_addon/background.py, without importing the add-on."""
    spec = importlib.util.find_spec("blender_addon")
    if spec is None or spec.origin is None:
        raise BlenderError("the add-on's files are missing", remedy="Install mcsl again")
    return Path(spec.origin).with_name("background.py")


def search_paths() -> list[str]:
    """Folders the child appends to its own: those that hold mcsl, attrs, cattrs and what they need, all pure Python."""
    folders = [script().parents[1]]
    for name in ("mcsl_core", "attr", "attrs", "cattrs", "typing_extensions"):
        spec = importlib.util.find_spec(name)
        if spec is not None and spec.origin is not None:
            folders.append(Path(spec.origin).parent if name == "typing_extensions" else Path(spec.origin).parents[1])
    return list(dict.fromkeys(str(folder.resolve()) for folder in folders))


def run(blender: Blender, request: Mapping[str, Any], progress: Progress | None = None) -> dict[str, Any]:
    """Runs a task of blender_addon/tasks.py in a child process and returns its result.

    The user's Blender settings play no part. Progress is passed on as it comes; when it raises (a cancel), the child
    and its children are killed first. Raises what the task refused (InputError, UsageError), else BlenderError with
    the last lines of Blender's own output.
    """
    progress = progress or Silent()
    with tempfile.TemporaryDirectory(prefix="mcsl-blender-") as name:
        folder = Path(name)
        messages, log, order = folder / "messages", folder / "log", folder / "request.json"
        messages.touch()
        order.write_text(json.dumps({**request, "messages": str(messages), "paths": search_paths()}), encoding="utf-8")
        if blender.kind == "binary":
            command = [blender.command, "-b", "--factory-startup", "-P", str(script()), "--", str(order)]
        else:
            command = [blender.command, str(script()), str(order)]
        environment = {**os.environ, "BLENDER_USER_RESOURCES": str(folder / "user"), "PYTHONDONTWRITEBYTECODE": "1"}
        environment.pop("PYTHONPATH", None)  # ours holds packages for another Python
        with open(log, "wb") as stream:
            child = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=subprocess.STDOUT,
                env=environment,
                start_new_session=True,
            )
        try:
            last = _listen(child, messages, progress)
        finally:
            _end(child)
        if "result" in last:
            return last["result"]
        _raise(blender, last.get("error"), child.returncode, log.read_text("utf-8", "replace"))


def _listen(child: subprocess.Popen[bytes], messages: Path, progress: Progress) -> dict[str, Any]:
    """Passes messages on until the child ends; the last one is the answer."""
    last: dict[str, Any] = {}
    done, rest = None, b""
    with open(messages, "rb") as stream:
        while True:
            ended = child.poll() is not None  # asked before reading: what it wrote last is then there
            rest += stream.read()
            *lines, rest = rest.split(b"\n")
            for line in lines:
                last = json.loads(line)
                if "stage" in last:
                    done = None
                    progress.stage(last["stage"], last["total"], last["unit"])
                elif "done" in last:
                    done = last["done"]
                    progress.advance(done)
                elif "note" in last:
                    progress.note(last["note"])
            if ended:
                return last
            if done is not None and not lines:
                progress.advance(done)  # nothing new, but the chance to stop
            if isinstance(token := getattr(progress, "token", None), CancelToken):
                token.check()
            time.sleep(_POLL_S)


def _end(child: subprocess.Popen[bytes]) -> None:
    """The child and whatever it started are gone when this returns."""
    if os.name == "nt":
        child.kill()
    elif child.poll() is None:
        os.killpg(child.pid, signal.SIGKILL)
    child.wait()


def _raise(blender: Blender, error: dict[str, Any] | None, code: int, log: str) -> NoReturn:
    tail = "\n".join(line for line in log.strip().splitlines()[-8:])
    if error is not None:
        kinds = {2: UsageError, 3: InputError}
        kind = kinds.get(error.get("exit_code", 4), BlenderError)
        what = error["what"]
        if kind is BlenderError and tail:
            what += f"\n{tail}\n"
        raise kind(what, where=error.get("where", ""), remedy=error.get("remedy", ""))
    from .blender_environment import explain_missing  # only now: it is the rarer half

    if reason := explain_missing(blender, log):
        raise reason
    how = f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with code {code} and no answer"
    raise BlenderError(
        f"Blender {blender.version} {how}" + (f"; its last words:\n{tail}\n" if tail else ""),
        where=blender.command,
        remedy="Run again with fewer things open; if it comes back, another Blender may do (`mcsl blender`)",
    )
