"""What mcsl and Blender say to each other: values that are checked where they are made and where they are read.

mcsl starts a Blender for a task (`child`, `blender_addon/worker`): a request one way, progress and one answer back.
The extension starts mcsl for a job (`blender_addon/process/job.py`) and reads what ``--progress json`` writes. Both
sides load this module, Blender's Python with attrs and cattrs alone.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, Generic, TypeVar

import attrs
from attrs import field, frozen

from mcsl_core.delivery.presets import Preset
from mcsl_core.documents import Bounds, doc, make_converter, structure_document
from mcsl_core.edl import Correction, DrawnField, Look, Override
from mcsl_core.errors import DocumentError, Fault
from mcsl_core.timing import FrameRange

T = TypeVar("T")
Answer = TypeVar("Answer")

_COUNT = Bounds(low=0)


def _absolute(_instance: Any, attribute: attrs.Attribute[Any], value: Path | None) -> None:
    """Validator: the other process has a working directory of its own."""
    if value is not None and not value.is_absolute():
        raise Fault(f"must be an absolute path, got {str(value)!r}", f".{attribute.name}")


# ------------------------------------------------------------------------------------------------------------ tasks


@frozen
class ConformedPiece:
    """A file of exact programme pictures and the programme frames it shows."""

    range: FrameRange
    path: Path = field(metadata=doc("absolute, or relative to the EDL's folder"))


@frozen
class BuiltTimeline:
    """Answer to `TimelineRequest` and `RefreshRequest`."""

    blend: Path = field(validator=_absolute, metadata=doc("the file that was saved"))
    strips: int = field(validator=_COUNT, metadata=doc("shots on the Programme channel"))
    frames: int = field(validator=_COUNT, metadata=doc("length of the programme"))
    conformed: int = field(validator=_COUNT, metadata=doc("files of exact pictures that were put in place"))


@frozen
class ReadDecisions:
    """Answer to `ReadRequest`: what the editor decided, as the EDL is to have it."""

    edl: Path = field(validator=_absolute, metadata=doc("the EDL that the timeline was built from"))
    overrides: tuple[Override, ...]
    corrections: tuple[Correction, ...]
    look: Look
    drawn_fields: tuple[DrawnField, ...]
    removed: tuple[FrameRange, ...]
    audio_from: str | None
    changed: bool = field(metadata=doc("whether any of these differs from the EDL"))


@frozen
class RenderedVideo:
    """Answer to `RenderRequest`."""

    output: Path = field(validator=_absolute, metadata=doc("the video"))
    frames: int = field(validator=_COUNT, metadata=doc("frames written"))


@frozen
class Request(Generic[Answer]):
    """What a task of the child process takes. task: its name; answer: the class of what it answers."""

    task: ClassVar[str]
    answer: ClassVar[type[Any]]

    blend: Path = field(validator=_absolute, metadata=doc("the timeline's file"))


@frozen
class _FromEdl(Request[BuiltTimeline]):
    answer = BuiltTimeline

    edl: Path = field(validator=_absolute, metadata=doc("the EDL to build from"))
    conformed: tuple[ConformedPiece, ...] = field(metadata=doc("exact pictures to put in place"))
    sound: Path | None = field(validator=_absolute, metadata=doc("conformed; null: the reference camera's own"))


@frozen
class TimelineRequest(_FromEdl):
    """A new timeline of an EDL."""

    task = "timeline"

    preset: Preset = field(metadata=doc("the output settings it is given"))
    output: str = field(metadata=doc("name of the video, beside the timeline"))
    silent: bool = field(default=False, metadata=doc("no sound at all, whatever `sound` says", optional=True))


@frozen
class RefreshRequest(_FromEdl):
    """Programme, Centering, Conformed and sound of an existing timeline anew; its output settings stay."""

    task = "refresh"


@frozen
class ReadRequest(Request[ReadDecisions]):
    """The editor's decisions in a timeline."""

    task = "read"
    answer = ReadDecisions

    instead: Path | None = field(
        default=None,
        validator=_absolute,
        metadata=doc("the EDL that a person named to take the decisions; null: the timeline's own alone"),
    )


@frozen
class RenderRequest(Request[RenderedVideo]):
    """A timeline as it stands -> a video."""

    task = "render"
    answer = RenderedVideo

    preset: Preset = field(metadata=doc("what is delivered"))
    output: Path = field(validator=_absolute, metadata=doc("the video"))
    delivered: tuple[FrameRange, ...] = field(
        default=(), metadata=doc("the programme frames that it shows, closed up; all of them without", optional=True)
    )


# --------------------------------------------------------------------------------------------------------- progress


@frozen
class Step:
    """The stages that follow belong to this step of the work."""

    step: int = field(validator=Bounds(low=1), metadata=doc("counted from 1"))
    of: int = field(validator=Bounds(low=1), metadata=doc("so many steps the work has, some of which may be left out"))


@frozen
class Stage:
    """A new stage of the work begins."""

    stage: str = field(metadata=doc("for people"))
    total: int | None = field(default=None, metadata=doc("units to do; null when unknown"))
    unit: str = field(default="", metadata=doc("what is counted"))
    shown: str = field(
        default="", metadata=doc("the stage in the user's language, where that is not English", optional=True)
    )


@frozen
class Done:
    """So many units of the current stage are finished."""

    done: int = field(validator=_COUNT, metadata=doc("an absolute count"))


@frozen
class Note:
    """Something a person should know."""

    note: str


@frozen
class Result:
    """The last message of a success."""

    result: Mapping[str, Any]


@frozen
class Failure:
    """Why the work ended, as `McslError` has it."""

    what: str
    where: str = ""
    remedy: str = ""
    exit_code: int = field(default=4, metadata=doc("what the command line ends with"))


@frozen
class Failed:
    """The last message of a failure."""

    error: Failure


Message = Step | Stage | Done | Note | Result | Failed
_KINDS: Mapping[str, type[Any]] = {
    attrs.fields(kind)[0].name: kind for kind in (Step, Stage, Done, Note, Result, Failed)
}


def parse_message(line: str | bytes) -> Message | None:
    """The message that a line of ``--progress json`` holds.

    Parameters
    ----------
    line
        One line, without its end.

    Returns
    -------
    Message or None
        None where the line is no message at all, such as what a library printed.

    Raises
    ------
    DocumentError
        The line is a message with a wrong value; the error names the path to it.
    """
    try:
        value = json.loads(line)
    except ValueError:
        return None
    kind = next((_KINDS[key] for key in value if key in _KINDS), None) if isinstance(value, dict) else None
    return None if kind is None else structure(value, kind, where="a line of progress")


class MessageFile:
    """The messages that a child process appends to a file, read as they come."""

    def __init__(self, path: Path) -> None:
        self._path, self._at, self._rest = path, 0, b""

    def read(self, *, ended: bool) -> list[Message]:
        """The messages since the last time.

        Parameters
        ----------
        ended
            Whether the child was gone before this call: then its last line counts without an end as well.

        Raises
        ------
        DocumentError
            As `parse_message`.
        """
        with open(self._path, "rb") as stream:
            stream.seek(self._at)
            new = stream.read()
        self._at += len(new)
        *lines, self._rest = (self._rest + new).split(b"\n")
        if ended:
            lines.append(self._rest)
        return [message for line in lines if (message := parse_message(line)) is not None]


# ------------------------------------------------------------------------------------------------ results of commands


@frozen
class ConformedMedia:
    """Result of ``mcsl conform``."""

    folder: Path = field(metadata=doc("where the media lie, as the call named it"))
    chunks: int = field(validator=_COUNT, metadata=doc("files that the programme needs"))
    made: int = field(validator=_COUNT, metadata=doc("those that were made now"))
    pieces: tuple[ConformedPiece, ...] = field(metadata=doc("the files, absolute"))
    sound: Path | None = field(validator=_absolute, metadata=doc("the conformed sound, where the programme has any"))


@frozen
class OfferedPlugin:
    """A row of ``mcsl plugins --json``."""

    stage: str
    name: str
    package: str
    version: str
    summary: str
    default: bool = field(metadata=doc("whether the stage takes it where none is named"))


# ----------------------------------------------------------------------------------------------------- to and from JSON

_converter = make_converter()
_converter.register_structure_hook(Path, lambda value, _: Path(_converter.structure(value, str)))
_converter.register_unstructure_hook(Path, str)


def to_json(message: Any) -> Any:
    """The JSON value of a message."""
    return _converter.unstructure(message)


def structure(value: Any, kind: type[T], *, where: str) -> T:
    """The message of class ``kind`` that a JSON value holds.

    Parameters
    ----------
    value
        What `json` read.
    kind
        A class of this module, or a tuple type of one.
    where
        Whose message it is, for the error.

    Raises
    ------
    DocumentError
        The value is no such message; the error names the path to the first wrong value.
    """
    try:
        return structure_document(value, kind, _converter, where=where, name="messages")
    except DocumentError as error:
        remedy = "mcsl and its Blender extension must be of one version: install both anew"
        raise DocumentError(error.what, where=error.where, remedy=remedy) from error
