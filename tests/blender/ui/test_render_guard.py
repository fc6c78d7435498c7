"""The panel's own render: its video bears its name once it is whole; stopped, what was there before stays."""

from __future__ import annotations

import av
import pytest
from blender_recording import FRAMES, SWITCH_ON, in_blender, number_of

SET_UP = (
    SWITCH_ON
    + """
    from blender_addon.ui import refresh, render_guard
    from pathlib import Path
    scene.mcsl_work.preset = "review"
    scene.frame_end = 6
    scene.mcsl_work.video = bpy.path.abspath("//film.mp4")
    folder = Path(bpy.path.abspath("//"))
    old = b"the film of yesterday"
    (folder / "film.mp4").write_bytes(old)
    def films(): return sorted(p.name for p in folder.iterdir() if "film" in p.name)
    seen = []
"""
)


@pytest.mark.both_blenders
def test_while_it_renders_the_old_video_is_there(built, blender):
    code = (
        SET_UP
        + """
    bpy.app.handlers.render_write.append(lambda *_: seen.append((folder / "film.mp4").read_bytes() == old))
    out = [str(bpy.ops.mcsl.render()), all(seen), len(seen), films(), (folder / "film.mp4").read_bytes() == old,
           scene.render.filepath.endswith("film.mp4")]
    """
    )
    assert in_blender(blender, built, code, save=False) == ["{'FINISHED'}", True, 6, ["film.mp4"], False, True]


@pytest.mark.parametrize("how", ["cancel", "too few"])
def test_stopped_it_leaves_the_old_video_and_no_part(built, blender, how):
    """Blender without a window cannot be stopped in the middle: its own handlers are called as it does then."""
    code = (
        SET_UP
        + f"""
    render_guard.begin(scene, refresh.decided(scene), folder / "film.mp4")
    scene.frame_end = 2
    bpy.ops.mcsl.apply_preset()
    scene.render.filepath = str(folder / ".film.part.mp4")
    if {how!r} == "cancel":
        bpy.app.handlers.render_complete.remove(render_guard._complete)
    bpy.ops.render.render(animation=True, scene=scene.name)
    seen = films()
    if {how!r} == "cancel":
        render_guard._cancelled(scene)
    out = [seen if {how!r} == "cancel" else [], films(), (folder / "film.mp4").read_bytes() == old]
    out.append(scene.render.filepath.endswith("/film.mp4"))
    """
    )
    part = [".film.part.mp4", "film.mp4"] if how == "cancel" else []
    assert in_blender(blender, built, code, save=False) == [part, ["film.mp4"], True, True]


def test_out_of_time_nothing_is_rendered(built, blender):
    code = (
        SET_UP
        + """
    scene.render.fps = 50
    try:
        result = str(bpy.ops.mcsl.render())
    except RuntimeError as error:
        result = str(error)
    out = [result, films(), (folder / "film.mp4").read_bytes() == old]
    """
    )
    said, films, old = in_blender(blender, built, code, save=False)
    assert "runs at" in said
    assert (films, old) == (["film.mp4"], True)


def test_what_is_removed_is_left_out_and_nothing_of_that_stays(built, blender):
    """By the marks as they stand, pulled or not; pictures and sound are held in test_render.py."""
    code = (
        SET_UP
        + """
    scene.frame_end = FRAMES
    scene.mcsl_work.preset = "h264"
    scene.use_preview_range = True
    for scene.frame_preview_start, scene.frame_preview_end in ((8, 22), (51, FRAMES)):
        bpy.ops.mcsl.remove()
    scene.use_preview_range = False
    told = [str(bpy.ops.mcsl.render()), films(), len(bpy.data.scenes), scene.render.filepath.endswith("film.mp4")]
    import tempfile
    out = [*told, [p.name for p in Path(tempfile.gettempdir()).glob("mcsl-render-*")]]
    """
    ).replace("FRAMES", str(FRAMES))
    assert in_blender(blender, built, code) == ["{'FINISHED'}", ["film.mp4"], 1, True, []]
    with av.open(str(built.parent / "film.mp4")) as film:
        numbers = [number_of(frame.to_ndarray(format="gray8")) for frame in film.decode(video=0)]
    assert numbers == [n for n in range(50) if not 7 <= n < 22]
