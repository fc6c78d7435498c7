"""Which operations an archive holds, what its table asks for each, and what each is called where it is worked on."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence, Set
from pathlib import Path

from attrs import frozen

from mcsl_core.documents import canonical_json, make_converter, read_json, structure_document, write_atomic
from mcsl_core.errors import InputError, UsageError
from mcsl_core.hooks.stages import STAGES
from mcsl_core.tables import read_table

SCHEMA = "mcsl.archive/1"
ANALYSIS = ("reference", "rate", "sync", "movement-view", *STAGES)
COLUMNS = (*ANALYSIS, "quality", "preset", "audio", "parts")
_REMEDY = f"Its first line names operation, and any of {', '.join(COLUMNS)}"
_OURS = ("archive.json", "log", "triage.html", "operations.csv", "operations.parquet")  # beside the operations' folders
_LONGEST = 150  # bytes of a name: with what jobs put behind it, it stays below the 255 that file systems take
_converter = make_converter()


@frozen
class Operation:
    """One recording of an archive.

    Attributes
    ----------
    folder : str
        Of its camera files, relative to the archive's, with forward slashes.
    key : str
        What its folder of results is called, and so what logs call it.
    options : mapping of str to str
        Column of the table -> what it says, where it says anything.
    """

    folder: str
    key: str
    options: Mapping[str, str]


@frozen
class Register:
    """What an archive's folder of results is for, and what each operation is called there: it stays from run to run."""

    schema: str
    archive: str
    anonymous: bool
    keys: Mapping[str, str]


def find_operations(
    archive: Path, out: Path, *, table: Path | None, anonymous: bool, write: bool = True
) -> tuple[Operation, ...]:
    """The operations in an archive, in the order of their names.

    Parameters
    ----------
    archive : Path
        Each folder in it is an operation; deeper ones are those that the table names.
    out : Path
        The folder of results. It keeps what each operation is called.
    table : Path, optional
        A table (CSV) with a column ``operation`` and any of `COLUMNS`.
    anonymous : bool
        Whether operations are called by number.
    write : bool
        Whether what they are called is kept.

    Raises
    ------
    UsageError
        Where ``out`` is the archive, or within an operation.
    InputError, DocumentError
        Where the archive holds none, the table is wrong or names what is not there, or ``out`` is another archive's.
    """
    if not archive.is_dir():
        raise InputError(
            "is no folder", where=str(archive), remedy="Name the folder that the operations' folders lie in"
        )
    options = _options(archive, table) if table else {}
    results = out.resolve()
    within = {path.name for path in archive.iterdir() if path.is_dir() and not path.name.startswith(".")}
    above = {folder.partition("/")[0] for folder in options if "/" in folder}
    folders = sorted({f for f in within - above if (archive / f).resolve() != results} | set(options))
    if not folders:
        raise InputError(
            "holds no folders", where=str(archive), remedy="Name the folder that the operations' folders lie in"
        )
    if results == archive.resolve() or any(results.is_relative_to((archive / f).resolve()) for f in folders):
        what = "is where the recordings lie"
        raise UsageError(what, where=str(out), remedy="Choose a folder of its own for the results")
    keys = _registered(archive, out, folders, anonymous, write=write).keys
    return tuple(Operation(folder, keys[folder], options.get(folder, {})) for folder in folders)


def _options(archive: Path, table: Path) -> dict[str, dict[str, str]]:
    read = read_table(table, wanted="a table of operations", remedy=_REMEDY)
    unknown = [name for name in read.columns if name not in ("operation", *COLUMNS)]
    if unknown or "operation" not in read.columns:
        what = f"has a column {unknown[0]!r}" if unknown else "has no column 'operation'"
        raise InputError(what, where=str(table), remedy=_REMEDY)
    options: dict[str, dict[str, str]] = {}
    for row in read:
        at, folder = f"{table}, line {row.line}", row.cells["operation"].replace("\\", "/").strip("/")
        if not folder or ".." in folder.split("/") or not (archive / folder).is_dir():
            raise InputError(f"there is no operation {folder!r}", where=at, remedy=f"Name a folder in {archive}")
        if folder in options:
            raise InputError(f"names {folder!r} a second time", where=at, remedy="Leave one of the lines")
        parts = row.cells.get("parts", "")
        if parts and not re.fullmatch(r"[1-9]\d{0,3}", parts, re.ASCII):
            raise InputError(f"{parts!r} is no number of parts", where=at, remedy="Write a number from 1, or nothing")
        options[folder] = {name: row.cells[name] for name in COLUMNS if row.cells.get(name)}
    return options


def _registered(archive: Path, out: Path, folders: Sequence[str], anonymous: bool, *, write: bool) -> Register:
    """The register of ``out`` with all these folders in it."""
    path, place = out / "archive.json", archive.resolve().as_posix()
    known = Register(SCHEMA, place, anonymous, {})
    if path.exists():
        known = structure_document(read_json(path), Register, _converter, where=str(path), name="archives")
        if (known.schema, known.archive) != (SCHEMA, place):
            raise InputError(f"holds results of {known.archive}", where=str(out), remedy="Choose another folder")
        if known.anonymous != anonymous:
            how = "Add --anonymous" if known.anonymous else "Leave --anonymous out"
            raise UsageError(
                "names operations the other way", where=str(out), remedy=f"{how}, or choose another folder"
            )
    keys, taken = dict(known.keys), {*_OURS, *(key.casefold() for key in known.keys.values())}
    if archive.resolve().parent == out.resolve():
        taken.add(archive.resolve().name.casefold())
    for folder in folders:
        if folder not in keys:
            keys[folder] = f"{len(keys) + 1:06d}" if anonymous else _named(folder, taken)
            taken.add(keys[folder].casefold())
    made = Register(SCHEMA, place, anonymous, keys)
    if write and made != known:
        out.mkdir(parents=True, exist_ok=True)
        write_atomic(
            path, canonical_json(_converter.unstructure(made)).encode("utf-8", "backslashreplace"), private=True
        )
    return made


def _named(folder: str, taken: Set[str]) -> str:
    """A name that no shell, engine or file system reads otherwise, and that no other operation has."""
    key = re.sub(r"[^\w.-]", "_", folder).lstrip(".-") or "_"
    key = os.fsencode(key)[:_LONGEST].decode("utf-8", "ignore")
    name, number = key, 2
    while name.casefold() in taken:
        name, number = f"{key}_{number}", number + 1
    return name
