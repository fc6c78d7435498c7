"""Custom properties that another mcsl, or somebody's script, left in a .blend: a clear message, never a traceback."""

from __future__ import annotations

import textwrap

import pytest
from blender_recording import SWITCH_ON, in_blender

pytestmark = [pytest.mark.both_blenders, pytest.mark.slow]

TRY = (
    textwrap.dedent(SWITCH_ON)
    + """
from pathlib import Path
from blender_addon.core.strip_plan import make_plan
from blender_addon.sequencer import conformed, renew, scene_properties
from blender_addon.ui import job_runner, refresh
from mcsl_core.errors import McslError
odd = ["", "text", "{", "[[1]]", '[["a", 1]]', "0 ", "-1 x", 3, -(2 ** 31), 1e308, float("nan"), [1.0],
       [1, 2, 3, 4, 5, 6], [float("nan")] * 5, [float("nan")] * 2, [0.0] * 5, [1e300] * 5, [1e300] * 2, [], {"a": 1}]
of_scene = ["mcsl", "mcsl_edl", "mcsl_home", "mcsl_recording", "mcsl_overrides", "mcsl_cameras", "mcsl_tracks",
            "mcsl_keys", "mcsl_centered", "mcsl_conformed_for", "mcsl_sound", "mcsl_automatic", "mcsl_look_fill",
            "mcsl_look_centering", "mcsl_look_colour", "mcsl_drawn_fields", "mcsl_drawn_upon"]
of_strip = {
    "camera": ["mcsl", "mcsl_camera", "mcsl_planned", "mcsl_placed"],
    "programme": ["mcsl", "mcsl_id", "mcsl_name", "mcsl_centering", "mcsl_fill", "mcsl_offset", "mcsl_automatic"],
    "sound": ["mcsl", "mcsl_placed"],
    "centering": ["mcsl"],
}
base = Path(bpy.path.abspath("//"))
plan = make_plan(scene_properties.edl_of(scene))
faults, said, tried = [], set(), 0
def use():
    refresh._last.clear()
    problem = refresh.refresh_timeline(scene)
    said.add(problem.split(" has the custom")[0][:60])
    for work in (lambda: refresh.last(scene), lambda: scene_properties.camera_names(scene),
                 lambda: scene_properties.has_timeline(scene), lambda: scene_properties.timeline_scene(base),
                 lambda: refresh.show_recording(scene)):
        try:
            work()
        except McslError as error:
            said.add(error.what[:40])
    for name in ("pull_overrides", "revert") if tried % 4 == 0 else ():
        try:
            if hasattr(bpy.ops.mcsl, name):
                getattr(bpy.ops.mcsl, name)()
        except RuntimeError as error:  # what an operator reports as an error; a traceback says so
            if "Traceback" in str(error):
                raise
def attempt(owner, name, value):
    global tried
    had = name in owner
    old = owner.get(name)
    old = old.to_list() if hasattr(old, "to_list") else old
    try:
        owner[name] = value
    except (TypeError, OverflowError):
        return
    tried += 1
    try:
        use()
    except Exception as error:
        faults.append([name, repr(value)[:40], traceback.format_exc()[-600:]])
    if had: owner[name] = old
    elif name in owner: del owner[name]
for name in of_scene:
    for value in odd:
        attempt(scene, name, value)
for role, names in of_strip.items():
    strip = next(s for s in strips if s.get("mcsl") == role)
    for name in names:
        for value in odd:
            attempt(strip, name, value)
out = [faults[:5], len(faults), tried, sorted(said)]
"""
)


def test_no_property_brings_a_traceback(built, blender):
    faults, count, tried, said = in_blender(blender, built, TRY, save=False)
    assert count == 0, "\n".join(f"{name} = {value}: {text}" for name, value, text in faults)
    assert tried > 400
    assert "" in said
    assert any("custom property" in text for text in said)
