"""Cuts by key at random places: they touch only what they change, and leave what a timeline built anew has."""

from __future__ import annotations

import attrs
import pytest
from blender_recording import SWITCH_ON, R, an_edl, in_blender, write_camera

from mcsl_core import edl as edls
from mcsl_core.blender.timeline import build_timeline, pull_overrides
from mcsl_core.edl.schema import Weak

pytestmark = pytest.mark.both_blenders

SEEN = """
    import random
    from pathlib import Path
    from blender_addon.sequencer import conformed
    from blender_addon.sequencer.scene_properties import edl_of
    from blender_addon.ui import refresh
    from mcsl_core.blender.messages import ConformedPiece
    from mcsl_core.timing import FrameRange
    def keys():
        bag = scene.animation_data.action.layers[0].strips[0].channelbags[0]
        return {c.data_path: [(*p.co, p.interpolation) for p in c.keyframe_points] for c in bag.fcurves}
    def seen():
        window = bpy.context.window_manager.mcsl_state
        rows = [(r.start, r.stop, r.camera, r.automatic, r.overridden, r.time) for r in window.shots]
        found = sorted([*span(s), s.channel, s.name, s.color_tag, s.mute, s.type] for s in strips)
        return [found, keys(), rows, window.overrides, window.outstanding_s, window.lost_s]
"""
STANDS = """
    def merged(found):
        parts = []
        for start, stop, value in sorted(found):
            if parts and parts[-1][1:] == [start, value]: parts[-1][1] = stop
            else: parts.append([start, stop, value])
        return parts
    bag = scene.animation_data.action.layers[0].strips[0].channelbags[0]
    keys = {c.data_path: [(*p.co, p.interpolation) for p in c.keyframe_points] for c in bag.fcurves}
    shots = [s for s in strips if s.type == "MULTICAM"]
    out = {
        "shown": merged([*span(s), s.multicam_source] for s in shots),
        "yellow": [span(s) for s in shots if s.color_tag == "COLOR_03"],
        "plain": [span(s) for s in shots if s.color_tag != "COLOR_03"],
        "keys": keys,
        "markers": sorted((m.frame, m.name) for m in scene.timeline_markers),
        "cameras": sorted([*span(s), s.channel, list(s.transform.offset_x for _ in "1")]
                          for s in strips if s.type == "MOVIE" and s.get("mcsl") == "camera"),
    }
"""


@pytest.fixture
def centred(project, blender):
    """A camera that lies nowhere in the second pose, and centering: a cut to it changes the keys of that strip."""
    edl = an_edl(centering=tuple((n, float(n % 7), -float(n % 5)) for n in range(0, 60, 4)), overrides=())
    weak = attrs.evolve(
        edl.poses[1],
        homographies={n: m for n, m in edl.poses[1].homographies.items() if n != "cam3"},
        weak=(Weak("cam3", "too dark"),),
    )
    edls.save(attrs.evolve(edl, poses=(edl.poses[0], weak)), project / "edl.json")
    write_camera(project / "0000000-exact.mp4", "cam1", 30)
    build_timeline(project / "edl.json", project / "edit.blend", blender=blender)
    return project


@pytest.mark.parametrize("chance", range(3))
def test_what_a_cut_leaves_is_what_a_whole_refresh_and_a_new_timeline_have(centred, blender, chance):
    code = f"""
    chance, wrong, cuts = random.Random({chance}), [], 0
    pieces = [ConformedPiece(range=FrameRange(0, 30), path="0000000-exact.mp4")]
    for _ in conformed.insert(scene, edl_of(scene), pieces, None, Path(bpy.data.filepath).parent): pass
    refresh.refresh_timeline(scene)
    muted = 0
    for _ in range(14):
        scene.frame_set(chance.randint(1, 60))
        whole, number = chance.random() < 0.3, chance.randint(1, 3)
        cuts += bpy.ops.mcsl.switch_camera("EXEC_DEFAULT", True, number=number, whole=whole) == {{"FINISHED"}}
        assert refresh._is_as_it_was(scene), "what was kept is not what stands there"
        left = seen()
        refresh._last.clear()
        refresh.refresh_timeline(scene)
        if seen() != left: wrong.append([left, seen()])
        muted += any(s[5] for s in left[0])
    out = [cuts, muted, wrong]
    """
    cuts, muted, wrong = in_blender(blender, centred / "edit.blend", SWITCH_ON + SEEN + code)
    assert cuts > 5
    assert muted > 0  # exact pictures fell away at once
    assert wrong == []
    cut = in_blender(blender, centred / "edit.blend", STANDS, save=False)
    pull_overrides(centred / "edit.blend", blender=blender)
    build_timeline(centred / "edl.json", centred / "anew.blend", blender=blender)
    anew = in_blender(blender, centred / "anew.blend", STANDS, save=False)
    for part in ("shown", "keys", "markers", "cameras"):
        assert cut[part] == anew[part], part
    by_hand = {frame for a, b in anew["yellow"] for frame in R(a, b)}
    assert all(by_hand & set(R(a, b)) for a, b in cut["yellow"])
    assert not any(by_hand & set(R(a, b)) for a, b in cut["plain"])
