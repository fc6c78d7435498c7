# SPDX-License-Identifier: GPL-3.0-or-later
"""The render presets as the panel offers them. No bpy. mcsl_core/presets.py holds the schema and checks the files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from attrs import frozen

from mcsl_core.documents import read_json


@frozen
class Delivery:
    """One preset. blender: what output.apply takes."""

    name: str
    title: str
    description: str
    container: str
    blender: dict[str, Any]


def folder() -> Path:
    """Where the presets lie: inside the extension, else beside it in the source tree."""
    addon = Path(__file__).resolve().parents[1]
    inside = addon / "render_presets"
    return inside if inside.is_dir() else addon.parent / "render_presets"


def load_all() -> tuple[Delivery, ...]:
    """Every preset, the everyday one first."""
    found = []
    for path in sorted(folder().glob("*.json")):
        value = read_json(path)
        blender = {**value["blender"], "scale_percent": value["scale_percent"]}
        found.append(Delivery(path.stem, value["title"], value["description"], value["container"], blender))
    return tuple(sorted(found, key=lambda delivery: delivery.name != "h264"))
