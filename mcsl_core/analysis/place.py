"""Where an analysis writes: the EDL with its scores and kept results, safe from other runs and from its own inputs."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from pathlib import Path

from attrs import frozen

from mcsl_core import edl
from mcsl_core.errors import InputError
from mcsl_core.outputs import locks
from mcsl_core.outputs.claim import claim, claim_folder
from mcsl_core.outputs.manifest import State, state_of
from mcsl_core.recording.discovery import SUFFIXES
from mcsl_core.temporary import sweep

from .measurements import load_measurements


def cache_folder(out: Path) -> Path:
    """Where the results of the stages lie: beside the EDL ``out``. It may be deleted at any time."""
    return out.with_name(f"{out.stem}.cache")


@frozen
class EdlPlace:
    """An EDL's file that an analysis may write, with the EDL that lay there before.

    Parameters
    ----------
    path
        The EDL.
    before
        What lay there when the analysis began; None for nothing, or what ``force`` replaces.
    state
        The file as it was then.
    force
        Replace something else than an EDL.
    """

    path: Path
    before: edl.Edl | None
    state: State | None
    force: bool

    @classmethod
    def claimed(cls, path: Path, recording: Sequence[Path], gaze: Sequence[Path], *, force: bool) -> EdlPlace:
        """The place, checked before any work; InputError where it may not be written."""
        inputs = [*_files_of(recording), *gaze]
        claim(path, inputs=inputs, force=True)  # an EDL is known by being one, so that those of any origin are kept
        state = state_of(path)  # asked before it is read: what is written meanwhile is then read again
        before = _existing(path, force)
        place = cls(path, before, state, force)
        known = before is not None and before.scores == place.scores.name
        claim(place.scores, inputs=inputs, force=force or known or _is_scores(place.scores))
        cache = cache_folder(path)
        claim_folder(cache)
        sweep(cache)
        return place

    @property
    def scores(self) -> Path:
        """Where what was measured along the recording lies."""
        return self.path.with_name(f"{self.path.stem}.scores.npz")

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """No other analysis writes here meanwhile; InputError, naming its process, where one is at it already."""
        self.path.parent.mkdir(parents=True, exist_ok=True)  # media paths lead through it
        with locks.alone(self.path, "analysis"):
            yield

    @contextlib.contextmanager
    def changing(self) -> Iterator[edl.Edl | None]:
        """Gives the EDL as it is now, while nobody else writes it: decisions taken since the start are in it."""
        with locks.changing(self.path):
            unchanged = state_of(self.path) in (self.state, None)  # or deleted meanwhile
            yield self.before if unchanged else _existing(self.path, self.force)


def _existing(path: Path, force: bool) -> edl.Edl | None:
    if not path.exists():
        return None
    try:
        return edl.read(path)
    except InputError as error:
        if force:
            return None
        raise InputError(
            f"is there already, and is no EDL that can be read ({error.what})",
            where=error.where or str(path),
            remedy="Choose another name, correct it, or add --force to replace it",
        ) from error


def _files_of(recording: Sequence[Path]) -> Iterator[Path]:
    """What may be a camera's file: those named, and in folders what discovery looks at."""
    for path in recording:
        yield path
        if path.is_dir():
            inside = (*path.glob("*"), *path.glob("*/*"))
            yield from (file for file in inside if file.suffix.lower() in SUFFIXES)


def _is_scores(path: Path) -> bool:
    try:
        load_measurements(path)
    except InputError:
        return False
    return True
