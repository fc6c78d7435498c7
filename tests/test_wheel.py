"""The wheel, built and installed for real: what is in it, and that mcsl finds its presets and its add-on from there."""

from __future__ import annotations

import json
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

from mcsl_core import __version__

ROOT = Path(__file__).parents[1]
pytestmark = pytest.mark.slow  # a wheel and an environment are made


def files_of(folder: str) -> set[str]:
    """The files of a folder of the source tree, but for what Python writes beside them."""
    found = (path for path in (ROOT / folder).rglob("*") if path.is_file() and "__pycache__" not in path.parts)
    return {path.relative_to(ROOT).as_posix() for path in found}


def run(*command: str, cwd: Path | None = None) -> str:
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-3000:]
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    run(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder), cwd=ROOT)
    (path,) = folder.iterdir()
    return path


@pytest.fixture(scope="module")
def python(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> str:
    """The Python of an environment that has the wheel, and of everything else what this one has, but not our tree.

    A folder that a .pth file names is searched, its own .pth files (one of which names our tree) are not read.
    """
    folder = tmp_path_factory.mktemp("installed")
    venv.create(folder, symlinks=True)
    made = str(folder / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python"))
    run(sys.executable, "-m", "pip", "--python", made, "install", "--quiet", "--no-deps", "--no-index", str(wheel))
    packages = Path(run(made, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))").strip())
    (packages / "what_mcsl_needs.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return made


def ask(python: str, folder: Path, code: str):
    """Runs ``code`` there, away from the source tree, and returns what it put into ``out``."""
    return json.loads(run(python, "-c", f"import json\n{code}\nprint(json.dumps(out))", cwd=folder))


def test_only_mcsl_core_stands_at_its_top_level(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    assert {name.partition("/")[0] for name in names} == {"mcsl_core", f"mcsl-{__version__}.dist-info"}


def test_it_holds_every_file_of_the_package_the_add_on_and_the_presets_and_no_other(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if name.startswith("mcsl_core/")}
    data = files_of("blender_addon") | files_of("render_presets")
    assert "blender_addon/LICENSE" in data, "it is under another licence, which goes with it"
    assert names == files_of("mcsl_core") | {f"mcsl_core/data/{name}" for name in data}


def test_the_presets_are_found(python, tmp_path):
    code = "from mcsl_core.delivery.presets import load_preset, preset_names\n"
    found = ask(python, tmp_path, code + "out = {name: load_preset(name).title for name in preset_names()}")
    assert sorted(found) == sorted(path.stem for path in (ROOT / "render_presets").glob("*.json"))


def test_the_add_on_is_found_and_is_a_package_on_the_paths_that_its_process_gets(python, tmp_path):
    code = "from mcsl_core.blender import child\nout = [str(child.script()), child.search_paths()]"
    script, paths = ask(python, tmp_path, code)
    assert Path(script).is_file()
    assert not Path(script).is_relative_to(ROOT)
    # As in Blender: a Python that has none of our packages and appends the paths.
    code = f"import json, sys\nsys.path += {paths!r}\nimport blender_addon\nfrom blender_addon.core import presets\n"
    code += "print(json.dumps([blender_addon.__file__, [preset.name for preset in presets.load_all()]]))"
    done = run(sys.executable, "-I", "-S", "-c", code, cwd=tmp_path)
    package, presets = json.loads(done)
    assert Path(package).parent in Path(script).parents
    assert sorted(presets) == sorted(path.stem for path in (ROOT / "render_presets").glob("*.json"))


@pytest.mark.blender
def test_blender_runs_the_installed_add_on(python, tmp_path):
    """No timeline is at hand; a file that is none is refused by the task itself, so it was reached."""
    code = f"""
from mcsl_core.blender import child
from mcsl_core.blender.installation import find
from mcsl_core.errors import InputError
try:
    out = child.run_task(find(), {{"task": "read", "blend": {str(tmp_path / "none.blend")!r}}})
except InputError as error:
    out = str(error)
"""
    assert "none.blend" in ask(python, tmp_path, code)
