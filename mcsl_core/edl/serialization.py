"""Reading and writing EDLs: JSON in and out, upgrades of older schemas, canonical text, atomic saving."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from mcsl_core.documents import (
    canonical_json,
    make_converter,
    parse_json,
    read_json,
    structure_document,
    write_atomic,
)
from mcsl_core.errors import DocumentError

from .outside import check_inside
from .schema import Edl

SCHEMA = "mcsl.edl/2"
_REMEDY = "Hand in the file that `mcsl analyse` wrote"
_converter = make_converter()
# schema -> function from its JSON value to the next schema's
_UPGRADES: dict[str, Callable[[dict[str, Any]], dict[str, Any]]] = {
    "mcsl.edl/1": lambda value: {**value, "schema": "mcsl.edl/2"},  # it had no reliefs: its poses are planes
}


def from_json(value: Any, *, where: str = "") -> Edl:
    """An EDL from its JSON value.

    Parameters
    ----------
    value
        As `json.loads` gives it.
    where
        What messages call the document: its path.

    Raises
    ------
    DocumentError
        With the path to the wrong value and what was expected.
    """
    if not isinstance(value, dict):
        raise DocumentError("an EDL is a JSON object", where=where, remedy=_REMEDY)
    value = dict(value)
    schema = value.get("schema")
    while isinstance(schema, str) and schema in _UPGRADES:
        value = _UPGRADES[schema](value)
        schema = value["schema"]
    if schema != SCHEMA:
        family, _, version = str(schema).partition("/")
        newer = family == "mcsl.edl" and version.isdecimal() and int(version) > int(SCHEMA.partition("/")[2])
        found = f"is {schema!r}" + (", newer than this mcsl" if newer else "") if "schema" in value else "is missing"
        raise DocumentError(
            f"{found}; expected {SCHEMA!r}",
            where=f"{where} at $.schema" if where else "$.schema",
            remedy="Install a newer mcsl" if newer else _REMEDY,
        )
    del value["schema"]
    return structure_document(value, Edl, _converter, where=where, name="the EDL (edl.md)")


def to_json(edl: Edl) -> dict[str, Any]:
    """The JSON value of an EDL, keys in the document's order."""
    return {"schema": SCHEMA, **_converter.unstructure(edl, Edl)}


def dumps(edl: Edl) -> str:
    """Canonical text: the same EDL gives the same bytes."""
    return canonical_json(to_json(edl))


def loads(text: str, *, where: str = "") -> Edl:
    """An EDL from its text; upgrades and checks like `load`."""
    return from_json(parse_json(text, where=where), where=where)


def load(path: str | Path, *, allow_outside: bool = False) -> Edl:
    """Reads, upgrades and checks an EDL.

    Parameters
    ----------
    path
        Its file.
    allow_outside
        Its files may lie outside of its folder though it was not made here; see `outside`. It is remembered.

    Raises
    ------
    InputError
        Where the file cannot be read, or names files where it may not.
    DocumentError
        With the path to the wrong value and what was expected.

    Examples
    --------
    >>> edl = load("edl.json")  # doctest: +SKIP
    >>> edl.frames, [camera.name for camera in edl.cameras]  # doctest: +SKIP
    (178721, ['cam1', 'cam2', 'cam3'])
    """
    edl = read(path)
    check_inside(edl, Path(path), allow=allow_outside)
    return edl


def read(path: str | Path) -> Edl:
    """As `load`, wherever its files lie: for who opens none of them."""
    return from_json(read_json(Path(path), wanted="an EDL", remedy=_REMEDY), where=str(path))


def save(edl: Edl, path: str | Path) -> None:
    """Writes the canonical text atomically: the file is the old one or the new one, never half of it.

    Examples
    --------
    >>> save(attrs.evolve(edl, look=Look(fill=False)), "edl.json")  # doctest: +SKIP
    """
    write_atomic(Path(path), dumps(edl).encode())
