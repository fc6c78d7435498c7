# SPDX-License-Identifier: GPL-3.0-or-later
"""The child process that has Blender inside. Run by mcsl_core/blender/child.py as one of

    blender -b --factory-startup -P __main__.py -- ORDER.json
    python-with-bpy __main__.py ORDER.json

The order names the task and its request (mcsl_core/blender/messages.py), `paths` (folders to search after Blender's
own) and `messages`, the file that takes the answers as JSON lines. Standard output is Blender's: 5.0 prints a line a
frame there. The last message is {"result": ...} or {"error": ...}.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
import time
import traceback
from pathlib import Path
from typing import IO, Any


def main() -> None:
    """Carries out the order and ends the process with the exit code of its answer."""
    order = json.loads(Path(sys.argv[-1]).read_text("utf-8"))
    here = str(Path(__file__).resolve().parent)
    sys.path[:] = [p for p in sys.path if p != here]  # a script's folder comes first: our tasks.py hides no other
    sys.path.extend(p for p in order["paths"] if p not in sys.path)  # last, so that Blender's numpy stays its own
    threading.Thread(target=_end_with_parent, args=(order.get("parent"),), daemon=True).start()
    with open(order["messages"], "a", encoding="utf-8") as stream:
        code = _answer(order, stream)
    sys.stdout.flush()
    sys.stderr.flush()
    # Not sys.exit: as a module, 4.5 hangs for minutes freeing its window layout after read_homefile.
    os._exit(code)


def _end_with_parent(asked: int | None) -> None:
    """Ends this process and what it started once the one that asked is gone, killed or crashed: nobody waits for it.

    asked: its id, since it may be gone before this runs; between the two may stand a script that starts Blender.
    """
    if os.name == "nt":
        if asked is not None and _ended_on_windows(asked):
            os._exit(1)
        return
    parent = os.getppid()
    while True:
        if os.getppid() != parent or (asked is not None and not _lives(asked)):
            os.killpg(os.getpgid(0), signal.SIGKILL)
        time.sleep(0.5)


def _ended_on_windows(process: int) -> bool:
    """Waits until a process is gone; False where it cannot be watched, since it is another person's.

    There a process is asked for by a handle: a signal of 0, as below, would end it.
    """
    import ctypes

    kernel = ctypes.WinDLL("kernel32", use_last_error=True)  # pyright: ignore[reportAttributeAccessIssue]
    kernel.OpenProcess.restype = ctypes.c_void_p
    kernel.WaitForSingleObject.argtypes = [ctypes.c_void_p, ctypes.c_uint32]
    synchronize, forever, no_such_process = 0x100000, 0xFFFFFFFF, 87
    handle = kernel.OpenProcess(synchronize, False, process)
    if not handle:
        return ctypes.get_last_error() == no_such_process  # pyright: ignore[reportAttributeAccessIssue]
    kernel.WaitForSingleObject(handle, forever)
    return True


def _lives(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        pass  # it is there, and another's
    return True


def _answer(order: dict[str, Any], stream: IO[str]) -> int:
    try:
        from mcsl_core.errors import McslError
        from mcsl_core.progress import JsonLines
    except ImportError as error:
        stream.write(json.dumps({"error": {"what": f"cannot load mcsl: {error}", "exit_code": 4}}) + "\n")
        return 4
    progress = JsonLines(stream)
    try:
        from blender_addon.worker.tasks import carry_out  # by its full name: a script belongs to no package

        progress.result(carry_out(order["task"], order["request"], progress))
    except McslError as error:
        progress.error(error.what, error.where, error.remedy, error.exit_code)
        return error.exit_code
    except BaseException as error:  # the parent must hear of everything, an interrupt or a missing library too
        traceback.print_exc()
        progress.error(f"{type(error).__name__}: {error}", where=f"Blender, task {order['task']}")
        return 4
    return 0


if __name__ == "__main__":
    main()
