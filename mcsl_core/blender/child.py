"""Running a task of the add-on in Blender: a child process that is spoken to in JSON and can be stopped.

The child is blender_addon/worker, a separate program under its own licence.
"""

from __future__ import annotations

import importlib.util
import json
import os
import signal
import subprocess
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NoReturn

from mcsl_core.errors import BlenderError, InputError, UsageError
from mcsl_core.progress import CancelToken, Progress, Silent

from .installation import Blender, explain_missing

_POLL_S = 0.05


def script() -> Path:
    """The child's script, blender_addon/worker/__main__.py, without importing the add-on."""
    spec = importlib.util.find_spec("blender_addon")
    if spec is None or spec.origin is None:
        raise BlenderError("the add-on's files are missing", remedy="Install mcsl again")
    return Path(spec.origin).parent / "worker" / "__main__.py"


def search_paths() -> list[str]:
    """Folders the child appends to its own: those that hold mcsl, attrs, cattrs and what they need, all pure Python."""
    folders = [script().parents[2]]
    for name in ("mcsl_core", "attr", "attrs", "cattrs", "typing_extensions"):
        spec = importlib.util.find_spec(name)
        if spec is not None and spec.origin is not None:
            folders.append(Path(spec.origin).parent if name == "typing_extensions" else Path(spec.origin).parents[1])
    return list(dict.fromkeys(str(folder.resolve()) for folder in folders))


def run_task(blender: Blender, request: Mapping[str, Any], progress: Progress | None = None) -> dict[str, Any]:
    """Runs a task of blender_addon/worker/tasks.py in a child process and returns its result.

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
            command = [*blender.command, "-b", "--factory-startup", "-P", str(script()), "--", str(order)]
        else:
            command = [*blender.command, str(script()), str(order)]
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
    if reason := explain_missing(blender, log):
        raise reason
    tail = "\n".join(line for line in log.strip().splitlines()[-8:])
    if error is not None:
        kinds = {2: UsageError, 3: InputError}
        kind = kinds.get(error.get("exit_code", 4), BlenderError)
        what = error["what"]
        if kind is BlenderError and tail:
            what += f"\n{tail}\n"
        raise kind(what, where=error.get("where", ""), remedy=error.get("remedy", ""))
    how = f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with code {code} and no answer"
    raise BlenderError(
        f"Blender {blender.version} {how}" + (f"; its last words:\n{tail}\n" if tail else ""),
        where=" ".join(blender.command),
        remedy="Run again with fewer things open; if it comes back, another Blender may do (`mcsl blender`)",
    )
