# SPDX-License-Identifier: GPL-3.0-or-later
"""A movie strip that an editor worked on is given another file, and keeps all that he did to it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .build import check_readable
from .compat import content_start, ends, set_content_start, set_ends
from .edit import check_there, parked
from .scene_properties import note_placed


def link_film(scene: Any, strip: Any, path: Path, start: int) -> bool:
    """The strip shows ``path``, laid at programme frame ``start``, over the same frames as before.

    Returns False where the file does not reach over all of them. InputError or BlenderError where it is missing or
    cannot be shown.
    """
    check_there(path)
    span = ends(strip)
    with parked(scene, strip):
        strip.filepath = str(path)  # keeps the ends
        check_readable(strip, path)
        set_content_start(strip, start)
        set_ends(strip, *span)
    note_placed(strip, start, path.name)
    return start <= span[0] and span[1] <= content_start(strip) + strip.frame_duration
