"""The built extension, installed by Blender's own installer, working from its own wheels alone."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import textwrap
import zipfile
from pathlib import Path

import pytest
from blender_recording import in_blender

from mcsl_core import __version__
from mcsl_core.blender.installation import find

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import extension  # noqa: E402  # pyright: ignore[reportMissingImports]

pytestmark = pytest.mark.both_blenders


@pytest.fixture(scope="session")
def package(tmp_path_factory) -> Path:
    return extension.build(tmp_path_factory.mktemp("extension") / "mcsl.zip", find())


def bare(blender, folder: Path) -> Path:
    """A folder with what Blender's own Python has, and neither mcsl nor attrs: links to the packages of a bpy wheel."""
    code = "import importlib.util as u; print(u.find_spec('bpy').origin)"
    done = subprocess.run([*blender.command, "-c", code], capture_output=True, text=True, check=True)
    packages = Path(done.stdout.strip()).parents[1]
    folder.mkdir()
    own = {"bpy", "numpy", "requests", "urllib3", "idna", "certifi", "charset_normalizer", "zstandard", "cython"}
    for path in packages.iterdir():
        if path.name.partition(".")[0].partition("-")[0] in own:
            (folder / path.name).symlink_to(path)
    return folder


def installed(blender, package: Path, home: Path, code: str, *arguments: str):
    """Installs the zip into an empty Blender, runs ``code``, returns what it put into ``out``."""
    answer, script = home / "answer.json", home / "script.py"
    script.write_text(
        f"""
import json, os, sys, traceback
sys.path.append({str(bare(blender, home / "bare"))!r})
code = 1
try:
    import bpy
    bpy.ops.extensions.package_install_files(filepath={str(package)!r}, repo="user_default", enable_on_install=True)
    out = None
{textwrap.indent(textwrap.dedent(code), "    ")}
    with open({str(answer)!r}, "w") as stream: json.dump(out, stream)
    code = 0
except BaseException:
    traceback.print_exc()
sys.stdout.flush(); sys.stderr.flush()
os._exit(code)
""",
        encoding="utf-8",
    )
    environment = {**os.environ, "BLENDER_USER_RESOURCES": str(home / "user"), "HOME": str(home), "PATH": os.defpath}
    for name in ("PYTHONPATH", "MCSL", "VIRTUAL_ENV"):
        environment.pop(name, None)
    start = ["-b", "--factory-startup", "-P"] if blender.kind == "binary" else ["-S", "-s", "-P"]
    command = [*blender.command, *start, str(script), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, env=environment)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-3000:]
    return json.loads(answer.read_text()), done.stdout + done.stderr


def test_it_is_one_zip_of_pure_python(package):
    with zipfile.ZipFile(package) as archive:
        names = archive.namelist()
        wheels = sorted(Path(name).name for name in names if name.startswith("wheels/"))
        assert "blender_manifest.toml" in names
        assert {name.split("-")[0] for name in wheels} == {
            "attrs",
            "cattrs",
            "filelock",
            "mcsl_core",
            "typing_extensions",
        }
        assert all(name.endswith("-py3-none-any.whl") for name in wheels)
        manifest = archive.read("blender_manifest.toml").decode()
        for name in wheels:
            assert f'"./wheels/{name}"' in manifest
        assert not [name for name in names if "__pycache__" in name or name.startswith("worker/")]
    assert f'version = "{__version__}"' in manifest


def test_the_same_tree_gives_the_same_bytes(package, tmp_path):
    assert extension.build(tmp_path / "again.zip", find()).read_bytes() == package.read_bytes()


def test_it_works_from_its_own_wheels_alone(built, blender, package, tmp_path):
    code = f"""
    import attrs, cattrs, filelock, mcsl_core
    used = [addon.module for addon in bpy.context.preferences.addons if "mcsl" in addon.module]
    where = [module.__file__.startswith({str(tmp_path)!r}) for module in (attrs, cattrs, filelock, mcsl_core)]
    bpy.ops.wm.open_mainfile(filepath={str(built)!r})
    state = bpy.context.window_manager.mcsl_state
    rows = [[i.start, i.camera, i.overridden] for i in state.shots]
    scene = next(s for s in bpy.data.scenes if s.get("mcsl_edl"))
    scene.frame_set(6)
    bpy.ops.mcsl.switch_camera(camera="cam3")
    bpy.ops.mcsl.pull_overrides()
    from bl_ext.user_default.mcsl.core import presets
    from bl_ext.user_default.mcsl.ui import preferences
    out = [used, where, rows, list(presets.load_all()), preferences.MCSL_Preferences.bl_idname]
    """
    (used, where, rows, presets, name), _ = installed(blender, package, tmp_path, code)
    assert used == ["bl_ext.user_default.mcsl"]
    assert where == [True, True, True, True]
    assert rows == [
        [0, "cam1", False],
        [20, "cam2", False],
        [40, "cam3", False],
        [45, "cam1", True],
        [50, "cam3", False],
    ]
    assert presets[0] == "h264"
    assert name == "bl_ext.user_default.mcsl"
    edl = json.loads((built.parent / "edl.json").read_text())
    assert {"range": [5, 20], "camera": "cam3"} in edl["overrides"]


def test_off_and_on_again_says_nothing(blender, package, tmp_path):
    code = """
    import addon_utils, warnings
    warnings.simplefilter("error")
    name = "bl_ext.user_default.mcsl"
    out = []
    for _ in range(2):
        addon_utils.disable(name, default_set=True)
        out.append(hasattr(bpy.types, "MCSL_PT_shots") or hasattr(bpy.types.Scene, "mcsl_work"))
        addon_utils.enable(name, default_set=True)
        out.append(hasattr(bpy.types, "MCSL_PT_shots") and hasattr(bpy.types.Scene, "mcsl_work"))
    """
    out, said = installed(blender, package, tmp_path, code)
    assert out == [False, True] * 2
    assert "arning" not in said
    assert "rror" not in said.replace("error_policy", "")


def test_without_mcsl_it_names_the_one_command_that_installs_it(built, blender, package, tmp_path):
    code = f"""
    bpy.ops.wm.open_mainfile(filepath={str(built)!r})
    from bl_ext.user_default.mcsl.process import find_mcsl
    find_mcsl.usual_places = lambda environ, home: []  # this machine may have one where people have them
    out = []
    for press in (bpy.ops.mcsl.conform, bpy.ops.mcsl.analyse):
        try:
            press()
        except RuntimeError as error:
            out.append(str(error).strip())
    """
    said, _ = installed(blender, package, tmp_path, code)
    assert len(said) == 2
    for line in said:
        assert "mcsl is not installed here. In the folder of mcsl's source run: pipx install ." in line
        assert len(line.splitlines()) == 1


def test_the_log_warns_when_a_file_shows_other_than_it_decides(project, blender, package, tmp_path):
    """Edited without the extension, opened with it: what no longer holds falls away, and the log says so."""
    from mcsl_core import edl as edls
    from mcsl_core.blender.timeline import build_timeline
    from mcsl_core.delivery.conform import conform, default_folder
    from mcsl_core.delivery.source import ProgrammeSource

    edl = project / "edl.json"
    conform(ProgrammeSource(edls.load(edl), project), default_folder(edl), jobs=1)
    built = project / "edit.blend"
    assert build_timeline(edl, built, blender=blender).conformed == 1
    in_blender(blender, built, "at(5, 10).multicam_source = 2")
    code = f"""
    bpy.ops.wm.open_mainfile(filepath={str(built)!r})
    scene = next(s for s in bpy.data.scenes if s.get("mcsl_edl"))
    out = sorted([s.frame_final_start - 1, s.frame_final_end - 1, s.mute] for s in scene.sequence_editor.strips
                 if s.get("mcsl") == "conformed")
    """
    pieces, said = installed(blender, package, tmp_path, code)
    assert pieces == [[0, 20, True], [20, 60, False]]
    assert "mcsl: warning: 0.7 s of the programme show the preview" in said.replace("\u00a0", " ")
