# SPDX-License-Identifier: GPL-3.0-or-later
"""The names of custom properties, which saved .blend files hold, stand once: in sequencer/scene_properties.py."""

from __future__ import annotations

import ast
from collections import Counter
from pathlib import Path

import pytest

import blender_addon

ADDON = Path(blender_addon.__file__).parent
HOME = ADDON / "sequencer" / "scene_properties.py"
SAVED = {  # in .blend files that editors have: never to be renamed
    "mcsl",
    "mcsl_automatic",
    "mcsl_camera",
    "mcsl_cameras",
    "mcsl_centered",
    "mcsl_centering",
    "mcsl_colour",
    "mcsl_conformed_for",
    "mcsl_delivered",
    "mcsl_drawn_fields",
    "mcsl_drawn_upon",
    "mcsl_edl",
    "mcsl_fallen",
    "mcsl_fill",
    "mcsl_followed_for",
    "mcsl_follows",
    "mcsl_id",
    "mcsl_home",
    "mcsl_keys",
    "mcsl_look_centering",
    "mcsl_look_colour",
    "mcsl_look_fill",
    "mcsl_look_see_through",
    "mcsl_look_surface",
    "mcsl_name",
    "mcsl_offset",
    "mcsl_overrides",
    "mcsl_placed",
    "mcsl_planned",
    "mcsl_proxies",
    "mcsl_removed_upon",
    "mcsl_recording",
    "mcsl_see_through",
    "mcsl_silent",
    "mcsl_sound",
    "mcsl_sound_from",
    "mcsl_sound_of",
    "mcsl_surface",
    "mcsl_tag",
    "mcsl_tracks",
}


def names_in(source: str) -> list[str]:
    """Property names that a source text spells out: mcsl_*, whole or begun in an f-string, and `mcsl` as a key."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and node.value in {*SAVED, "mcsl_"} - {"mcsl"}:
            found.append(node.value)
        keys = []
        if isinstance(node, ast.Subscript):
            keys = [node.slice]
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in ("get", "pop"):
            keys = node.args[:1]
        found += [key.value for key in keys if isinstance(key, ast.Constant) and key.value == "mcsl"]
    return found


def test_the_names_stand_once_and_are_those_of_saved_files():
    source = HOME.read_text("utf-8")
    assigned = [
        node.value
        for statement in ast.parse(source).body
        if isinstance(statement, ast.Assign)
        for node in ast.walk(statement.value)
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.split("_")[0] == "mcsl"
    ]
    assert sorted(assigned) == sorted(SAVED)
    assert Counter(names_in(source)) == Counter(SAVED - {"mcsl"}), "its functions use the constants too"


@pytest.mark.parametrize("path", [p for p in sorted(ADDON.rglob("*.py")) if p != HOME], ids=lambda p: p.stem)
def test_no_other_module_spells_them_out(path):
    assert not names_in(path.read_text("utf-8")), "take the constant from sequencer/scene_properties.py"


def test_the_guard_sees_each_way_of_spelling_one():
    source = 's["mcsl_edl"]; s.get("mcsl"); s.pop(f"mcsl_{aid}", None); s["mcsl"] = 1'
    assert sorted(names_in(source)) == ["mcsl", "mcsl", "mcsl_", "mcsl_edl"]
