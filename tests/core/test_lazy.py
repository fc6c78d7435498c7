"""What the two public packages, `mcsl_core` and `mcsl_core.hooks`, offer: found when asked for, known to checkers."""

from __future__ import annotations

import ast
import importlib
import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PUBLIC = {"mcsl_core": ROOT / "mcsl_core" / "__init__.py", "mcsl_core.hooks": ROOT / "mcsl_core/hooks/__init__.py"}


def seen_by_type_checkers(file: Path) -> dict[str, str]:
    """name -> module, of the imports under ``if TYPE_CHECKING``."""
    block = next(node for node in ast.parse(file.read_text("utf-8")).body if isinstance(node, ast.If))
    imports = [node for node in block.body if isinstance(node, ast.ImportFrom)]
    return {alias.name: node.module or "" for node in imports for alias in node.names}


@pytest.mark.parametrize("package", PUBLIC)
def test_what_is_found_is_what_type_checkers_see(package: str) -> None:
    module, seen = importlib.import_module(package), seen_by_type_checkers(PUBLIC[package])
    assert set(module.__all__) - {"__version__"} == set(seen)
    for name, home in seen.items():
        assert getattr(module, name) is getattr(importlib.import_module(home), name)
        assert name in dir(module)


@pytest.mark.parametrize("package", PUBLIC)
def test_a_name_that_there_is_not_is_an_attribute_error(package: str) -> None:
    with pytest.raises(AttributeError, match=f"module '{package}' has no attribute 'nonsense'"):
        _ = importlib.import_module(package).nonsense
    with pytest.raises(ImportError, match="cannot import name 'nonsense'"):
        exec(f"from {package} import nonsense")


IMPORTED = """
import json, sys, time
before = set(sys.modules)
began = time.perf_counter()
import {module}
spent = time.perf_counter() - began
print(json.dumps([spent, sorted({{name.split(".")[0] for name in set(sys.modules) - before}})]))
"""


PARTS = {"scipy.signal", "scipy.stats", "scipy.optimize", "scipy.interpolate"}


def imported(module: str) -> tuple[float, set[str]]:
    """Seconds that an import takes in a fresh Python, at the best of three, and the top packages that came with it."""
    command = [sys.executable, "-c", IMPORTED.format(module=module)]
    told = [json.loads(subprocess.run(command, capture_output=True, check=True).stdout) for _ in range(3)]
    return min(seconds for seconds, _ in told), set(told[0][1])


def test_importing_the_front_door_takes_no_time_and_brings_the_standard_library_alone() -> None:
    seconds, packages = imported("mcsl_core")
    assert packages - sys.stdlib_module_names == {"mcsl_core"}
    assert seconds < 0.05


def test_the_stages_come_without_the_rest_of_the_hooks() -> None:
    _, packages = imported("mcsl_core.hooks.stages")
    assert not packages & {"numpy", "cv2", "pluggy", "av", "scipy", "sklearn"}


def test_a_stage_of_the_analysis_brings_the_parts_of_scipy_that_it_uses() -> None:
    """All parts that any stage uses take as long to import as all the rest of mcsl."""
    told = f"import sys, mcsl_core.analysis.pipeline; print({PARTS!r} & set(sys.modules))"
    assert subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=True).stdout == "set()\n"


def test_type_checkers_are_told_that_mcsl_is_typed() -> None:
    assert (ROOT / "mcsl_core" / "py.typed").is_file()
