"""What scripts need that press the panel's buttons in a Blender: see `in_blender`."""

from __future__ import annotations

import shutil
from pathlib import Path

from mcsl_core.blender.child import search_paths

HERE = str(Path(__file__).parent)  # of panel_recorder.py
ON = f"""
    import time, warnings
    warnings.simplefilter("error")
    sys.path.extend({[*search_paths(), HERE]!r})
    import blender_addon, panel_recorder as recorder
    from blender_addon.ui import job_runner, refresh
    blender_addon.register()
    state = bpy.context.window_manager.mcsl_state
    def texts(*names):
        return [text for _, text, _ in recorder.draw(names or None)]
    def wait(seconds):
        run, until = job_runner.desk.running, time.monotonic() + seconds
        while job_runner.pump():
            assert time.monotonic() < until
            time.sleep(0.02)
        return run.job.status
    def go(frame):
        scene.frame_set(frame + 1)
"""

MCSL = f"""
    os.environ["MCSL"] = {shutil.which("mcsl")!r}
"""
