"""The add-on's skin in a real Blender: switched on and off twice, built and pulled by its operators."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from blender_recording import SWITCH_ON, R, in_blender

import blender_addon
from mcsl_core import edl as edls
from mcsl_core.blender.child import search_paths
from mcsl_core.edl import Override

pytestmark = pytest.mark.both_blenders


def test_it_registers_and_unregisters_twice(built, blender):
    code = (
        SWITCH_ON
        + """
    out = []
    for _ in range(2):
        out.append([hasattr(bpy.types, "MCSL_PT_shots"), "build_timeline" in dir(bpy.ops.mcsl)])
        blender_addon.unregister()
        out.append([hasattr(bpy.types, "MCSL_PT_shots"), "build_timeline" in dir(bpy.ops.mcsl)])
        blender_addon.register()
    """
    )
    assert in_blender(blender, built, code, save=False) == [[True, True], [False, False]] * 2


def test_pull_by_the_button(built, blender):
    code = (
        SWITCH_ON
        + """
    at(5, 0).multicam_source = 2
    bpy.ops.mcsl.pull_overrides()
    out = scene["mcsl_overrides"]
    """
    )
    assert in_blender(blender, built, code) == 2
    assert edls.load(built.parent / "edl.json").overrides[-1] == Override(R(0, 20), camera="cam2")


def test_build_by_the_button_gives_the_same_strips(built, blender):
    code = (
        SWITCH_ON
        + f"""
    def listing(s):
        return sorted([x.channel, *span(x), x.type] for x in s.sequence_editor.strips)
    before = listing(scene)
    new = bpy.data.scenes.new("again")
    bpy.context.window.scene = new
    for w in bpy.data.workspaces:
        if hasattr(w, "sequencer_scene"): w.sequencer_scene = new
    bpy.ops.mcsl.build_timeline(filepath={str(built.parent / "edl.json")!r})
    out = [before == listing(new), new["mcsl_edl"], new["mcsl_overrides"]]
    """
    )
    assert in_blender(blender, built, code, save=False) == [True, "//edl.json", 1]


@pytest.mark.parametrize(
    ("fault", "message"), [("broken", "is not JSON"), ("media", "is missing"), ("full", "not empty")]
)
def test_a_fault_is_one_line_and_leaves_the_timeline_as_it_was(built, blender, fault, message):
    edl = built.parent / "edl.json"
    if fault == "broken":
        edl.write_text(edl.read_text()[:200])
    if fault == "media":
        (built.parent / "cam3.mp4").unlink()
    code = (
        SWITCH_ON
        + f"""
    if {fault != "full"}:
        scene = bpy.data.scenes.new("again")
        bpy.context.window.scene = scene
        for w in bpy.data.workspaces:
            if hasattr(w, "sequencer_scene"): w.sequencer_scene = scene
    before = len(scene.sequence_editor.strips) if scene.sequence_editor else 0
    try:
        bpy.ops.mcsl.build_timeline(filepath={str(edl)!r})
        out = "no error"
    except RuntimeError as error:
        after = len(scene.sequence_editor.strips) if scene.sequence_editor else 0
        out = [str(error).strip(), before == after]
    """
    )
    said, same = in_blender(blender, built, code, save=False)
    assert message in said
    assert len(said.splitlines()) == 1
    assert same


def test_the_manifest_passes_blenders_own_tool(blender):
    if blender.kind != "module":
        command = [*blender.command, "-b", "--command", "extension", "validate"]
    else:
        code = "import importlib.util as u; print(u.find_spec('bpy').origin)"
        origin = subprocess.run([*blender.command, "-c", code], capture_output=True, text=True, check=True).stdout
        tool = next(Path(origin.strip()).parent.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py"))
        command = [*blender.command, str(tool), "validate"]
    folder = str(Path(blender_addon.__file__).parent)
    done = subprocess.run([*command, folder], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_plan_side_imports_no_bpy():
    code = "import sys; sys.modules['bpy'] = None; import blender_addon.plan, blender_addon.readback; print('fine')"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=search_paths()[0])
    assert json.dumps(done.stdout.strip()) == '"fine"', done.stderr
