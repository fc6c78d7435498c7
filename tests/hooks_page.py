"""The plugins that docs/hooks.md shows, as they stand there: for the contract suite, and to be installed."""

from __future__ import annotations

import re
import types
from pathlib import Path

PAGE = Path(__file__).parents[1] / "docs" / "hooks.md"


def blocks(language: str) -> list[str]:
    """The code blocks of one language above the generated reference, in order."""
    above = PAGE.read_text("utf-8").partition("<!-- Below this line")[0]
    return re.findall(rf"```{language}\n(.*?)```", above, re.DOTALL)


def shown_plugins() -> list[tuple[types.ModuleType, str, str]]:
    """The page's modules, each as `plugins.discover` takes them."""
    found = []
    for number, text in enumerate(blocks("python")):
        module = types.ModuleType(f"shown_{number}")
        exec(compile(text, f"docs/hooks.md, block {number + 1}", "exec"), module.__dict__)
        found.append((module, "docs/hooks.md", str(number + 1)))
    return found


def write_package(folder: Path) -> None:
    """What the page's chapter "A plugin from nothing" says, word by word: two files in ``folder``."""
    (folder / "pyproject.toml").write_text(blocks("toml")[0], "utf-8")
    (folder / "own_past.py").write_text(blocks("python")[0], "utf-8")
