"""What a person should know of which hardware decodes a recording."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from mcsl_core.media.decoders import strict_decoder
from mcsl_core.media.hardware import NONE
from mcsl_core.media.opening import is_accelerated, main_video, open_file
from mcsl_core.progress import Progress, counted


def tell_of_hardware(hwaccel: str, files: Iterable[tuple[Path, Any]], progress: Progress) -> None:
    """A note where hardware was asked for, and which files the processor decodes all the same.

    Parameters
    ----------
    hwaccel
        What was asked for.
    files
        The recording's, as `changed_media.media_files` has them.
    progress
        Where it is told.
    """
    if hwaccel == NONE:
        return
    paths = [path for path, _ in files]
    left = [path.name for path in paths if not _is_decoded_by(hwaccel, path)]
    if left:
        which = "no file" if len(left) == len(paths) else f"all but {', '.join(left)}"
        progress.note(f"hardware ({hwaccel}) decodes {which}; the processor decodes {counted(len(left), 'files')}")


def _is_decoded_by(hwaccel: str, path: Path) -> bool:
    with open_file(path, hwaccel=hwaccel) as container:
        stream = main_video(container, path)
        return is_accelerated(stream) and strict_decoder(stream) is stream.codec_context
