"""Where the child's files are found: in the source tree and in an installed package."""

from __future__ import annotations

from pathlib import Path

import pytest

import mcsl_core
from mcsl_core.blender import child
from mcsl_core.delivery import presets
from mcsl_core.errors import BlenderError

PACKAGE = Path(mcsl_core.__file__).parent


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Stands for site-packages, with nothing in it but mcsl_core."""
    package = tmp_path / "site-packages" / "mcsl_core"
    for module, name in ((child, "blender/child.py"), (presets, "delivery/presets.py")):
        monkeypatch.setattr(module, "__file__", str(package / name))
    package.mkdir(parents=True)
    return package


def test_in_the_source_tree_they_lie_beside_the_package():
    assert child.script() == PACKAGE.parent / "blender_addon" / "worker" / "__main__.py"
    assert child.script().is_file()
    assert child.search_paths()[0] == str(PACKAGE.parent)
    assert presets.presets_folder() == PACKAGE.parent / "render_presets"


def test_installed_they_lie_in_a_folder_of_the_package(installed):
    data = installed / "data"
    (data / "blender_addon" / "worker").mkdir(parents=True)
    (data / "render_presets").mkdir()
    assert child.script() == data / "blender_addon" / "worker" / "__main__.py"
    assert child.search_paths()[0] == str(data)
    assert presets.presets_folder() == data / "render_presets"


def test_files_that_are_missing_are_told_of(installed):
    with pytest.raises(BlenderError, match="the add-on's files are missing"):
        child.search_paths()
