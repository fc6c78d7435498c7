"""A place for an output: checked before any work is done, filled whole or not at all."""

from __future__ import annotations

import contextlib
import os
import shutil
import stat
from collections.abc import Callable, Iterable, Iterator
from itertools import count
from pathlib import Path

from attrs import frozen

from mcsl_core.documents import write_atomic
from mcsl_core.errors import InputError, McslError, writing
from mcsl_core.temporary import sweep, temporary_beside

from .manifest import Manifest, State, state_of


@frozen
class Output:
    """A file that a run may write; see `claim`."""

    path: Path
    manifest: Manifest | None
    force: bool
    before: State | None

    @contextlib.contextmanager
    def writing(self) -> Iterator[Path]:
        """Gives a hidden name beside the file's own to write to; the file takes its name on a clean exit.

        Until then the one that was there stays. On an exception nothing is left.
        """
        real = Path(os.path.realpath(self.path))  # a link keeps pointing at what it names
        part = temporary_beside(real, real.suffix if len(real.suffix) < 9 else "")
        with writing(self.path):
            real.parent.mkdir(parents=True, exist_ok=True)
        try:
            with self._by_its_name(part):
                yield part
            if self.before != state_of(real):
                _check_ours(self.path, real, self.manifest, self.force)  # somebody wrote it meanwhile
            with writing(self.path):
                self._remember(Manifest.expect, real, part)
                part.replace(real)
                self._remember(Manifest.record, real)
        finally:
            with contextlib.suppress(OSError):
                part.unlink(missing_ok=True)

    @contextlib.contextmanager
    def _by_its_name(self, part: Path) -> Iterator[None]:
        """Errors name the file that a person asked for."""
        try:
            yield
        except McslError as error:
            error.where = error.where.replace(str(part), str(self.path))
            error.args = (error.what, error.where, error.remedy)
            raise

    def keep_backup(self) -> None:
        """Copies a file that is not ours under the next of Blender's names for it: edit.blend1, edit.blend2, ..."""
        real = Path(os.path.realpath(self.path))
        if real.is_file() and not (self.manifest is not None and self.manifest.knows(real)):
            names = (real.with_name(f"{real.name}{number}") for number in count(1))
            with writing(self.path):
                shutil.copy2(real, next(name for name in names if not os.path.lexists(name)))

    def _remember(self, how: Callable[..., None], *paths: Path) -> None:
        # An EDL in a folder that cannot be written to: the next run asks for --force.
        if self.manifest is not None:
            with contextlib.suppress(McslError):
                how(self.manifest, *paths)

    def write(self, data: bytes) -> None:
        """The whole content at once."""
        with self.writing() as part:
            write_atomic(part, data)


def claim(path: Path, *, inputs: Iterable[Path] = (), manifest: Manifest | None = None, force: bool = False) -> Output:
    """The right to write ``path``, or InputError with the reason why not.

    Parameters
    ----------
    path
        The file to be written.
    inputs
        What the run reads: never written, by whatever name (links, letter case, relative ways), forced or not.
    manifest
        Knows what mcsl wrote; that may be replaced.
    force
        Replace a file that mcsl did not write, or that was changed since.

    Raises
    ------
    InputError
        It is an input, a folder, no ordinary file, there already and not ours, or its folder cannot be written to.
    """
    real = check_place(path)
    for given in inputs:
        if is_same_file(path, given):
            name = "" if str(given) == str(path) else f" ({given})"
            what = f"is what this run reads{name}, and is never written over"
            raise InputError(what, where=str(path), remedy="Choose another name for the output")
    if real.is_dir():
        raise InputError("is a folder", where=str(path), remedy="Name a file in it")
    if real.exists() and not real.is_file():
        raise InputError("is no ordinary file", where=str(path), remedy="Choose another name for the output")
    if manifest is not None:
        manifest.check()
    _check_ours(path, real, manifest, force)
    _check_folder(path, real.parent)
    sweep(real.parent)
    return Output(path, manifest, force, state_of(real))


def claim_folder(path: Path) -> None:
    """Checks that ``path`` is a folder that can be written to, or can be made one. InputError where not."""
    real = check_place(path)
    if os.path.lexists(real) and not real.is_dir():
        raise InputError("is not a folder", where=str(path), remedy="Choose another folder")
    _check_folder(path, real)
    if real.is_dir():
        sweep(real)


def check_place(path: Path) -> Path:
    """The real path, where a file can be called so at all."""
    if "\0" in str(path):
        shown = str(path).replace("\0", "\\0")
        raise InputError("a file's name cannot hold a NUL character", where=shown, remedy="Choose another name")
    try:
        real = Path(os.path.realpath(path))
        with contextlib.suppress(FileNotFoundError):
            real.lstat()
        return real
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or str(error)
        shown = str(path) if len(str(path)) < 300 else f"{str(path)[:300]}..."
        raise InputError(f"cannot be written ({why})", where=shown, remedy="Choose another name") from error


def is_same_file(one: Path, other: Path) -> bool:
    """Whether two names mean one file: by the file itself where it is there, else by the way to it."""
    try:
        return os.path.samefile(one, other)
    except (OSError, ValueError):
        pass
    try:
        return os.path.normcase(os.path.realpath(one)) == os.path.normcase(os.path.realpath(other))
    except (OSError, ValueError):
        return False


def _check_ours(path: Path, real: Path, manifest: Manifest | None, force: bool) -> None:
    if force or not real.exists():
        return
    if not real.stat().st_mode & (stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH):
        raise InputError("is write-protected", where=str(path), remedy="Choose another name, or add --force")
    if manifest is None or not manifest.knows(real):
        raise InputError(
            "is there already, and not as mcsl wrote it",
            where=str(path),
            remedy="Choose another name, or add --force to replace it",
        )


def _check_folder(path: Path, folder: Path) -> None:
    """Whether a file can be made in ``folder``, or in what has to be made of it."""
    there = folder
    while not os.path.lexists(there) and there != there.parent:
        there = there.parent
    if not there.is_dir():
        raise InputError(f"cannot be written ({there} is not a folder)", where=str(path), remedy="Choose another place")
    with writing(path):  # permissions do not tell it on network drives, on Windows and to root
        trial = temporary_beside(there / "trial")
        trial.touch(exist_ok=False)
        trial.unlink()
