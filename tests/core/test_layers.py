"""Imports run downward only. The floors stand here; a module that is not in the table fails with where to add it.

Two ways of looking, since each sees what the other cannot: the source text (also imports inside functions and for type
checking), and a fresh Python per floor in which everything forbidden is blocked (also what comes in sideways).
"""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

# What each floor may hold is told in docs/architecture.md. Imports run to lower floors or within the same one.
FLOORS: dict[int, set[str]] = {
    0: {"errors", "timing", "progress", "documents", "edl", "decisions"},
    1: {
        *("images", "media", "video", "playhead", "sampling", "sound", "recording", "footage"),  # reading
        *("samples", "scene", "scores"),  # values that pass between stages
    },
    2: {
        "sync",
        "movement",
        "features",
        "alignment",
        "occlusion",
        "consensus",
        "selection",
        "centering",
        "gaze",
        "filling",
        "colour",
    },
    3: {
        *("compositor", "eye", "frame_view", "parallax", "placement", "resampling"),  # programme frames
        *("misalignment", "hookspecs", "stages", "guards", "default_plugins", "plugins"),
    },
    4: {
        *("evaluation", "figures", "manual", "steadiness", "reduced", "coverage", "study", "report"),  # measuring
        *(
            "surgical_field",
            "dense",
            "evidence",
            "solving",
            "anchoring",
            "scoring",
            "cutting",
            "stage_cache",
            "analysis",
        ),  # deciding
        *("contact", "simulation", "demo"),
        *(
            "quality",
            "chunks",
            "conform",
            "programme_sound",
            "blender",
            "blender_child",
            "timeline",
            "presets",
            "rendering",
            "looks",
        ),
    },
    5: {"console", "session", "cli"},
}
# Those of the table that are packages: their modules stand on their floor.
PACKAGES = {"filling", "movement", "report", "simulation", "sync", "video"}
STAGES = 2  # the floor on which modules do not import each other: values pass between them through analysis.py

# Of the add-on, what runs anywhere and what needs Blender.
ADDON_PURE = {
    *("__init__", "plan", "readback", "nudges", "switching", "similarity", "background"),
    *("deliveries", "finding", "japanese", "jobs", "outstanding", "recordings", "reverting", "shots"),
}
ADDON_BPY = {
    *("by_hand", "operators", "output", "panels", "scenes", "strips", "tasks"),
    *("conformed", "preferences", "properties", "running", "translations", "watching"),
}

# Third-party packages with a home: nobody else imports them.
HOMES = {
    "av": {"video"},
    "click": {"cli"},
    "jinja2": {"report"},
    "rich": {"cli", "console", "session"},
    "pluggy": {"hookspecs", "plugins"},
}
FLOOR_0_PACKAGES = {"attr", "attrs", "cattr", "cattrs"}
NEEDED_BY_THEM = {"typing_extensions", "exceptiongroup"}
BLENDER = {"bpy", "bpy_extras", "bl_ui", "bl_operators", "mathutils", "addon_utils", "imbuf", "gpu", "aud", "blf"}
ADDON_PACKAGES = {*FLOOR_0_PACKAGES, "numpy"}  # Blender ships numpy

FLOOR_OF = {name: floor for floor, names in FLOORS.items() for name in names}


# ------------------------------------------------------------------------------------------------ the source text


def modules_of(package: Path) -> dict[str, list[Path]]:
    """module or subpackage -> its files; the package's own ``__init__`` too."""
    found = {p.stem: [p] for p in package.glob("*.py")}
    found |= {p.name: sorted(p.rglob("*.py")) for p in package.iterdir() if (p / "__init__.py").exists()}
    return found


def imports_of(path: Path, root: Path) -> set[str]:
    """Full dotted names of everything a file imports, wherever in it; what comes from a package counts as below it."""
    package = path.relative_to(root).with_suffix("").parts[:-1]
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            source = ".".join([*base, *([node.module] if node.module else [])])
            found.update(f"{source}.{alias.name}" for alias in node.names)
    return found


def core_modules(names: set[str], known: set[str]) -> set[str]:
    """The modules of mcsl_core among full dotted names."""
    parts = [name.split(".") for name in names]
    return {p[1] for p in parts if p[0] == "mcsl_core" and len(p) > 1 and p[1] in known}


def packages(names: set[str]) -> set[str]:
    """Top-level third-party packages among full dotted names."""
    top = {name.split(".")[0] for name in names}
    return top - sys.stdlib_module_names - {"mcsl_core", "blender_addon", "__future__"}


def faults_in(root: Path) -> list[str]:
    """Every import of the tree at ``root`` that a floor forbids, and every module without a floor."""
    core = modules_of(root / "mcsl_core")
    addon = modules_of(root / "blender_addon")
    table = "in tests/core/test_layers.py"
    faults = [
        f"mcsl_core/{name} stands on no floor: add it to FLOORS {table}"
        for name in core.keys() - FLOOR_OF - {"__init__"}
    ]
    faults += [f"mcsl_core/{name} is gone: take it out of FLOORS {table}" for name in FLOOR_OF.keys() - core]
    listed = ADDON_PURE | ADDON_BPY
    faults += [
        f"blender_addon/{name} is not listed: add it to ADDON_PURE or ADDON_BPY {table}"
        for name in addon.keys() - listed
    ]
    faults += [f"blender_addon/{name} is gone: take it out {table}" for name in listed - addon.keys()]

    for name, files in core.items():
        floor = FLOOR_OF.get(name, max(FLOORS))
        for path in files:
            names = imports_of(path, root)
            where = path.relative_to(root).as_posix()
            for other in core_modules(names, set(core)) - {name}:
                if name == "__init__" or FLOOR_OF.get(other, 0) > floor:
                    faults.append(f"{where} imports {other}, which stands above it")
                elif floor == STAGES and FLOOR_OF.get(other) == STAGES:
                    faults.append(f"{where} imports {other}: stages do not import each other")
            third = packages(names)
            faults += [f"{where} imports {p}, and mcsl_core is free of Blender" for p in third & BLENDER]
            faults += [
                f"{where} imports {p}, which only {', '.join(sorted(HOMES[p]))} may"
                for p in third & HOMES.keys()
                if name not in HOMES[p]
            ]
            if floor == 0:
                faults += [
                    f"{where} imports {p}, and floor 0 does with attrs and cattrs" for p in third - FLOOR_0_PACKAGES
                ]
            if name == "__init__":
                faults += [f"{where} imports {p}, and importing mcsl_core imports nothing heavy" for p in third]
            if any(n.split(".")[0] == "blender_addon" for n in names):
                faults.append(f"{where} imports blender_addon: that one is under another licence and runs in Blender")

    for name, files in addon.items():
        allowed = ADDON_PACKAGES | (set() if name in ADDON_PURE else BLENDER)
        for path in files:
            names = imports_of(path, root)
            where = path.relative_to(root).as_posix()
            faults += [
                f"{where} imports mcsl_core.{m}, and the add-on uses floor 0 only"
                for m in core_modules(names, set(core)) - FLOORS[0]
            ]
            faults += [f"{where} imports {p}, which it may not" for p in packages(names) - allowed]
    return sorted(faults)


def test_imports_run_downward_only():
    faults = faults_in(ROOT)
    assert not faults, "\n".join(["", *faults])


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """The modules of the tables, all empty."""
    for package, names in (("mcsl_core", {"__init__", *FLOOR_OF}), ("blender_addon", ADDON_PURE | ADDON_BPY)):
        for name in names:
            path = tmp_path / package / (f"{name}/__init__.py" if name in PACKAGES else f"{name}.py")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text("", "utf-8")
    return tmp_path


# Each rule is broken on purpose: (file, its text, what must be said).
BREACHES = [
    ("mcsl_core/edl.py", "from .video import probe", "imports video, which stands above it"),
    ("mcsl_core/edl.py", "def f():\n    import mcsl_core.analysis", "imports analysis, which stands above it"),
    ("mcsl_core/media.py", "from . import edl, alignment", "imports alignment, which stands above it"),
    ("mcsl_core/video/__init__.py", "from .. import edl, alignment", "imports alignment, which stands above it"),
    ("mcsl_core/video/sound.py", "from ..selection import x", "imports selection, which stands above it"),
    ("mcsl_core/selection.py", "from mcsl_core.movement import x", "stages do not import each other"),
    ("mcsl_core/simulation/__init__.py", "from ..cli import main", "imports cli, which stands above it"),
    ("mcsl_core/simulation/deep.py", "from mcsl_core import cli", "imports cli, which stands above it"),
    ("mcsl_core/timing.py", "import numpy as np", "imports numpy, and floor 0 does with attrs and cattrs"),
    ("mcsl_core/footage.py", "if 1:\n    import av.error", "imports av, which only video may"),
    ("mcsl_core/sound.py", "import av", "mcsl_core/sound.py imports av, which only video may"),
    ("mcsl_core/simulation/video.py", "from av import open", "simulation/video.py imports av, which only video may"),
    ("mcsl_core/analysis.py", "from rich.table import Table", "imports rich, which only cli, console, session may"),
    ("mcsl_core/analysis.py", "import bpy", "mcsl_core is free of Blender"),
    ("mcsl_core/analysis.py", "import blender_addon.plan", "imports blender_addon"),
    ("mcsl_core/__init__.py", "from .edl import Edl", "imports edl, which stands above it"),
    ("mcsl_core/__init__.py", "import numpy", "importing mcsl_core imports nothing heavy"),
    (
        "mcsl_core/brand_new.py",
        "",
        "mcsl_core/brand_new stands on no floor: add it to FLOORS in tests/core/test_layers.py",
    ),
    ("blender_addon/brand_new.py", "", "add it to ADDON_PURE or ADDON_BPY in tests/core/test_layers.py"),
    ("blender_addon/plan.py", "import bpy", "blender_addon/plan.py imports bpy, which it may not"),
    ("blender_addon/plan.py", "import cv2", "imports cv2, which it may not"),
    (
        "blender_addon/plan.py",
        "from mcsl_core.images import psnr",
        "imports mcsl_core.images, and the add-on uses floor 0",
    ),
]


def test_an_empty_tree_has_no_faults(tree):
    assert faults_in(tree) == []


@pytest.mark.parametrize(("file", "text", "message"), BREACHES, ids=lambda x: x[:40])
def test_each_rule_is_seen_when_broken(tree, file, text, message):
    (tree / file).write_text(text + "\n", "utf-8")
    faults = faults_in(tree)
    assert len(faults) == 1
    assert message in faults[0]


@pytest.mark.parametrize("name", ["__init__", "sound", "brand_new"])
def test_every_module_of_the_video_package_may_import_av(tree, name):
    (tree / "mcsl_core" / "video" / f"{name}.py").write_text("import av\nfrom av.error import FFmpegError\n", "utf-8")
    assert faults_in(tree) == []


def test_the_table_knows_the_packages():
    assert {p.parent.name for p in (ROOT / "mcsl_core").glob("*/__init__.py")} == PACKAGES


def test_a_module_that_is_gone_is_told(tree):
    (tree / "mcsl_core" / "selection.py").unlink()
    assert faults_in(tree) == ["mcsl_core/selection is gone: take it out of FLOORS in tests/core/test_layers.py"]


# --------------------------------------------------------------------------------------------- a fresh Python each

CHILD = """
import importlib, json, sys
task = json.loads(sys.argv[1])
sys.path.insert(0, task["root"])

class Block:
    def find_spec(self, name, path=None, target=None):
        top = name.split(".")[0]
        allowed = task["allowed"] is None or top in task["allowed"] or top in sys.stdlib_module_names
        if not allowed or any(name == b or name.startswith(b + ".") for b in task["blocked"]):
            raise ImportError("blocked: " + name)

sys.meta_path.insert(0, Block())
for name in task["blocked_for_sure"]:
    try:
        importlib.import_module(name)
    except ImportError as error:
        assert str(error) == "blocked: " + name, error
    else:
        sys.exit("the block does not block " + name)
for name in task["modules"]:
    importlib.import_module(name)
"""


def import_with_block(modules, *, blocked=(), allowed=None, blocked_for_sure) -> subprocess.CompletedProcess[str]:
    task = {
        "root": str(ROOT),
        "modules": list(modules),
        "blocked": list(blocked),
        "allowed": None if allowed is None else sorted(allowed),
        "blocked_for_sure": list(blocked_for_sure),
    }
    return subprocess.run([sys.executable, "-c", CHILD, json.dumps(task)], capture_output=True, text=True, check=False)


def core(names) -> list[str]:
    return [f"mcsl_core.{name}" for name in sorted(names)]


def above(floor: int) -> list[str]:
    return core(name for name, its in FLOOR_OF.items() if its > floor)


def test_the_package_itself_imports_nothing_but_the_standard_library():
    done = import_with_block(
        ["mcsl_core"], blocked=above(-1), allowed={"mcsl_core"}, blocked_for_sure=["attrs", "numpy"]
    )
    assert done.returncode == 0, done.stderr


def test_floor_0_needs_only_attrs_and_cattrs():
    done = import_with_block(
        core(FLOORS[0]),
        blocked=above(0),
        allowed={*FLOOR_0_PACKAGES, *NEEDED_BY_THEM, "mcsl_core"},
        blocked_for_sure=["numpy", "cv2", "av", "scipy", "mcsl_core.video"],
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("floor", sorted(set(FLOORS) - {0, STAGES}))
def test_a_floor_imports_without_blender_and_without_the_floors_above(floor):
    blocked = ["bpy", "blender_addon", *above(floor)]
    done = import_with_block(
        core(FLOORS[floor]), blocked=blocked, blocked_for_sure=["bpy", "blender_addon", *above(floor)]
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("stage", sorted(FLOORS[STAGES]))
def test_a_stage_imports_without_the_other_stages(stage):
    blocked = ["bpy", "blender_addon", *above(STAGES), *core(FLOORS[STAGES] - {stage})]
    done = import_with_block(core({stage}), blocked=blocked, blocked_for_sure=blocked)
    assert done.returncode == 0, done.stderr


def test_the_add_ons_decisions_need_neither_blender_nor_anything_above_floor_0():
    done = import_with_block(
        [f"blender_addon.{name}" for name in sorted(ADDON_PURE - {"__init__"})],
        blocked=above(0),
        allowed={*ADDON_PACKAGES, *NEEDED_BY_THEM, "mcsl_core", "blender_addon"},
        blocked_for_sure=["bpy", "cv2", "av", "sklearn", "mcsl_core.images"],
    )
    assert done.returncode == 0, done.stderr


def test_a_forbidden_import_would_be_seen():
    for blocked, named in ((["av"], "av"), (["mcsl_core.images"], "mcsl_core.images")):
        done = import_with_block(["mcsl_core.video"], blocked=blocked, blocked_for_sure=[])
        assert done.returncode == 1
        assert f"ImportError: blocked: {named}" in done.stderr
    done = import_with_block(["mcsl_core.timing"], blocked_for_sure=["json"])
    assert (done.returncode, done.stderr) == (1, "the block does not block json\n")
