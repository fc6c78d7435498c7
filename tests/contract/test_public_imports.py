"""A plugin imports `mcsl_core.hooks`, and its own command line the front door besides: nothing else of mcsl."""

from __future__ import annotations

import ast
import importlib
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from hooks_page import PAGE, blocks

import mcsl_core.hooks

PLUGINS = Path(__file__).parents[2] / "plugins"
MODULES = sorted(PLUGINS.glob("*/mcsl_*/**/*.py"))
ALLOWED = ("mcsl_core", "mcsl_core.hooks")


def private_imports(text: str) -> Iterator[str]:
    """Everything of mcsl that ``text`` imports, wherever in it, and that is no name of the two public packages."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (a.name for a in node.names if a.name.split(".")[0] == "mcsl_core" and a.name not in ALLOWED)
        elif isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "mcsl_core":
            public = importlib.import_module(node.module).__all__ if node.module in ALLOWED else ()
            yield from (f"{node.module}.{a.name}" for a in node.names if a.name not in public)


def test_all_plugins_are_looked_at() -> None:
    assert len({path.relative_to(PLUGINS).parts[0] for path in MODULES}) == len(list(PLUGINS.glob("*/pyproject.toml")))


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.relative_to(PLUGINS).as_posix())
def test_a_plugin_imports_what_is_public(path: Path) -> None:
    assert list(private_imports(path.read_text("utf-8"))) == []


@pytest.mark.parametrize("number", range(len(blocks("python"))))
def test_the_page_shows_what_is_public(number: int) -> None:
    text = blocks("python")[number]
    assert list(private_imports(text)) == []
    assert "from mcsl_core.hooks import" in text


@pytest.mark.parametrize(
    "text",
    [
        "from mcsl_core.edl import Shot",
        "def f():\n    import mcsl_core.edl",
        "from mcsl_core import edl",
        "from mcsl_core.hooks import registry",
        "from mcsl_core.hooks.specs import hookimpl",
    ],
)
def test_what_is_not_public_is_seen(text: str) -> None:
    assert len(list(private_imports(text))) == 1


def test_all_that_the_page_describes_comes_from_the_hooks() -> None:
    reference = PAGE.read_text("utf-8").partition("<!-- Below this line")[2]
    described = set(re.findall(r"^#### (\w+)$", reference, re.MULTILINE))
    assert len(described) > 20
    assert described <= set(mcsl_core.hooks.__all__)


def test_the_page_lists_no_method_that_a_plugin_cannot_call() -> None:
    """What takes or gives a class that the hooks do not have, as a decoder, and what only mcsl's own stages ask."""
    reference = PAGE.read_text("utf-8").partition("<!-- Below this line")[2]
    listed = set(re.findall(r"\w+", "".join(re.findall(r"```python\n(.*?)```", reference, re.DOTALL))))
    assert {"has_gap", "pictures", "planes", "median"} <= listed
    assert not {"Decoder", "DecodedFrame", "Part", "Player", "SoundTrack", "shown_near", "damage_met"} & listed
