"""A camera strip moved by hand in a real Blender: the correction, the exact picture it makes, and the way back."""

from __future__ import annotations

import textwrap

import attrs
import numpy as np
import pytest
from blender_recording import FRAMES, SWITCH_ON, R, an_edl, in_blender
from spots import SPOTS, middles, projected, spots

from mcsl_core import edl as edls
from mcsl_core.blender import render as rendering
from mcsl_core.blender.child import run_task
from mcsl_core.blender.messages import RenderRequest
from mcsl_core.blender.timeline import build_timeline, pull_overrides
from mcsl_core.delivery.presets import load_preset
from mcsl_core.edl import IDENTITY, Camera, Media, Override, Pose, Shot

ON = textwrap.indent(textwrap.dedent(SWITCH_ON), " " * 8)
CAMERAS = """
        def camera(name, start): return next(s for s in strips if s.get("mcsl_camera") == name and span(s)[0] == start)
        def stands(s):
            t = s.transform
            return [t.offset_x, t.offset_y, t.scale_x, t.scale_y, t.rotation]
"""


def test_a_correction_goes_into_the_edl_shows_again_and_can_be_taken_back(built, blender):
    path = built.parent / "edl.json"
    before = path.read_bytes()
    by_hand = """
        t = camera("cam3", 30).transform
        t.offset_x, t.offset_y, t.rotation, t.scale_x, t.scale_y = 12.5, -7.0, 0.05, 1.1, 1.05
        out = stands(camera("cam3", 30))
    """
    set_to = in_blender(blender, built, CAMERAS + by_hand)
    pull_overrides(built, blender=blender)
    new = edls.load(path)
    [correction] = new.corrections
    assert (correction.range, correction.camera) == (R(30, FRAMES), "cam3")
    assert attrs.evolve(new, corrections=()) == edls.loads(before.decode())
    once = path.read_bytes()
    assert pull_overrides(built, blender=blender) == new
    assert path.read_bytes() == once
    build_timeline(path, built, blender=blender, force=True)  # a timeline made from it shows it
    shown = in_blender(blender, built, CAMERAS + '        out = [stands(camera("cam3", n)) for n in (0, 30)]')
    assert shown[0] == pytest.approx([0, 0, 1, 1, 0], abs=1e-6)
    assert shown[1] == pytest.approx(set_to, abs=1e-5)
    assert pull_overrides(built, blender=blender) == new
    assert path.read_bytes() == once
    back = """
        for s in strips: s.select = s == camera("cam3", 30)
        bpy.ops.mcsl.reset_alignment()
    """
    in_blender(blender, built, ON + CAMERAS + back)
    assert pull_overrides(built, blender=blender).corrections == ()
    assert path.read_bytes() == before


def test_only_camera_strips_that_know_their_place_are_set_back_and_it_can_be_undone(built, blender):
    code = """
        def polls(strip):
            for s in strips: s.select = s == strip
            return bpy.ops.mcsl.reset_alignment.poll()
        old = camera("cam2", 3)
        del old["mcsl_planned"]
        out = [polls(at(5, 0)), polls(old), polls(camera("cam3", 30))]
        camera("cam3", 30).transform.offset_x = 9.0
        bpy.ops.ed.undo_push(message="corrected")
        bpy.ops.mcsl.reset_alignment("EXEC_DEFAULT", True)
        out.append(stands(camera("cam3", 30))[0])
        bpy.ops.ed.undo()
        strips = next(s for s in bpy.data.scenes if s.get("mcsl_edl")).sequence_editor.strips
        out.append(next(s for s in strips if s.get("mcsl_camera") == "cam3" and span(s)[0] == 30).transform.offset_x)
    """
    assert in_blender(blender, built, ON + CAMERAS + code, save=False) == [False, False, True, 0, 9]


def test_a_split_camera_strip_and_a_camera_on_another_channel(built, blender):
    code = """
        right = camera("cam3", 30).split(frame=45 + 1, split_method="SOFT")
        right.transform.offset_x = 5.0
        right.channel = 11
    """
    in_blender(blender, built, CAMERAS + code)
    [correction] = pull_overrides(built, blender=blender).corrections
    assert (correction.range, correction.camera, round(correction.matrix[0][2], 4)) == (R(30, FRAMES), "cam3", 5.0)


def first_luma(path):
    import av

    with av.open(str(path)) as container:
        return next(container.decode(video=0)).to_ndarray(format="gray")


def matched(found, points):
    """Of what was found the nearest to each point."""
    return np.array([found[np.hypot(*(found - p).T).argmin()] for p in points])


def test_the_exact_picture_moves_as_the_editor_saw_the_preview_move(tmp_path, blender):
    """Spots in the preview before and after a correction, and in the exact picture: they must all move alike.

    The homography has perspective, so that preview and exact picture differ; a map of programme pixels moves both by
    the same map, and so apart by (scale and turn of the correction - 1) times that difference.
    """
    homography = ((0.9, 0.12, -4.0), (-0.08, 1.02, 12.0), (2e-4, -1.5e-4, 1.0))
    spots(tmp_path / "a.mp4", (320, 180), SPOTS)
    spots(tmp_path / "ref.mp4", (320, 180), SPOTS)
    edl = an_edl(
        frames=4,
        cameras=tuple(
            Camera(name, (Media(file, 4),), (320, 180), an_edl().rate)
            for name, file in (("cam1", "ref.mp4"), ("cam2", "a.mp4"))
        ),
        movements=(),
        poses=(Pose(R(0, 4), {"cam1": IDENTITY, "cam2": homography}),),
        shots=(Shot(R(0, 4), "cam2"),),
        overrides=(Override(R(0, 4), fill=False),),
    )
    path, blend = tmp_path / "edl.json", tmp_path / "edit.blend"
    edls.save(edl, path)
    build_timeline(path, blend, blender=blender)
    preset = load_preset("archive")

    def preview(name):
        out = tmp_path / name
        run_task(blender, RenderRequest(blend=blend, preset=preset, output=out))
        return middles(first_luma(out))

    def exact(name):
        rendering.render(path, tmp_path / name, preset="archive", engine="direct")
        return middles(first_luma(tmp_path / name))

    seen_before, exact_before = preview("before.mkv"), exact("exact_before.mkv")
    code = """
        t = camera("cam2", 0).transform
        t.offset_x, t.offset_y = t.offset_x + 11, t.offset_y + 6
        t.rotation, t.scale_x, t.scale_y = t.rotation + 0.1, t.scale_x * 1.06, t.scale_y * 1.06
    """
    in_blender(blender, blend, CAMERAS + code)
    [correction] = pull_overrides(blend, blender=blender).corrections
    seen_after, exact_after = preview("after.mkv"), exact("exact_after.mkv")

    sure = [p for p in projected(homography, SPOTS) if 20 < p[0] < 290 and 20 < p[1] < 150]
    assert len(sure) >= 4
    before, exact_0 = matched(seen_before, sure), matched(exact_before, sure)
    after = matched(seen_after, projected(correction.matrix, before))
    exact_1 = matched(exact_after, projected(correction.matrix, exact_0))
    off = np.hypot(*((after - before) - (exact_1 - exact_0)).T)
    turn = abs(complex(correction.matrix[0][0], correction.matrix[1][0]) - 1)
    apart = np.hypot(*(before - exact_0).T)
    print(f"preview and exact picture lie {apart.max():.1f} px apart, and moved by {off.max():.2f} px differently")
    assert np.hypot(*(after - before).T).max() > 15
    assert (
        np.hypot(*(exact_1 - projected(correction.matrix, exact_0)).T).max() < 0.3
    )  # finding a disc takes a tenth or so
    assert (off <= turn * apart + 0.3).all()
    assert off.max() < 2
