# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person should know of a timeline before it is conformed, rendered or brought up to date."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.edl import Edl
from mcsl_core.errors import McslError
from mcsl_core.timing import FrameRange, joined, ranges_of_spans, touching, without

from ..core import times
from ..core.field import remarks_on_drawing
from ..core.multicam import muted_over
from ..core.outside import remark_on
from ..core.read_overrides import SequencerState
from ..core.strip_plan import FIRST_CAMERA_CHANNEL
from .compat import ends, strips_of
from .conformed import conformed_strips
from .scene_properties import CAMERA, edl_path, placed_of, role_of
from .touched import Work

_NAMED = 3  # stretches without a shot
_SEEN = ("mute", "name", "color_tag", "effect strip", "lock")  # changes no picture


def notices(scene: Any, edl: Edl, state: SequencerState) -> tuple[str, ...]:
    """Lines for a person: what is kept as it is but may surprise, and what cannot be kept.

    Parameters
    ----------
    scene
        The scene with the timeline.
    edl
        Its EDL.
    state
        The timeline as read.
    """
    said = (*state.notes, *times.remarks(edl, state.scene, state.films), *_of_gaps(edl, state), *_of_strips(scene, edl))
    return (*said, *remarks_on_drawing(edl, state.drawing), *_of_files(scene, edl))


def _of_gaps(edl: Edl, state: SequencerState) -> Iterator[str]:
    """Where no shot lies: the video has the analysis' camera there, but the preview cannot know it."""
    there = ranges_of_spans((strip.start, strip.stop) for strip in state.strips if not strip.muted)
    gaps = without([FrameRange(0, edl.frames)], there)
    muted = muted_over(state.strips, gaps)
    for gap, name in muted[:_NAMED]:
        yield (
            f"frames {gap.start + 1} to {gap.stop} show no shot, because strip {name!r} is muted: the video shows what "
            "the analysis chose, the preview another camera; unmute it, or delete it and press Revert to Automatic"
        )
    if len(muted) > _NAMED:
        yield f"and {len(muted) - _NAMED} more stretches show no shot because it is muted"
    gaps = without(gaps, [gap for gap, _ in muted])
    for gap in gaps[:_NAMED]:
        yield (
            f"frames {gap.start + 1} to {gap.stop} have no shot: the video shows what the analysis chose, the preview "
            "another camera; Revert to Automatic lays the shot again"
        )
    if len(gaps) > _NAMED:
        yield f"and {len(gaps) - _NAMED} more stretches have no shot"


def _of_files(scene: Any, edl: Edl) -> Iterator[str]:
    """The editor's own files and linked libraries that are missing, or not the project's."""
    folder = Path(bpy.data.filepath).parent
    try:
        base = edl_path(scene, Path(bpy.data.filepath)).parent
    except McslError:
        base = folder
    homes = {folder, base, *((base / media.path).parent for camera in edl.cameras for media in camera.media)}
    found = [(f"library {library.name!r}", library.filepath) for library in bpy.data.libraries]
    for strip in scene.sequence_editor.strips_all:
        what = f"strip {strip.name!r}, frame {ends(strip)[0] + 1},"
        if strip.type == "MOVIE" and not role_of(strip):
            found.append((what, strip.filepath))
        elif strip.type == "SOUND" and not role_of(strip) and strip.sound is not None and not strip.sound.packed_file:
            found.append((what, strip.sound.filepath))
        elif strip.type == "IMAGE" and strip.elements:
            found.append((what, os.path.join(strip.directory, strip.elements[0].filename)))
    for what, path in found:
        if text := remark_on(what, bpy.path.abspath(path), homes):
            yield text


def _of_strips(scene: Any, edl: Edl) -> Iterator[str]:
    editor = scene.sequence_editor
    conformed = FIRST_CAMERA_CHANNEL + len(edl.cameras) + 2
    exact = joined(span for strip, span in conformed_strips(scene) if not strip.mute)
    if exact and editor.channels[conformed].mute:
        yield f"channel {conformed}, Conformed, is muted: the preview shows in place of the exact pictures"
    work = Work(scene)
    for strip in strips_of(scene, "MULTICAM"):
        start, stop = ends(strip)
        if not strip.mute and not touching(exact, start, stop):
            continue
        if not (done := [what for what in work.on(strip) if what not in _SEEN]):
            continue
        where = f"strip {strip.name!r}, frame {start + 1}"
        if strip.mute:
            yield f"{where} is muted and decides nothing: your work on it ({done[0]}) goes with the next rebuild"
        else:
            yield f"{where}: your work on it ({done[0]}) is hidden by the exact pictures; do it on those, or above"
    for strip in strips_of(scene, "MOVIE"):
        where = f"strip {strip.name!r}, frame {ends(strip)[0] + 1}"
        placed = placed_of(strip) if role_of(strip) in ("camera", "conformed") else None
        if placed is not None and not strip.filepath.replace("\\", "/").endswith(placed[1]):
            yield f"{where} shows {strip.filepath}, not {placed[1]} as it was built"
        if role_of(strip) == "camera" and edl_lacks(edl, strip) and any(w != "mute" for w in work.on(strip)):
            yield f"{where}: its camera is not in the EDL any more, so your work on it goes with the next rebuild"


def edl_lacks(edl: Edl, strip: Any) -> bool:
    """Whether the camera whose file the strip plays is gone from the EDL."""
    return strip.get(CAMERA) not in {camera.name for camera in edl.cameras}
