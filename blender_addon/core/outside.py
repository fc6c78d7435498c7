# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that a timeline shows beside the recording: told where they are missing, or come from elsewhere. No bpy."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from mcsl_core.edl.playlists import list_kind


def remark_on(what: str, path: str, homes: Iterable[Path]) -> str:
    """What there is to say of a file; '' for one that lies in the project.

    Parameters
    ----------
    what
        Who shows it, for a person.
    path
        Where it lies, whole.
    homes
        The project's folders.
    """
    if not os.path.isabs(path):
        return f"{what} shows {path!r}, which is no file"
    if not os.path.exists(path):
        return f"{what} shows {path}, which is missing"
    if not os.path.isfile(path):
        return f"{what} shows {path}, which is no file"
    if kind := list_kind(Path(path)):
        return f"{what} shows {path}, which is {kind}: what it leads to is not opened"
    real = Path(path).resolve()
    if not any(real.is_relative_to(home.resolve()) for home in homes):
        return f"{what} shows {path}, from outside this project"
    return ""
