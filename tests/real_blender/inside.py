"""Run by the real Blender without its window: the extension's own operators on a project.

blender -b --python-exit-code 1 -P inside.py -- build EDL BLEND
blender -b --python-exit-code 1 BLEND -P inside.py -- override CAMERA SECONDS ...
"""

import sys
from pathlib import Path

import bpy


def build(edl: str, blend: str) -> None:
    """The EDL's timeline, by the panel's button, saved beside the EDL."""
    bpy.ops.wm.read_homefile(app_template="Video_Editing", use_factory_startup=False)
    scene = bpy.context.scene
    for workspace in bpy.data.workspaces:
        workspace.sequencer_scene = scene
    scene.name = "Programme"
    bpy.ops.wm.save_as_mainfile(filepath=blend)
    assert bpy.ops.mcsl.build_timeline(filepath=edl) == {"FINISHED"}
    bpy.ops.wm.save_mainfile()


def override(*pairs: str) -> None:
    """Each CAMERA is shown from SECONDS to the end of the shot there; then the EDL is told."""
    scene = next(s for s in bpy.data.scenes if s.get("mcsl_edl"))
    rate = scene.render.fps / scene.render.fps_base
    for camera, seconds in zip(pairs[::2], pairs[1::2], strict=True):
        scene.frame_set(1 + round(float(seconds) * rate))
        assert bpy.ops.mcsl.switch_camera(camera=camera) == {"FINISHED"}, camera
    assert bpy.ops.mcsl.pull_overrides() == {"FINISHED"}
    bpy.ops.wm.save_mainfile()


task, *words = sys.argv[sys.argv.index("--") + 1 :]
{"build": build, "override": override}[task](*words)
print(f"{Path(__file__).name}: {task} done, Blender {bpy.app.version_string}", flush=True)
