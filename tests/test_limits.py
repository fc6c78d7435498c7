"""What keeps a place readable: lines a file, lines a function, parameters a signature."""

from __future__ import annotations

import ast
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FILE_LINES, FUNCTION_LINES, PARAMETERS = 400, 60, 7


def sources() -> list[Path]:
    """Every Python file of the project: tracked ones, where git can say which."""
    listed = subprocess.run(["git", "-C", ROOT, "ls-files", "-z", "*.py"], capture_output=True, text=True)
    names = listed.stdout.split("\0") if listed.returncode == 0 else [str(p) for p in ROOT.rglob("*.py")]
    return [ROOT / name for name in names if name and (ROOT / name).is_file()]


def beyond(text: str) -> Iterator[str]:
    """What of a module's text is longer or wider than agreed; a signature without its self or cls."""
    lines = len(text.splitlines())
    if lines > FILE_LINES:
        yield f"{lines} lines"
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            length = (node.end_lineno or node.lineno) - node.lineno + 1
            names = [a.arg for a in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)]
            names = [name for name in names if name not in ("self", "cls")]
            if length > FUNCTION_LINES:
                yield f"{node.name} (line {node.lineno}): {length} lines"
            if len(names) > PARAMETERS:
                yield f"{node.name} (line {node.lineno}): {len(names)} parameters"


def test_no_file_function_or_signature_is_larger_than_agreed() -> None:
    found = {str(path.relative_to(ROOT)): list(beyond(path.read_text("utf-8"))) for path in sources()}
    assert len(found) > 300
    assert {name: faults for name, faults in found.items() if faults} == {}


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("\n" * 401, "401 lines"),
        ("def f():\n" + "    x = 1\n" * 60, "f (line 1): 61 lines"),
        ("class A:\n    def f(self, a, b, c, d, e, f, g, *, h): pass", "f (line 2): 8 parameters"),
    ],
)
def test_what_is_larger_is_named(text: str, fault: str) -> None:
    assert fault in list(beyond(text))
