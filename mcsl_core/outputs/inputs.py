"""What a run on an EDL reads, so that it is never written over."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from mcsl_core.edl import Edl

from .manifest import Manifest


def inputs_of(edl: Edl, path: Path) -> Iterator[Path]:
    """The EDL at ``path``, the list of what was made from it, its scores, and every camera file."""
    yield path
    yield Manifest.beside(path).path
    if edl.scores is not None:
        yield path.parent / edl.scores
    for camera in edl.cameras:
        for media in camera.media:
            yield path.parent / media.path
