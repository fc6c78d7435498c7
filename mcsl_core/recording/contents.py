"""The content keys of many files, told while they are read."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mcsl_core.media.fingerprint import fingerprint
from mcsl_core.progress import Progress

_MIB = 1 << 20


def read_contents(files: Sequence[tuple[Path, str]], progress: Progress) -> list[str]:
    """The content keys of files, which are read where they have not been yet in the state they are in.

    Parameters
    ----------
    files
        Each with a key made earlier, or "": the answer is of the same kind (`fingerprint`).
    progress
        Told of what has been read.

    Raises
    ------
    InputError
        Where one cannot be read.
    """
    sizes = [path.stat().st_size if path.is_file() else 0 for path, _ in files]
    progress.stage("Reading the files", sum(sizes) // _MIB, "MiB")
    keys, before = [], 0
    for (path, like), size in zip(files, sizes, strict=True):
        keys.append(
            fingerprint(path, like=like, told=lambda done, before=before: progress.advance((before + done) // _MIB))
        )
        before += size
    progress.advance(before // _MIB)
    return keys
