"""Proxies by one click: of every camera file, frame for frame, for the preview alone, and kept by a rebuild."""

from __future__ import annotations

import json

import av
import pytest
from blender_recording import SWITCH_ON, ground_of, in_blender, number_of

pytestmark = pytest.mark.both_blenders

BUILT = """
    def cameras():
        films = [s for s in strips if s.type == "MOVIE" and s.get("mcsl") == "camera"]
        return sorted([s["mcsl_camera"], *span(s), s.use_proxy, s.proxy.directory if s.proxy else ""] for s in films)
    def picture(frame, path):
        scene.frame_set(frame)
        settings = scene.render.image_settings
        if hasattr(settings, "media_type"): settings.media_type = "IMAGE"
        scene.render.filepath, settings.file_format = path, "PNG"
        bpy.ops.render.render(write_still=True)
"""


def test_each_file_has_one_frame_for_frame(built, blender):
    code = """
    strips[2].select = True
    picked = [s.name for s in strips if s.select]
    out = [bpy.ops.mcsl.build_proxies() == {"FINISHED"}, cameras(), picked == [s.name for s in strips if s.select]]
    """
    done, cameras, same = in_blender(blender, built, SWITCH_ON + BUILT + code)
    assert done
    assert same  # what was selected still is, and nothing else
    assert all(uses for *_, uses, _ in cameras)
    folders = {folder: name for name, _, _, _, folder in cameras}
    assert sorted(folders.values()) == ["cam1", "cam1", "cam2", "cam3"]  # cam1 has two files
    firsts = {"cam1_a.mp4": 0, "cam1_b.mp4": 40, "cam2.mp4": 3, "cam3.mp4": 0}
    seen = []
    for folder, name in folders.items():
        [path] = (built.parent / folder.removeprefix("//")).rglob("proxy_50*")
        with av.open(str(path)) as film:
            planes = [frame.to_ndarray(format="gray") for frame in film.decode(video=0)]
        numbers = [number_of(plane) for plane in planes]
        assert {ground_of(plane) for plane in planes} == {name}
        assert planes[0].shape == (90, 160)
        seen.append(numbers)
    assert sorted(seen) == sorted([list(range(firsts[f], firsts[f] + n)) for f, n in _LENGTHS.items()])


_LENGTHS = {"cam1_a.mp4": 40, "cam1_b.mp4": 20, "cam2.mp4": 57, "cam3.mp4": 60}


def test_they_change_no_render_and_are_nobodys_work(built, blender):
    code = """
    from blender_addon.sequencer.touched import Work
    folder = os.path.dirname(bpy.data.filepath)
    picture(13, f"{folder}/before.png")
    bpy.ops.mcsl.build_proxies()
    picture(13, f"{folder}/after.png")
    work = Work(scene)
    out = [what for s in strips if s.get("mcsl") == "camera" for what in work.on(s)]
    """
    assert in_blender(blender, built, SWITCH_ON + BUILT + code) == []
    pictures = []
    for name in ("before.png", "after.png"):
        with av.open(str(built.parent / name)) as film:
            pictures.append(next(film.decode(video=0)).to_ndarray(format="rgb24"))
    assert (pictures[0] == pictures[1]).all()


def test_camera_strips_made_anew_take_them(built, blender):
    document = json.loads((built.parent / "edl.json").read_text("utf-8"))
    before, after = document["poses"]
    before["range"][1] = after["range"][0] = 24
    code = """
    from pathlib import Path
    from blender_addon.ui.operators.timeline import build_into
    bpy.ops.mcsl.build_proxies()
    first = cameras()
    Path(bpy.path.abspath(scene["mcsl_edl"])).write_text(open(bpy.path.abspath("//new.json")).read())
    build_into(scene, Path(bpy.path.abspath(scene["mcsl_edl"])))
    out = [first, cameras()]
    """
    (built.parent / "new.json").write_text(json.dumps(document), "utf-8")
    first, again = in_blender(blender, built, SWITCH_ON + BUILT + code)
    assert [row[1:3] for row in first] != [row[1:3] for row in again]
    assert {row[-1] for row in first} == {row[-1] for row in again}
    assert all(row[3] for row in again)
