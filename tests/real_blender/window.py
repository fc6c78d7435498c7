"""Run by Blender with its window: one of the pieces of work beside this file, step after step.

    blender --gpu-backend opengl edit.blend -P window.py -- OUT work|first|editing|long_day

Each step comes once the window had time to draw what the last one did; one that returns True is asked again. OUT gets
the pictures, and NAME.json with what was seen.
"""

import importlib
import json
import os
import sys
import traceback
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
from hands import OUT, WAIT_S, seen

PATIENCE = 600  # times that a step is asked again
NAME = sys.argv[-1]
STEPS = importlib.import_module(NAME).STEPS


def run(index=0, tries=0):
    try:
        if index == len(STEPS):
            (OUT / f"{NAME}.json").write_text(json.dumps(seen, indent=1))
            os._exit(0)
        again = STEPS[index]() is True
        assert tries < PATIENCE, f"step {index} of {NAME} did not end"
    except BaseException:
        traceback.print_exc()
        (OUT / f"{NAME}.json").write_text(json.dumps({"error": traceback.format_exc()}))
        sys.stdout.flush()
        os._exit(1)
    following = (index, tries + 1) if again else (index + 1, 0)
    bpy.app.timers.register(lambda: run(*following), first_interval=WAIT_S, persistent=True)


bpy.app.timers.register(run, first_interval=WAIT_S, persistent=True)
