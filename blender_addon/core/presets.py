# SPDX-License-Identifier: GPL-3.0-or-later
"""The render presets as the panel offers them. No bpy. mcsl_core/delivery/presets.py checks the files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from mcsl_core.delivery.presets import Preset, load_preset


def folder() -> Path:
    """Where the presets lie: inside the extension, else beside the add-on, as in the source tree."""
    addon = Path(__file__).resolve().parents[1]
    inside = addon / "render_presets"
    return inside if inside.is_dir() else addon.parent / "render_presets"


def load_all() -> Mapping[str, Preset]:
    """Every preset by its name, the everyday one first."""
    paths = sorted(folder().glob("*.json"), key=lambda path: (path.stem != "h264", path.stem))
    return {path.stem: load_preset(path) for path in paths}
