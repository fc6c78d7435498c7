# SPDX-License-Identifier: GPL-3.0-or-later
"""The child process that has Blender inside. Run by mcsl_core.blender.run as one of

    blender -b --factory-startup -P background.py -- REQUEST.json
    python-with-bpy background.py REQUEST.json

The request names the task, its values, `paths` (folders to search after Blender's own) and `messages`, the file that
takes the answers as JSON lines. Standard output is Blender's: 5.0 prints a line a frame there. The last message is
{"result": ...} or {"error": ...}.
"""

from __future__ import annotations

import json
import os
import sys
import traceback
from pathlib import Path


def main() -> None:
    request = json.loads(Path(sys.argv[-1]).read_text("utf-8"))
    here = str(Path(__file__).resolve().parent)
    sys.path[:] = [p for p in sys.path if p != here]  # a script's folder comes first: our jobs.py hides no other
    sys.path.extend(p for p in request["paths"] if p not in sys.path)  # last, so that Blender's numpy stays its own
    with open(request["messages"], "a", encoding="utf-8") as stream:
        code = _answer(request, stream)
    sys.stdout.flush()
    sys.stderr.flush()
    # Not sys.exit: as a module, 4.5 hangs for minutes freeing its window layout after read_homefile.
    os._exit(code)


def _answer(request: dict, stream) -> int:
    try:
        from mcsl_core.errors import McslError
        from mcsl_core.progress import JsonLines
    except ImportError as error:
        stream.write(json.dumps({"error": {"what": f"cannot load mcsl: {error}", "exit_code": 4}}) + "\n")
        return 4
    progress = JsonLines(stream)
    try:
        from .tasks import TASKS

        progress.result(TASKS[request["task"]](request, progress))
    except McslError as error:
        progress.error(error.what, error.where, error.remedy, error.exit_code)
        return error.exit_code
    except BaseException as error:  # the parent must hear of everything, an interrupt or a missing library too
        traceback.print_exc()
        progress.error(f"{type(error).__name__}: {error}", where=f"Blender, task {request['task']}")
        return 4
    return 0


if __name__ == "__main__":
    main()
