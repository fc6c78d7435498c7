"""What mcsl wrote, remembered beside the document it was made from, so that it may be replaced and nothing else.

Delivered files hold nothing about their making, so it stands here: name, size and time of change of each. A file that
somebody edited or replaced since is no longer ours.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from attrs import frozen

from mcsl_core.documents import canonical_json, read_json, write_atomic
from mcsl_core.errors import InputError, McslError

from . import locks

SCHEMA = "mcsl.outputs/1"
State = tuple[int, int]  # size, time of change in ns


def state_of(path: Path) -> State | None:
    """What tells one content of a file from another without reading it; None where there is none."""
    try:
        found = path.stat()
    except (OSError, ValueError):
        return None
    return found.st_size, found.st_mtime_ns


@frozen
class Manifest:
    """A list of files in JSON.

    Parameters
    ----------
    path
        Where it lies.
    """

    path: Path

    @classmethod
    def beside(cls, document: Path) -> Manifest:
        """Of what was made from a document: edl.json -> edl.outputs.json."""
        return cls(document.with_name(f"{document.stem}.outputs.json"))

    @classmethod
    def inside(cls, folder: Path) -> Manifest:
        """Of a folder's files."""
        return cls(folder / "mcsl-outputs.json")

    def check(self) -> None:
        """InputError where something else lies under its name."""
        self._read()

    @property
    def exists(self) -> bool:
        return self.path.is_file()

    def names(self) -> set[str]:
        """The files as they are listed: relative to its folder where they lie in it."""
        return set(self._read())

    def sizes(self, name: str) -> set[int]:
        """Of what was written under a listed name."""
        return {
            state[0]
            for state in self._read().get(name, [])
            if isinstance(state, list) and state and isinstance(state[0], int)
        }

    def knows(self, path: Path, state: State | None = None) -> bool:
        """Whether the file is as it was when mcsl wrote it. state: how it was a while ago, in place of now."""
        state = state or state_of(path)
        return state is not None and list(state) in self._read().get(self._key(path), [])

    def expect(self, path: Path, part: Path) -> None:
        """``part`` is about to become ``path``: both states are ours until `record` says which it is.

        So that a run which is killed between the two steps leaves nothing that the next one takes for another's.
        """
        state = state_of(part)
        if state is not None:
            self._change({path: [*self._read().get(self._key(path), []), list(state)]})

    def record(self, *paths: Path) -> None:
        """These are ours as they are now."""
        self._change({path: [list(state)] for path in paths if (state := state_of(path)) is not None})

    def _change(self, states: dict[Path, list[list[int]]]) -> None:
        with locks.changing(self.path):
            listed = {name: known for name, known in self._read().items() if (self.path.parent / name).exists()}
            listed |= {self._key(path): known for path, known in states.items()}
            text = canonical_json({"schema": SCHEMA, "files": dict(sorted(listed.items()))})
            write_atomic(self.path, text.encode())

    def _key(self, path: Path) -> str:
        # The folder's own name is no matter: it may be moved with all that is in it.
        real, folder = os.path.realpath(path), os.path.realpath(self.path.parent)
        return Path(real).relative_to(folder).as_posix() if Path(real).is_relative_to(folder) else Path(real).as_posix()

    def _read(self) -> dict[str, list[Any]]:
        if not os.path.lexists(self.path):
            return {}
        try:
            value = read_json(self.path)
        except McslError as error:
            raise self._foreign(error.what) from error
        files = value.get("files") if isinstance(value, dict) and value.get("schema") == SCHEMA else None
        if not isinstance(files, dict) or not all(isinstance(known, list) for known in files.values()):
            raise self._foreign("another content")
        return files

    def _foreign(self, why: str) -> InputError:
        return InputError(
            f"is not mcsl's list of what it wrote ({why})", where=str(self.path), remedy="Move it away, then try again"
        )
