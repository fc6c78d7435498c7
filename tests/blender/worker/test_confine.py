"""A .blend from elsewhere runs nothing and writes nothing but its output."""

from __future__ import annotations

from pathlib import Path

import pytest
from blender_recording import in_blender
from notes import Notes

from mcsl_core.blender.child import run_task
from mcsl_core.blender.messages import ReadRequest, RenderRequest
from mcsl_core.delivery.presets import load_preset

pytestmark = pytest.mark.both_blenders

FOREIGN = """
    away = {away!r}
    def tree_of(scene, name):
        if hasattr(scene, "compositing_node_group"):
            tree = bpy.data.node_groups.new(name, "CompositorNodeTree")
            scene.compositing_node_group = tree
        else:
            scene.use_nodes = True
            tree = scene.node_tree
        tree.nodes.clear()
        layers = tree.nodes.new("CompositorNodeRLayers")
        layers.scene = scene
        node = tree.nodes.new("CompositorNodeOutputFile")
        if hasattr(node, "base_path"):
            node.base_path = away + "/" + name
        else:
            node.directory, node.file_name = away + "/" + name, "frame"
            node.file_output_items.new("RGBA", "Image")
        if "base_path" in dir(node):
            node.format.file_format = "PNG"
        tree.links.new(layers.outputs["Image"], node.inputs[0])
    other = bpy.data.scenes.new("other")
    other.render.engine = "CYCLES"
    other.cycles.samples = 1
    other.render.resolution_x, other.render.resolution_y = 32, 18
    other.render.filepath = away + "/others.png"
    other.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    other.collection.objects.link(other.camera)
    other.render.use_compositing = True
    tree_of(other, "others")
    tree_of(scene, "own")
    new = dict(length=2) if bpy.app.version >= (5, 0) else dict()
    strip = strips.new_scene(name="three d", scene=other, channel=30, frame_start=1)
    cut(strip, 0, 2)
    scene.frame_end = 3
    scene.render.use_compositing = True
    scene.render.use_multiview = True
    scene.render.image_settings.views_format = "INDIVIDUAL"
    scene.render.filepath = away + "/not here.mp4"
    at(2, 10).use_proxy = True
    text = bpy.data.texts.new("startup.py")
    text.write("open(" + repr(away + "/script ran") + ", 'w')")
    text.use_module = True
    driver = scene.driver_add('sequence_editor.strips_all["cam2"].blend_alpha').driver
    driver.type = "SCRIPTED"
    driver.expression = "[f for f in [open(" + repr(away + "/driver ran") + ", 'w')]] and 1"
"""


def test_only_the_output_is_written_and_no_script_runs(built, blender, tmp_path):
    away = tmp_path / "away"
    away.mkdir()
    in_blender(blender, built, FOREIGN.format(away=str(away)))
    for file in away.rglob("*"):
        file.unlink()  # what ran while the file was made
    before = {p: p.stat().st_mtime_ns for p in tmp_path.rglob("*")}
    heard = Notes()
    run_task(blender, ReadRequest(built))
    out = tmp_path / "out.mp4"
    done = run_task(blender, RenderRequest(blend=built, preset=load_preset("review"), output=out), heard)
    assert done.frames == 3
    after = {p: p.stat().st_mtime_ns for p in tmp_path.rglob("*") if p.name != out.name}
    assert {p for p in after if before.get(p) != after[p]} - {Path(tmp_path)} == set()
    assert out.is_file()
    assert sum("File Output node" in note for note in heard.notes) == 2
    assert any("Stereoscopy" in note for note in heard.notes)
