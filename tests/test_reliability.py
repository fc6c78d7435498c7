"""docs/reliability.md: every case names what holds it, and what it names is there."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "reliability.md"
CASE = re.compile(r"^\|(?:.*[^\\])?\|(.*)\|$")  # what stands in its last column
NAMED = re.compile(r"`([\w./-]+\.(?:py|md))?(?:::)?(\w+)?`")


def cases(text: str) -> Iterator[tuple[str, str]]:
    """(row, its last cell) of every table whose last column is `test`."""
    is_case = False
    for line in text.splitlines():
        row = CASE.match(line)
        if row is None or row[1].strip("- ") in ("", "test"):
            is_case = row is not None and (is_case or row[1].strip() == "test")
        elif is_case:
            yield line, row[1]


@cache
def functions_of(file: Path) -> set[str]:
    tree = ast.parse(file.read_text("utf-8"))
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and node.name.startswith("test")}


def faults(text: str) -> Iterator[str]:
    """The rows that name nothing, and the names that lead nowhere."""
    for row, cell in cases(text):
        file, named = None, NAMED.findall(cell)
        if not named:
            yield f"names no test: {row}"
        for path, test in named:  # a name alone stands in the file that was named before it
            file = ROOT / path if path else file
            if file is None or not file.is_file():
                yield f"no such file: {path or test}"
            elif test and test not in functions_of(file):
                yield f"no such test: {file.relative_to(ROOT)}::{test}"


def test_every_case_names_a_test_that_is_there() -> None:
    text = PAGE.read_text("utf-8")
    assert len(list(cases(text))) > 130
    assert list(faults(text)) == []


HEAD = "| case | tried | what happens | test |\n|---|---|---|---|\n"


@pytest.mark.parametrize(
    ("cell", "fault"),
    [
        ("by hand", "names no test"),
        ("`tests/test_gone.py::test_a`", "no such file: tests/test_gone.py"),
        ("`tests/test_reliability.py::test_gone`", "no such test: tests/test_reliability.py::test_gone"),
        ("`tests/test_reliability.py`, `::test_gone`", "no such test: tests/test_reliability.py::test_gone"),
        ("`test_gone`", "no such file: test_gone"),
    ],
)
def test_what_leads_nowhere_is_named(cell: str, fault: str) -> None:
    found = list(faults(f"{HEAD}| a\\|b | once | refused | {cell} |\n"))
    assert len(found) == 1
    assert found[0].startswith(fault)
