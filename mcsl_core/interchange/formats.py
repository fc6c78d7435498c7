"""The formats of other editors: by what a file's name ends with, how it is written, and how it is read."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

from attrs import frozen

from mcsl_core.errors import UsageError

from .changes import Layout
from .cmx_reading import read_cmx
from .cmx_writing import write_cmx
from .fcpxml_reading import read_fcpxml
from .fcpxml_writing import write_fcpxml
from .found import FoundCut
from .model import Sequence
from .otio_reading import read_otio
from .otio_writing import write_otio
from .xmeml_reading import read_xmeml
from .xmeml_writing import write_xmeml


@frozen
class Format:
    """One of them.

    Attributes
    ----------
    name
        For people.
    layout
        How it holds the angles.
    write
        The document of a cut.
    read
        What stands in a file; the programme's rate is for those that do not say theirs.
    """

    name: str
    layout: Layout
    write: Callable[[Sequence], bytes]
    read: Callable[[Path, Fraction], FoundCut]


FORMATS = {
    ".fcpxml": Format("FCPXML", "multicam", write_fcpxml, lambda path, _: read_fcpxml(path)),
    ".xml": Format("Final Cut Pro 7 XML", "layers", write_xmeml, lambda path, _: read_xmeml(path)),
    ".otio": Format("OpenTimelineIO", "layers", write_otio, lambda path, _: read_otio(path)),
    ".edl": Format("CMX3600", "single", write_cmx, read_cmx),
}
_WITHIN = {".fcpxml": b"<fcpxml", ".xml": b"<xmeml", ".otio": b'"OTIO_SCHEMA"', ".edl": b"TITLE:"}  # near the beginning
_BEGINNING = 4096
READ_ALSO = {".fcpxmld": FORMATS[".fcpxml"]}  # a folder with the document in it


def format_to_write(path: Path) -> Format:
    """The format that ``path`` is called after; UsageError where there is none."""
    found = FORMATS.get(path.suffix.lower())
    if found is None:
        known = ", ".join(f"{suffix} ({form.name})" for suffix, form in FORMATS.items())
        raise UsageError("no editor's format is called so", where=str(path), remedy=f"Let its name end in {known}")
    return found


def format_to_read(path: Path) -> Format | None:
    """The format that ``path`` is called after, or None."""
    return (FORMATS | READ_ALSO).get(path.suffix.lower())


def format_within(path: Path) -> Format | None:
    """The format that a file looks like by its first bytes, whatever it is called; None where it looks like none."""
    try:
        with path.open("rb") as stream:
            begin = stream.read(_BEGINNING)
    except OSError:  # a folder among them
        return None
    return next((FORMATS[suffix] for suffix, word in _WITHIN.items() if word in begin), None)
