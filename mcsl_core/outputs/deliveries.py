"""Which videos in a folder are mcsl's own work: they are no cameras of the recording that they lie beside."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from mcsl_core.errors import McslError

from .manifest import Manifest

_CHUNK = re.compile(r"\d{7,}-\d{7,}-[0-9a-f]+\.\w+")  # simulated recordings have a list of the same name


def own_videos(folders: Iterable[Path]) -> set[Path]:
    """What mcsl delivered or conformed into these folders and those in them, or from documents in them.

    By the lists that lie there and the files' sizes; times change when a folder is copied. Real paths.
    """
    found: set[Path] = set()
    for folder in folders:
        with contextlib.suppress(OSError):
            for path in folder.glob("*.outputs.json"):
                found.update(_listed(Manifest(path)))
            for inside in (folder, *(sub for sub in folder.iterdir() if sub.is_dir())):
                found.update(p for p in _listed(Manifest.inside(inside)) if _CHUNK.fullmatch(p.name))
    return found


def _listed(manifest: Manifest) -> Iterator[Path]:
    with contextlib.suppress(McslError, OSError, ValueError):  # another's list says nothing
        for name in manifest.names():
            path = manifest.path.parent / name
            if path.is_file() and path.stat().st_size in manifest.sizes(name):
                yield Path(os.path.realpath(path))
