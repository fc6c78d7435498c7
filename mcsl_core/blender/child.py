"""Running a task of the add-on in Blender: a child process that is spoken to in JSON and can be stopped.

The child is blender_addon/worker, a separate program under its own licence; `messages` holds what passes between the
two.
"""

from __future__ import annotations

import importlib.util
import json
import os
import signal
import subprocess
import time
from pathlib import Path
from typing import NoReturn, TypeVar

from mcsl_core.children import ended_afterwards
from mcsl_core.errors import BlenderError, InputError, McslError, UsageError
from mcsl_core.progress import CancelToken, Progress, Silent
from mcsl_core.temporary import sweep, temporary_folder

from .installation import Blender, explain_missing
from .messages import Done, Failed, Failure, MessageFile, Note, Request, Result, Stage, Step, structure, to_json

Answer = TypeVar("Answer")

_POLL_S = 0.05
_KINDS: dict[int, type[McslError]] = {kind.exit_code: kind for kind in (UsageError, InputError)}


def addon_parent() -> Path:
    """The folder that holds blender_addon: the source tree, or mcsl_core/data where mcsl is installed.

    Raises
    ------
    BlenderError
        It is in neither.
    """
    package = Path(__file__).resolve().parents[1]
    for parent in (package.parent, package / "data"):
        if (parent / "blender_addon" / "worker").is_dir():
            return parent
    raise BlenderError("the add-on's files are missing", where=str(package), remedy="Install mcsl again")


def script() -> Path:
    """The child's script. It imports the add-on as a package of its own, from `search_paths`."""
    return addon_parent() / "blender_addon" / "worker" / "__main__.py"


def search_paths() -> list[str]:
    """Folders the child appends to its own: of the add-on, mcsl and the packages they need there, all pure Python."""
    folders = [addon_parent()]
    for name in ("mcsl_core", "attr", "attrs", "cattrs", "filelock", "typing_extensions"):
        spec = importlib.util.find_spec(name)
        if spec is not None and spec.origin is not None:
            folders.append(Path(spec.origin).parent if name == "typing_extensions" else Path(spec.origin).parents[1])
    return list(dict.fromkeys(str(folder.resolve()) for folder in folders))


def run_task(blender: Blender, request: Request[Answer], progress: Progress | None = None) -> Answer:
    """Runs a task of blender_addon/worker/tasks.py in a child process. The user's Blender settings play no part.

    Parameters
    ----------
    blender
        The Blender to start.
    request
        What is to be done; its class names the task.
    progress
        Takes stages, counts and notes as they come. When it raises (a cancel), the child and its children are killed
        first.

    Returns
    -------
    Answer
        What the request's class says it is answered by.

    Raises
    ------
    InputError, UsageError
        The task refused the request.
    DocumentError
        The child's messages are not of this version's form.
    BlenderError
        Everything else, with the last lines of Blender's own output.
    """
    progress = progress or Silent()
    with temporary_folder("blender") as folder:
        messages, log, order = folder / "messages", folder / "log", folder / "order.json"
        messages.touch()
        values = {"parent": os.getpid(), "task": request.task, "request": to_json(request)}
        order.write_text(json.dumps({"paths": search_paths(), "messages": str(messages), **values}), encoding="utf-8")
        if blender.kind == "binary":
            command = [*blender.command, "-b", "--factory-startup", "-P", str(script()), "--", str(order)]
        else:
            command = [*blender.command, str(script()), str(order)]
        with open(log, "wb") as stream:
            child = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=subprocess.STDOUT,
                env=_environment(folder),
                start_new_session=True,
            )
        try:
            with ended_afterwards(child):
                last = _listen(child, MessageFile(messages), progress)
        finally:
            sweep(request.blend.parent)  # it may have been killed while it saved
        if isinstance(last, Result):
            return structure(last.result, request.answer, where=f"Blender's answer to the task {request.task}")
        _raise(blender, last and last.error, child.returncode, log.read_text("utf-8", "replace"))


def _environment(folder: Path) -> dict[str, str]:
    """The child's variables: settings and temporary files in ``folder``, since Blender leaves its own when ended."""
    temporary = folder / "tmp"
    temporary.mkdir()
    ours = {name: str(temporary) for name in ("TMPDIR", "TEMP", "TMP")}
    ours |= {"BLENDER_USER_RESOURCES": str(folder / "user"), "PYTHONDONTWRITEBYTECODE": "1"}
    # PYTHONPATH: ours holds packages for another Python.
    return {name: value for name, value in os.environ.items() if name != "PYTHONPATH"} | ours


def _listen(child: subprocess.Popen[bytes], messages: MessageFile, progress: Progress) -> Result | Failed | None:
    """Passes progress on until the child ends; its answer, or None where it gave none."""
    answer, done = None, None
    while True:
        ended = child.poll() is not None  # asked before reading: what it wrote last is then there
        news = messages.read(ended=ended)
        for message in news:
            match message:
                case Stage(name, total, unit):
                    done = None
                    progress.stage(name, total, unit)
                case Done(done):
                    progress.advance(done)
                case Note(text):
                    progress.note(text)
                case Result() | Failed():
                    answer = message
                case Step():  # a task in Blender is one
                    pass
        if ended:
            return answer
        if done is not None and not news:
            progress.advance(done)  # nothing new, but the chance to stop
        if isinstance(token := getattr(progress, "token", None), CancelToken):
            token.check()
        time.sleep(_POLL_S)


def _raise(blender: Blender, error: Failure | None, code: int, log: str) -> NoReturn:
    if reason := explain_missing(blender, log):
        raise reason
    tail = "\n".join(line for line in log.strip().splitlines()[-8:])
    if error is not None:
        kind = _KINDS.get(error.exit_code, BlenderError)
        what = error.what
        if kind is BlenderError and tail:
            what += f"\n{tail}\n"
        raise kind(what, where=error.where, remedy=error.remedy)
    how = f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with code {code} and no answer"
    raise BlenderError(
        f"Blender {blender.version} {how}" + (f"; its last words:\n{tail}\n" if tail else ""),
        where=" ".join(blender.command),
        remedy="Run again with fewer things open; if it comes back, another Blender may do (`mcsl blender`)",
    )
