"""Every text that the extension shows has its Japanese. Read from the source, so that no state of a panel is missed."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

import blender_addon
from blender_addon.core import presets
from blender_addon.ui.translations.japanese import JAPANESE

ADDON = Path(blender_addon.__file__).parent
NAMES = {"FCPXML", "Final Cut Pro 7 XML", "OpenTimelineIO", "EDL (CMX3600)"}
SAME = NAMES | {"mcsl", "EDL", "X", "Y", "", "H.264", "H.265", "ProRes 422 HQ", "FFV1"}  # the same in every language


def texts_of(tree: ast.Module) -> set[str]:
    """The texts of a module that Blender shows, or hands to a person through `told` and `shown`."""
    found: set[str] = set()

    def text(node: ast.expr | None) -> None:
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            found.add(node.value)
        elif isinstance(node, ast.IfExp):
            text(node.body)
            text(node.orelse)

    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            given = {k.arg: k.value for k in node.keywords}
            if name in ("told", "shown", "poll_message_set") and node.args:
                text(node.args[0])
            shown_as_it_is = isinstance(given.get("translate"), ast.Constant)
            if name in ("label", "operator", "prop", "progress") and not shown_as_it_is:
                text(given.get("text"))
            if name.endswith("Property"):
                text(given.get("name"))
                text(given.get("description"))
                _items(given.get("items"), text)
        elif isinstance(node, ast.ClassDef):
            kinds = {base.attr for base in node.bases if isinstance(base, ast.Attribute)}
            if "Operator" in kinds:
                found.add(ast.get_docstring(node) or "")
            for line in node.body:
                if isinstance(line, ast.Assign) and getattr(line.targets[0], "id", "") == "bl_label":
                    text(line.value)
        elif isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "AIDS":
            _items(node.value, text)
        elif isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "STAGES":
            assert isinstance(node.value, ast.Dict)
            for value in node.value.values:
                text(value)
    return found


def _items(node: ast.expr | None, text) -> None:
    """The names and descriptions of an enum's items."""
    for item in node.elts if isinstance(node, ast.List) else ():
        if isinstance(item, ast.Tuple):
            text(item.elts[1])
            text(item.elts[2])


def all_texts() -> set[str]:
    files = [path for path in ADDON.rglob("*.py") if path.name != "japanese.py"]
    about = {text for preset in presets.load_all().values() for text in (preset.title, preset.description)}
    return (about | {text for path in files for text in texts_of(ast.parse(path.read_text("utf-8")))}) - SAME


def test_every_text_has_its_japanese():
    missing = sorted(all_texts() - JAPANESE.keys())
    assert not missing, "\n".join(["blender_addon/ui/translations/japanese.py lacks:", *missing])


def test_no_japanese_is_left_over():
    assert not JAPANESE.keys() - all_texts()


@pytest.mark.parametrize("english", sorted(JAPANESE))
def test_the_fields_of_a_text_are_kept(english):
    def fields(text: str) -> list[str]:
        return sorted(re.findall(r"\{[^}]*\}", text))

    assert fields(JAPANESE[english]) == fields(english)
    assert re.search(r"[\u3040-\u30ff\u4e00-\u9fff]", JAPANESE[english])


def test_a_text_without_japanese_would_be_seen():
    tree = ast.parse('layout.label(text="Quite new")\nself.report({"INFO"}, told("new too"))')
    assert texts_of(tree) == {"Quite new", "new too"}
