# SPDX-License-Identifier: GPL-3.0-or-later
"""Which EDL belongs to a timeline: decisions must never be written into another project's. No bpy.

A timeline notes the way to its EDL, the folder it lay in then, and which recording it was built from. In its folder the
note is followed, unless the EDL is of another recording altogether. Found in another folder (copied, moved, saved
elsewhere) it only takes an EDL that is a true copy of its own, beside it as before: of the same recording, with the
same automatic decisions.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path

from mcsl_core.edl import Camera, Edl
from mcsl_core.errors import InputError

from .strip_plan import automatic_cameras, automatic_to_text

Facts = Mapping[str, tuple[str, str]]  # of each camera: its files' lengths, and a hash of their content


def home_of(folder: Path) -> str:
    """A folder as a timeline notes it: by a hash, since a path may hold a name."""
    path = str(folder.resolve())  # a name that is not UTF-8 reaches Python as lone surrogates
    return hashlib.sha256(path.encode("utf-8", "surrogatepass")).hexdigest()[:16]


def facts_of(edl: Edl) -> Facts:
    """What tells one recording from another."""
    return {camera.name: _facts(camera) for camera in edl.cameras}


def _facts(camera: Camera) -> tuple[str, str]:
    prints = [media.fingerprint for media in camera.media]
    content = hashlib.sha256(json.dumps(prints).encode()).hexdigest()[:16] if all(prints) else ""
    return "+".join(str(media.frames) for media in camera.media), content


def facts_to_text(facts: Facts) -> str:
    """For the scene."""
    return json.dumps(facts, ensure_ascii=False)


def facts_from_text(text: str) -> Facts:
    """The inverse of `facts_to_text`; nothing for a text that is not of its making."""
    try:
        return {str(name): (str(lengths), str(content)) for name, (lengths, content) in json.loads(text).items()}
    except (ValueError, TypeError, AttributeError):
        return {}


def candidates(noted: str, folder: Path, *, home: str) -> tuple[Path, ...]:
    """Where the EDL of a timeline in ``folder`` may lie, the likeliest first.

    Parameters
    ----------
    noted
        The way to it as the timeline has it: // and the way from its folder, or a whole path.
    folder
        Where the timeline lies now.
    home
        Where it lay when that was noted (`home_of`); '' where it does not say: it is an older one.
    """
    if noted.startswith("//") or not Path(noted).is_absolute():
        return (folder / noted.removeprefix("//"),)
    whole = Path(noted)
    beside = folder / whole.name
    if home == home_of(folder) or whole.parent.resolve() == folder.resolve():
        return (whole,)
    return (beside,) if home else (beside, whole)


def check_belongs(edl: Edl, path: Path, noted: Facts, *, automatic: str, moved: bool) -> None:
    """Refuses an EDL that is not the timeline's own.

    Parameters
    ----------
    edl, path
        What lies where the timeline says its EDL is.
    noted
        The recording it was built from; nothing where it does not say.
    automatic
        The automatic choice it was built from, as its scene has it.
    moved
        Whether it lies elsewhere than when it noted the way to its EDL.

    Raises
    ------
    InputError
        The EDL is of another recording, or, for a timeline that was moved, of another analysis.
    """
    found = facts_of(edl)
    if not moved:
        if noted and not any(_alike(noted[name], facts) for name in noted for facts in found.values()):
            raise InputError("is of another recording than this timeline", where=str(path))
        return
    known = {name: facts for name, facts in noted.items() if name in found}
    if len(known) < len(noted) or any(not _equal(facts, found[name]) for name, facts in known.items()):
        raise InputError("is of another recording than this timeline, which was copied or moved here", where=str(path))
    if automatic and automatic != automatic_to_text(automatic_cameras(edl)):
        raise InputError(
            "has other automatic decisions than this timeline, which was copied or moved here", where=str(path)
        )


def _alike(a: tuple[str, str], b: tuple[str, str]) -> bool:
    """Whether two cameras may be one: repaired files keep their lengths, and files cut otherwise their content."""
    return a[0] == b[0] or (a[1] != "" and a[1] == b[1])


def _equal(a: tuple[str, str], b: tuple[str, str]) -> bool:
    return a[0] == b[0] and (a[1] == b[1] or "" in (a[1], b[1]))
