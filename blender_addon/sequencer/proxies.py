# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own proxies of the camera files: pictures of half the size for smooth playback, beside the .blend.

They are shown in the preview alone; what is rendered or conformed is made from the files themselves.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import bpy  # pyright: ignore[reportMissingImports]

from .compat import selected_strips, strips_of
from .scene_properties import CAMERA, PROXIES, role_of

FOLDER = "//BL_proxy"  # as Blender calls it
SIZE = "PROXY_50"  # of the preview, as `SpaceSequenceEditor.proxy_render_size` has it


def attach(scene: Any) -> list[Any]:
    """Every camera strip takes its pictures from its file's proxy where there is one; one strip of each file.

    Each file's has a folder of its own: cameras may call their files the same, and a file that was exchanged is
    another.
    """
    first: dict[str, Any] = {}
    for strip in strips_of(scene, "MOVIE"):
        if role_of(strip) != "camera":
            continue
        strip.use_proxy = True
        proxy = strip.proxy
        proxy.use_proxy_custom_directory, proxy.directory = True, _folder_of(strip)
        proxy.build_25, proxy.build_50, proxy.build_75, proxy.build_100 = False, True, False, False
        proxy.use_overwrite = False
        if hasattr(proxy, "timecode"):
            proxy.timecode, proxy.build_record_run = "NONE", False  # frames are counted as without proxies
        first.setdefault(proxy.directory, strip)
    scene[PROXIES] = True
    return list(first.values())


def attach_again(scene: Any) -> None:
    """Camera strips that were made anew take the proxies that were built; where none were, nothing happens."""
    if scene.get(PROXIES):
        attach(scene)


def _folder_of(strip: Any) -> str:
    path = Path(bpy.path.abspath(strip.filepath))
    state = path.stat() if path.is_file() else None
    facts = [path.name, *([] if state is None else [state.st_size, state.st_mtime_ns])]
    mark = hashlib.sha256(repr(facts).encode()).hexdigest()[:8]
    name = re.sub(r"\W", "_", str(strip.get(CAMERA, "")))
    return f"{FOLDER}/{name}-{mark}"


@contextmanager
def selected(scene: Any, strips: list[Any]) -> Iterator[None]:
    """These strips alone are selected meanwhile: Blender builds the proxies of what is."""
    before = selected_strips(scene)
    for strip in before:
        strip.select = False
    for strip in strips:
        strip.select = True
    try:
        yield
    finally:
        for strip in strips:
            strip.select = False
        for strip in before:
            strip.select = True


def show(window_manager: Any) -> None:
    """Every preview draws the proxies."""
    for window in window_manager.windows:
        for area in window.screen.areas:
            if area.type == "SEQUENCE_EDITOR":
                space = area.spaces.active
                space.use_proxies, space.proxy_render_size = True, SIZE
