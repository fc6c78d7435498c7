"""Whether a programme's media are still those that were analysed: else its pictures may lie in the wrong place."""

from __future__ import annotations

from pathlib import Path

from mcsl_core.edl import Edl
from mcsl_core.edl.dependencies import views_of
from mcsl_core.edl.resolve import resolve_by_pose
from mcsl_core.media.fingerprint import fingerprint
from mcsl_core.progress import Progress


def media_files(edl: Edl, base: Path) -> list[tuple[Path, str]]:
    """The media that are there, with their keys in the EDL."""
    files = [(base / media.path, media.fingerprint) for camera in edl.cameras for media in camera.media]
    return [(path, key) for path, key in files if path.is_file()]


def tell_of_changed_media(edl: Edl, base: Path, progress: Progress) -> None:
    """A note for every file that the programme shows something of, and that is there and another one now."""
    needed = {
        view.camera.name
        for _, decision, number in resolve_by_pose(edl)
        for view in views_of(edl, edl.poses[number], decision)
    }
    for camera in (camera for camera in edl.cameras if camera.name in needed):
        for media in camera.media:
            path, known = base / media.path, media.fingerprint
            if known and path.is_file() and known != fingerprint(path, like=known):
                progress.note(f"{media.path} of {camera.name} has changed since the analysis")
