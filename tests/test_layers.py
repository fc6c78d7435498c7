"""The contracts on imports (pyproject.toml, [tool.importlinter]) hold, and each of them is broken once on purpose.

import-linter reads the source text. What comes in sideways, when a module is really imported, is seen by a fresh Python
in which all is blocked that Blender's has not.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("mcsl_core", "blender_addon")
CONTRACTS = {
    contract["id"]: contract["name"]
    for contract in tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["contracts"]
}

# contract -> (file, a line that breaks it)
BREACHES = {
    "layers": ("mcsl_core/media/probing.py", "from mcsl_core.alignment import joint"),
    "circles": ("mcsl_core/imaging/rect.py", "from mcsl_core.imaging import warp"),
    "door": ("mcsl_core/__init__.py", "import numpy"),
    "ground": ("mcsl_core/timing.py", "import numpy"),
    "av": ("mcsl_core/recording/footage.py", "def f():\n    import av.error"),
    "terminal": ("mcsl_core/analysis/summary.py", "from rich.table import Table"),
    "bpy": ("blender_addon/core/strip_plan.py", "import bpy"),
    "addon": ("mcsl_core/blender/child.py", "import blender_addon.core.strip_plan"),
    "blender-python": ("blender_addon/sequencer/build.py", "from mcsl_core.imaging import planes"),
}


def lint(tree: Path) -> subprocess.CompletedProcess[str]:
    code = "from importlinter.cli import lint_imports_command; lint_imports_command()"
    command = [sys.executable, "-c", code, "--no-cache"]
    return subprocess.run(command, cwd=tree, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the two packages and the contracts."""
    folder = tmp_path_factory.mktemp("house")
    for package in PACKAGES:
        shutil.copytree(ROOT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", folder)
    return folder


def test_every_contract_holds(tree: Path) -> None:
    done = lint(tree)
    assert done.returncode == 0, done.stdout
    assert f"{len(CONTRACTS)} kept, 0 broken" in done.stdout


def test_every_contract_has_its_breach() -> None:
    assert set(BREACHES) == set(CONTRACTS)


@pytest.mark.slow
@pytest.mark.parametrize("contract", BREACHES)
def test_a_breach_is_seen(tree: Path, contract: str) -> None:
    name, line = BREACHES[contract]
    file = tree / name
    text = file.read_text("utf-8")
    file.write_text(f"{text}\n{line}\n", "utf-8")
    try:
        done = lint(tree)
    finally:
        file.write_text(text, "utf-8")
    assert done.returncode == 1, done.stdout
    said = " ".join(done.stdout.split())
    assert f"{CONTRACTS[contract]} BROKEN" in said


@pytest.mark.slow
def test_a_package_that_no_layer_names_is_seen(tree: Path) -> None:
    new = tree / "mcsl_core" / "attic"
    new.mkdir()
    (new / "__init__.py").write_text("", "utf-8")
    try:
        done = lint(tree)
    finally:
        shutil.rmtree(new)
    assert done.returncode == 1
    assert "attic" in done.stdout


# --------------------------------------------------------------------------------------------- a fresh Python each

# Blender ships numpy; attrs, cattrs and what they need come as wheels with the extension.
BLENDERS = ("attr", "attrs", "cattr", "cattrs", "typing_extensions", "exceptiongroup", "numpy", *PACKAGES)
CHILD = """
import importlib, sys

class Block:
    def find_spec(self, name, path=None, target=None):
        top = name.split(".")[0]
        if top not in ALLOWED and top not in sys.stdlib_module_names:
            raise ImportError("blocked: " + name)

ALLOWED = set(sys.argv[2].split(","))
sys.path.insert(0, sys.argv[1])
sys.meta_path.insert(0, Block())
for name in sys.argv[3:]:
    importlib.import_module(name)
print(len(sys.argv[3:]), "imported")
"""


def import_in_blenders_python(*modules: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", CHILD, str(ROOT), ",".join(BLENDERS), *modules]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_what_the_add_on_decides_imports_in_blenders_python() -> None:
    modules = [
        ".".join(path.relative_to(ROOT).with_suffix("").parts)
        for room in ("core", "process")
        for path in sorted((ROOT / "blender_addon" / room).glob("[a-z]*.py"))
    ]
    done = import_in_blenders_python(*modules)
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"{len(modules)} imported\n"


@pytest.mark.parametrize("module", ["cv2", "av", "sklearn", "mcsl_core.imaging.planes", "bpy"])
def test_what_blenders_python_lacks_is_blocked(module: str) -> None:
    done = import_in_blenders_python(module)
    assert done.returncode == 1
    assert "ImportError: blocked: " in done.stderr
