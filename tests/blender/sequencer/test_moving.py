"""Camera strips over a movement that is followed, in a real Blender: what their transforms come to, frame by frame."""

from __future__ import annotations

import math

import numpy as np
import pytest
from blender_recording import FRAMES, SIZE, SWITCH_ON, R, an_edl, in_blender
from notes import Notes

from blender_addon.core.camera_places import planned_transform
from blender_addon.core.similarity import Transform, matrix_of
from mcsl_core import edl as edls
from mcsl_core.blender.child import run_task
from mcsl_core.blender.messages import RefreshRequest
from mcsl_core.blender.timeline import build_timeline, pull_overrides
from mcsl_core.edl import IDENTITY, Movement, MovementView, Pose
from mcsl_core.edl.following import placed_pose

STANDS = """
        def camera(name, frame):
            return next(s for s in strips if s.get("mcsl_camera") == name and span(s)[0] <= frame < span(s)[1])
        def stands(name, frame):
            scene.frame_set(frame + 1)
            t = camera(name, frame).transform
            return [t.offset_x, t.offset_y, t.scale_x, t.scale_y, t.rotation]
"""


def at(frame):
    """cam2 turns from 150 to 210 degrees between frames 24 and 36, cam3 shrinks and moves; cam1 stands."""
    way = min(max((frame - 24) / 12, 0), 1)
    angle, scale = math.radians(150 + 60 * way), 1 - 0.2 * way
    c, s = math.cos(angle), math.sin(angle)
    middle = np.array([[1, 0, (SIZE[0] - 1) / 2], [0, 1, (SIZE[1] - 1) / 2], [0, 0, 1.0]])
    turned = (middle @ [[c, -s, 5 * way], [s, c, 0], [0, 0, 1]] @ np.linalg.inv(middle)).tolist()
    moved = ((scale, 0.0, 20 * way), (0.0, scale, 9 * way), (0.0, 0.0, 1.0))
    return {"cam1": IDENTITY, "cam2": tuple(map(tuple, turned)), "cam3": moved}


def moving(**fields):
    views = tuple(MovementView(f, at(f)) for f in range(24, 37, 2))
    poses = (Pose(R(0, 30), at(0)), Pose(R(30, FRAMES), at(60)))
    return an_edl(**{"movements": (Movement(R(26, 34), 1.0, views),), "poses": poses, **fields})


def apart(numbers, expected):
    """Of the pictures' corners, in pixels."""
    x, y, scale, scale_y, rotation = numbers
    corners = np.array([(u, v, 1) for u in (0, SIZE[0] - 1) for v in (0, SIZE[1] - 1)]).T
    found, there = (
        np.array(matrix_of(t, SIZE, SIZE)) @ corners for t in (Transform(x, y, scale, rotation, scale_y), expected)
    )
    return float(np.hypot(*(found - there)[:2]).max())


@pytest.fixture
def followed(project, blender):
    edls.save(moving(), project / "edl.json")
    build_timeline(project / "edl.json", project / "edit.blend", blender=blender)
    return project / "edit.blend"


def listed(blend, blender):
    code = """
        out = [[s["mcsl_camera"], *span(s), "mcsl_follows" in s, "mcsl_planned" in s]
               for s in sorted(strips, key=span) if s.get("mcsl") == "camera"]
    """
    return [s[1:] for s in in_blender(blender, blend, code, save=False) if s[0] == "cam3"]


@pytest.mark.both_blenders
def test_transforms_come_to_the_similarity_of_what_is_placed(followed, blender):
    edl = moving()
    frames = [5, 23, 24, 25, 27, 29, 30, 33, 36, 37, 59]
    code = STANDS + f'        out = [[stands(name, f) for f in {frames}] for name in ("cam1", "cam2", "cam3")]'
    for name, found in zip(("cam1", "cam2", "cam3"), in_blender(blender, followed, code, save=False), strict=True):
        for frame, numbers in zip(frames, found, strict=True):
            expected = planned_transform(edl, edl.camera(name), placed_pose(edl, frame))
            # linear between views 2 frames and 10 degrees apart: the chord lies 0.4 % of a corner's way inside the arc
            assert apart(numbers, expected) < (0.01 if frame % 2 == 0 or name == "cam1" else 0.9), (name, frame)


@pytest.mark.both_blenders
def test_an_untouched_timeline_is_pulled_as_it_was_and_a_nudge_is_of_its_pose(followed, blender):
    path = followed.parent / "edl.json"
    before = path.read_bytes()
    assert listed(followed, blender) == [[0, 24, False, True], [24, 37, True, False], [37, FRAMES, False, True]]
    pull_overrides(followed, blender=blender)
    assert path.read_bytes() == before
    in_blender(blender, followed, STANDS + '        camera("cam3", 40).transform.offset_x += 9')
    [correction] = pull_overrides(followed, blender=blender).corrections
    assert (correction.range, correction.camera) == (R(30, FRAMES), "cam3")
    np.testing.assert_allclose(correction.matrix, [[1, 0, 9], [0, 1, 0], [0, 0, 1]], atol=1e-4)
    # the strip over the movement goes along, from where the pose begins
    run_task(blender, RefreshRequest(edl=path, blend=followed, conformed=(), sound=None), Notes())
    code = STANDS + '        out = [stands("cam3", f)[0] for f in (28, 29, 30, 34, 40)]'
    plain = moving()
    planned = [planned_transform(plain, plain.camera("cam3"), placed_pose(plain, f)) for f in (28, 29, 30, 34, 40)]
    moved = np.array(in_blender(blender, followed, code, save=False)) - [t.offset_x for t in planned]
    assert moved == pytest.approx([0, 0, 9, 9, 9], abs=0.01)


def test_a_strip_over_a_movement_that_is_moved_says_so_decides_nothing_and_is_put_back(followed, blender):
    path, heard = followed.parent / "edl.json", Notes()
    before = path.read_bytes()
    in_blender(blender, followed, STANDS + '        camera("cam3", 30).transform.offset_x = 70')
    pull_overrides(followed, blender=blender, progress=heard)  # not keyed: gone with the next frame
    assert not any("movement" in note for note in heard.notes)
    code = """
        scene.frame_set(31)
        camera("cam3", 30).transform.offset_x = 70
        camera("cam3", 30).transform.keyframe_insert("offset_x", frame=31)
    """
    in_blender(blender, followed, STANDS + code)
    pull_overrides(followed, blender=blender, progress=heard)
    assert path.read_bytes() == before
    assert [note for note in heard.notes if "over a movement of the lamp, were changed by hand" in note]
    run_task(blender, RefreshRequest(edl=path, blend=followed, conformed=(), sound=None), Notes())
    heard = Notes()
    pull_overrides(followed, blender=blender, progress=heard)
    assert heard.notes == []
    out = in_blender(blender, followed, STANDS + '        out = stands("cam3", 30)', save=False)
    edl = moving()
    assert apart(out, planned_transform(edl, edl.camera("cam3"), placed_pose(edl, 30))) < 0.01


def test_the_same_timeline_with_and_without_views(followed, blender):
    """Renewed for an EDL that holds its camera, and back; a strip that bears work stays, and follows or stands."""
    path = followed.parent / "edl.json"
    grade = (
        STANDS
        + """
        for s in (camera("cam3", 30), camera("cam2", 10)): s.modifiers.new("grade", "BRIGHT_CONTRAST")
    """
    )
    in_blender(blender, followed, grade)
    held = moving(movements=(Movement(R(26, 34)),))
    code = (
        STANDS
        + """
        curves = [c for l in scene.animation_data.action.layers for p in l.strips for b in p.channelbags
                  for c in b.fcurves if "rotation" in c.data_path]
        out = [len(curves), stands("cam3", 29), stands("cam3", 33), len(camera("cam3", 30).modifiers)]
    """
    )
    for edl in (held, moving(), held, moving()):
        edls.save(edl, path)
        run_task(blender, RefreshRequest(edl=path, blend=followed, conformed=(), sound=None), Notes())
        before = path.read_bytes()
        pull_overrides(followed, blender=blender)
        assert path.read_bytes() == before
        curves, *found, modifiers = in_blender(blender, followed, code, save=False)
        follows = edl is not held
        assert bool(curves) == follows
        assert modifiers == 1
        for frame, numbers in zip((29, 33), found, strict=True):
            expected = planned_transform(edl, edl.camera("cam3"), placed_pose(edl, frame))
            assert apart(numbers, expected) < 0.3, (follows, frame)


def test_the_preview_goes_along_with_a_nudge_as_soon_as_it_is_seen(followed, blender):
    code = (
        STANDS
        + """
        from blender_addon.ui import refresh
        camera("cam3", 40).transform.offset_x += 9
        assert refresh.refresh_timeline(scene) == ""
        out = [stands("cam3", f)[0] for f in (29, 30, 34, 40)]
    """
    )
    on = "".join("    " * 2 + line.strip() + "\n" for line in SWITCH_ON.strip().splitlines())
    found = in_blender(blender, followed, on + code, save=False)
    edl = moving()
    planned = [planned_transform(edl, edl.camera("cam3"), placed_pose(edl, f)).offset_x for f in (29, 30, 34, 40)]
    assert np.array(found) - planned == pytest.approx([0, 9, 9, 9], abs=0.01)
