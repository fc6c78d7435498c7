"""Where Blender's preview differs from the conformed pictures: camera files that it does not show as players do."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

from mcsl_core.edl import Edl
from mcsl_core.errors import McslError
from mcsl_core.media.probing import conversions_of


def preview_notes(edl: Edl, base: Path) -> Iterator[str]:
    """A line for each camera and kind of file, such as interlaced ones; files that cannot be read are told elsewhere.

    Mirrored ones are told by who lays them in Blender, which sees them itself.

    Parameters
    ----------
    edl, base
        The EDL, and the folder its paths are relative to.
    """
    for camera in edl.cameras:
        files: dict[str, list[str]] = {}
        for media in camera.media:
            with contextlib.suppress(McslError, OSError):
                for done in conversions_of(base / media.path):
                    files.setdefault(done, []).append(media.path)
        for done, paths in files.items():
            if what := _told(done):
                more = f" and {len(paths) - 1} more" if len(paths) > 1 else ""
                yield f"{camera.name}: {paths[0]}{more}: {what}"


def _told(conversion: str) -> str:
    if conversion == "mirrored":
        return ""
    if conversion.startswith("deinterlaced"):
        return "interlaced; Blender's preview shows combs where things move, conformed pictures are deinterlaced"
    return (
        f"colours in {conversion}; Blender's preview may show others, conformed pictures are converted to BT.709. "
        "Grade those"
    )
