"""What is going to be written, told beforehand, and refused where the disk has not nearly so much."""

from __future__ import annotations

import shutil
from pathlib import Path

from mcsl_core.errors import McslError
from mcsl_core.progress import Progress

_WORTH_TELLING = 100e6  # bytes


def tell_of_space(what: str, folder: Path, needed: float, seconds: float, progress: Progress) -> None:
    """Notes what will be written to a folder, in all and an hour, and what is free there.

    Parameters
    ----------
    what
        Its name, the note's first words.
    folder
        Where; it need not be there yet.
    needed
        Bytes, estimated.
    seconds
        Of the recording that they stand for.
    progress
        Told where it is 100 MB and more, or more than is free.

    Raises
    ------
    McslError
        Where less than half of it is free: estimates are not worse than that.
    """
    there = next((path for path in (folder, *folder.absolute().parents) if path.exists()), Path())
    free = shutil.disk_usage(there).free
    takes = f"about {_size(needed)} ({_size(needed / seconds * 3600)} an hour)"
    if needed > 2 * free:
        raise McslError(
            f"{what} would take {takes}, and {_size(free)} are free",
            where=str(folder),
            remedy="Make room, or choose a folder on another disk",
        )
    if needed > free or needed >= _WORTH_TELLING:
        tight = ": it may not be enough" if needed > free else ""
        progress.note(f"{what} will take {takes} in {folder}; {_size(free)} are free{tight}")


def _size(count: float) -> str:
    """In decimal units, as disks are sold."""
    return f"{count / 1e9:.1f} GB" if count >= 1e9 else f"{count / 1e6:.0f} MB"
