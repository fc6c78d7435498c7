"""A timeline that was copied, moved or saved elsewhere writes into its own project's EDL, or nowhere."""

from __future__ import annotations

import shutil
from pathlib import Path

import attrs
import pytest
from blender_recording import SWITCH_ON, R, an_edl, in_blender

from mcsl_core import edl as edls
from mcsl_core.blender.timeline import build_timeline, pull_overrides
from mcsl_core.edl import Override, Shot
from mcsl_core.errors import InputError

DECIDED = "at(5, 20).multicam_source = 3"
NEW = Override(R(20, 40), camera="cam3")


@pytest.fixture
def decided(built, blender):
    in_blender(blender, built, DECIDED)
    return built


def left_alone(built, work):
    """Runs ``work``; the EDL that the timeline was built from must be the same to the byte."""
    path = built.parent / "edl.json"
    before = path.read_bytes()
    try:
        return work()
    finally:
        assert path.read_bytes() == before


def test_a_copied_project_writes_into_its_own_edl(decided, blender, tmp_path):
    copy = shutil.copytree(decided.parent, tmp_path / "copy")
    for _ in range(2):
        left_alone(decided, lambda: pull_overrides(copy / "edit.blend", blender=blender))
        assert edls.load(copy / "edl.json").overrides[-1] == NEW


@pytest.mark.parametrize("older", [False, True])
def test_a_whole_path_is_not_followed_out_of_a_copy(decided, blender, tmp_path, older):
    """As timelines have it that were built before their file had a name, or on another drive."""
    forget = 'scene.pop("mcsl_home"); scene.pop("mcsl_recording")' if older else ""
    in_blender(blender, decided, f'scene["mcsl_edl"] = bpy.path.abspath("//edl.json")\n{forget}')
    copy = shutil.copytree(decided.parent, tmp_path / "copy")
    left_alone(decided, lambda: pull_overrides(copy / "edit.blend", blender=blender))
    assert edls.load(copy / "edl.json").overrides[-1] == NEW
    assert pull_overrides(decided, blender=blender).overrides[-1] == NEW
    assert edls.load(decided.parent / "edl.json").overrides[-1] == NEW


def test_an_older_timelines_whole_path_still_leads_to_its_edl(decided, blender, tmp_path):
    code = 'scene["mcsl_edl"] = bpy.path.abspath("//edl.json"); scene.pop("mcsl_home"); scene.pop("mcsl_recording")'
    in_blender(blender, decided, code)
    away = tmp_path / "away"
    away.mkdir()
    shutil.move(decided, away / "edit.blend")
    assert pull_overrides(away / "edit.blend", blender=blender).overrides[-1] == NEW
    assert edls.load(decided.parent / "edl.json").overrides[-1] == NEW


OTHERS = {
    "missing": None,
    "another recording": attrs.evolve(
        an_edl(), cameras=(*an_edl().cameras[:2], attrs.evolve(an_edl().cameras[2], media=an_edl().cameras[1].media))
    ),
    "other automatic decisions": attrs.evolve(an_edl(), shots=(Shot(R(0, 60), "cam2"),)),
}


@pytest.mark.parametrize("whole", [False, True])
@pytest.mark.parametrize("other", OTHERS)
def test_saved_into_another_project_it_is_refused(decided, blender, tmp_path, other, whole):
    if whole:
        in_blender(blender, decided, 'scene["mcsl_edl"] = bpy.path.abspath("//edl.json")')
    folder = tmp_path / "other"
    folder.mkdir()
    if (theirs := OTHERS[other]) is not None:
        edls.save(theirs, folder / "edl.json")
    before = (folder / "edl.json").read_bytes() if theirs is not None else b""
    saved = folder / "film.blend"
    in_blender(blender, decided, f"bpy.ops.wm.save_as_mainfile(filepath={str(saved)!r})", save=False)
    match = "not there" if theirs is None else other
    with pytest.raises(InputError, match=f"{match}.*mcsl pull film.blend -o"):
        left_alone(decided, lambda: pull_overrides(saved, blender=blender))
    assert theirs is None or (folder / "edl.json").read_bytes() == before

    # the remedy: a person names the EDL that takes the decisions
    pull_overrides(saved, decided.parent / "edl.json", blender=blender)
    assert edls.load(decided.parent / "edl.json").overrides[-1] == NEW


def test_it_lies_where_it_was_and_the_edl_is_of_another_recording(decided, blender):
    path = decided.parent / "edl.json"
    other = an_edl(
        cameras=tuple(attrs.evolve(c, media=(attrs.evolve(c.media[0], frames=7),)) for c in an_edl().cameras)
    )
    edls.save(other, path)
    with pytest.raises(InputError, match="which is of another recording"):
        left_alone(decided, lambda: pull_overrides(decided, blender=blender))


def test_with_the_extension_the_way_is_noted_at_the_first_save_alone(project, blender, tmp_path):
    """Built before the file has a name; saved; saved as another in its folder; saved as another elsewhere: it finds
    the same EDL from there."""
    empty = project / "empty.blend"
    build_timeline(project / "edl.json", empty, blender=blender)
    away = tmp_path / "away"
    away.mkdir()
    code = f"""
        {SWITCH_ON.replace(chr(10), chr(10) + "    ")}
        bpy.ops.wm.read_homefile(app_template="Video_Editing", use_factory_startup=True)
        import blender_addon.ui.operators.timeline as timeline
        from pathlib import Path
        scene = bpy.context.scene
        timeline.build_into(scene, Path({str(project / "edl.json")!r}))
        out = [scene["mcsl_edl"]]
        for name in {[str(project / "first.blend"), str(project / "second.blend"), str(away / "third.blend")]!r}:
            bpy.ops.wm.save_as_mainfile(filepath=name)
            out.append(scene["mcsl_edl"])
        strip = next(s for s in scene.sequence_editor.strips if s.channel == 5 and s.name.startswith("2:"))
        strip.multicam_source = 3
        bpy.ops.wm.save_as_mainfile(filepath=name)
        try:
            out.append(str(bpy.ops.mcsl.pull_overrides()))
        except RuntimeError as error:
            out.append(str(error))
    """
    found = in_blender(blender, empty, code, save=False)
    assert found[0] == str(project / "edl.json")
    assert found[1:3] == ["//edl.json"] * 2
    assert found[3].startswith("//../")
    assert (away / found[3].removeprefix("//")).resolve() == (project / "edl.json").resolve()
    assert "FINISHED" in found[4]
    decided = edls.load(project / "edl.json").overrides
    assert decided != an_edl().overrides
    assert pull_overrides(away / "third.blend", blender=blender).overrides == decided  # opened anew, elsewhere
    assert pull_overrides(project / "second.blend", blender=blender).overrides == an_edl().overrides


def test_a_copy_saved_elsewhere_leaves_the_open_file_as_it_was(built, blender, tmp_path):
    away = tmp_path / "away" / "deeper"
    away.mkdir(parents=True)
    code = f"""
        {SWITCH_ON.replace(chr(10), chr(10) + "    ")}
        bpy.ops.wm.save_as_mainfile(filepath={str(away / "copy.blend")!r}, copy=True)
        out = [scene["mcsl_edl"], str(bpy.ops.mcsl.pull_overrides())]
        bpy.ops.wm.open_mainfile(filepath={str(away / "copy.blend")!r})
        scene = next(s for s in bpy.data.scenes if s.get("mcsl_edl"))
        films = [s.filepath for s in scene.sequence_editor.strips if s.type == "MOVIE"]
        out += [bpy.path.abspath(scene["mcsl_edl"]), [bpy.path.abspath(film) for film in films]]
    """
    here, done, there, films = in_blender(blender, built, code, save=False)
    assert here == "//edl.json"
    assert "FINISHED" in done
    assert Path(there).resolve() == (built.parent / "edl.json").resolve()
    assert films
    assert all(Path(film).is_file() for film in films)
