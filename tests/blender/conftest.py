"""A small recording whose pictures carry coded numbers, and the Blender that the tests run."""

from __future__ import annotations

import os
import shutil
from fractions import Fraction
from pathlib import Path

import pytest
from blender_recording import FRAMES, an_edl, write_camera

from mcsl_core import edl as edls
from mcsl_core.blender.installation import Blender, find, private_python
from mcsl_core.progress import Silent

NAME = "Aufnahme 手術"


def pytest_collection_modifyitems(items):
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.blender)


def pytest_generate_tests(metafunc):
    """Tests marked `both_blenders` run in the oldest supported Blender too, each in its own environment."""
    if "blender" in metafunc.fixturenames:
        both = metafunc.definition.get_closest_marker("both_blenders") is not None
        metafunc.parametrize("blender", ["newer", "4.5"] if both else ["newer"], indirect=True, scope="session")


@pytest.fixture(autouse=True, scope="session")
def temporary_files(tmp_path_factory):
    """Blenders that tests start by themselves leave a folder each in the temporary one: not in everybody's."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TMPDIR", str(tmp_path_factory.mktemp("tmp")))
        yield


@pytest.fixture(scope="session")
def blender(request) -> Blender:
    """The Blender that `mcsl` finds, or the oldest one: MCSL_BLENDER_OLDEST, `mcsl blender install --version 4.5`."""
    if os.environ.get("MCSL_TESTS_WITHOUT_BLENDER") == "1":
        pytest.skip("MCSL_TESTS_WITHOUT_BLENDER=1")
    if request.param == "newer":
        return find()
    oldest = os.environ.get("MCSL_BLENDER_OLDEST") or str(private_python("4.5"))
    if not Path(oldest).exists():
        how = "no Blender 4.5 here: mcsl blender install --version 4.5, or MCSL_BLENDER_OLDEST"
        (pytest.fail if os.environ.get("MCSL_TESTS_BOTH_BLENDERS") == "1" else pytest.skip)(how)
    return find(oldest)


@pytest.fixture(scope="session")
def footage(tmp_path_factory) -> Path:
    """cam1 in two files, cam2 three frames late, cam3 silent; cam1 is the reference."""
    folder = tmp_path_factory.mktemp("recording")
    write_camera(folder / "cam1_a.mp4", "cam1", 40)
    write_camera(folder / "cam1_b.mp4", "cam1", FRAMES - 40, first=40)
    write_camera(folder / "cam2.mp4", "cam2", FRAMES - 3, first=3)
    write_camera(folder / "cam3.mp4", "cam3", FRAMES, sound=False)
    return folder


def _begun(folder: Path, footage: Path) -> Path:
    folder.mkdir()
    for file in footage.iterdir():
        os.link(file, folder / file.name)
    edls.save(an_edl(), folder / "edl.json")
    return folder


def _timeline_of(project: Path, blender: Blender) -> Path:
    from mcsl_core.blender.timeline import build_timeline

    build_timeline(project / "edl.json", project / "edit.blend", blender=blender)
    return project / "edit.blend"


@pytest.fixture
def project(tmp_path, footage) -> Path:
    """A folder of its own with the recording (as links) and edl.json; its name is not ASCII, as people's are not."""
    return _begun(tmp_path / NAME, footage)


@pytest.fixture(scope="session")
def template(tmp_path_factory, footage, blender) -> Path:
    """A project with its timeline: tests work in copies, since to build one takes a start of Blender."""
    folder = _begun(tmp_path_factory.mktemp("template") / NAME, footage)
    _timeline_of(folder, blender)
    return folder


@pytest.fixture
def built(project, template) -> Path:
    """The project's timeline, and what mcsl remembers of having written it; it knows that it is a copy."""
    for file in template.iterdir():
        if not (project / file.name).exists():
            shutil.copy2(file, project / file.name)
    return project / "edit.blend"


@pytest.fixture
def built_here(project, blender) -> Path:
    """The project's timeline, which lies where it was built: also an EDL of other automatic decisions is its own."""
    return _timeline_of(project, blender)


@pytest.fixture(scope="session")
def simulated(tmp_path_factory) -> Path:
    """Three cameras of six seconds, as an editor has them before there is an EDL."""
    from mcsl_core.simulation import Scenario, simulate

    folder = tmp_path_factory.mktemp("simulated")
    scenario = Scenario(size=(320, 180), rate=Fraction(25), duration_s=6.0, cameras=3, movements=0, seed=311)
    simulate(scenario, folder, Silent())
    return folder
