"""A document that came back from another editor -> overrides in the EDL that it was exported from."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from attrs import frozen

from mcsl_core import edl as edls
from mcsl_core.edl import Edl
from mcsl_core.edl.edits import rebased
from mcsl_core.edl.removal import bring_back, remove
from mcsl_core.errors import DocumentError, Fault, InputError, UsageError
from mcsl_core.outputs.claim import claim
from mcsl_core.outputs.inputs import inputs_of
from mcsl_core.outputs.locks import changing
from mcsl_core.outputs.manifest import Manifest
from mcsl_core.progress import Progress, Silent
from mcsl_core.recording.footage import footage_of
from mcsl_core.timing import FrameRange, format_time

from .changes import with_cameras
from .formats import FORMATS, Format, format_to_read, format_within
from .found import FoundCut
from .origin import basis_of
from .sequence import Wanted, sequence_of
from .three_way import Merged, compared


@frozen
class Pulled:
    """The EDL with what was decided, where it lies, and what was found."""

    path: Path
    edl: Edl
    found: Merged


def pull(
    document: Path, edl_path: Path, out: Path | None = None, *, force: bool = False, progress: Progress | None = None
) -> Pulled:
    """Reads an editor's changes into an EDL, or into a copy of it at ``out``.

    Which camera is shown where becomes overrides, what is shown no more is removed, what was removed when the document
    was exported and is shown is brought back; whatever else was found changed is told and left, and so are overrides
    and removals that were made since the export. Where nothing was decided anew, the file is left as it is.

    Raises
    ------
    InputError
        The document cannot be read, runs at another rate, or was exported from another analysis; or ``out`` may not be
        written over.
    """
    progress = progress or Silent()
    form = format_to_read(document)
    if form is None:
        raise UsageError("is no editor's document that mcsl reads", where=str(document))
    progress.stage(f"Reading {form.name}")
    with changing(out or edl_path):
        edl = edls.load(edl_path)
        inputs = [document, *inputs_of(edl, edl_path)]
        output = None
        if out is not None and out.resolve() != edl_path.resolve():
            output = claim(out, inputs=inputs, manifest=Manifest.beside(edl_path), force=force)
        found = changes_in(document, form, edl, edl_path.parent)
        new = with_cameras(edl, found.changes.cameras)
        for piece in found.changes.brought_back:
            new = bring_back(new, piece)
        new = _without(new, found.changes.removed, document)
        if output is not None:
            moved = rebased(new, edl_path.parent, output.path.parent)
            output.write(edl_path.read_bytes() if moved == edl else edls.dumps(moved).encode())
            edls.remember(moved, output.path)
            new = moved
        elif new != edl:
            edls.save(new, edl_path)
    for note in told(found, edl):
        progress.note(note)
    return Pulled(out or edl_path, new, found)


def changes_in(document: Path, form: Format, edl: Edl, base: Path) -> Merged:
    """What was changed in the document since it was exported from the EDL, whose paths are relative to ``base``."""
    try:
        found = form.read(document, edl.rate)
    except DocumentError as error:
        like = format_within(document)
        if like is None or like is form:
            raise
        suffix = next(suffix for suffix, one in FORMATS.items() if one is like)
        what, remedy = f"is {like.name} by what it holds, not {form.name}", f"Let its name end in {suffix}"
        raise DocumentError(what, where=str(document), remedy=remedy) from error
    _check(found, edl, document)
    footage = footage_of(edl, base)
    parts = {camera.name: footage.parts(camera.name) for camera in edl.cameras}
    cut = sequence_of(edl, parts, Wanted(name=document.stem))
    try:
        return compared(cut, edl, found, form.layout)
    except DocumentError as error:
        raise DocumentError(error.what, where=str(document), remedy=error.remedy) from error


def told(found: Merged, edl: Edl) -> list[str]:
    """What is removed, what is not read, and what became of other decisions, in words for a person."""
    lines = []
    for piece in found.changes.removed:
        lines.append(f"removed: {_named(piece, edl)} are left out of the video from now on")
    for piece in found.changes.brought_back:
        lines.append(f"brought back: {_named(piece, edl)} are in the video again")
    lines += [f"not read: {note}" for note in found.changes.notes]
    why = "was decided in the EDL, and the document does not know of it"
    lines += [f"kept: {_named(piece, edl)} show {camera}, which {why}" for piece, camera in found.kept]
    lines += [f"overruled: {_named(piece, edl)} showed {camera}, which {why}" for piece, camera in found.overruled]
    return lines


def _without(edl: Edl, pieces: Iterable[FrameRange], document: Path) -> Edl:
    """``edl`` with these frames removed as well."""
    try:
        for piece in pieces:
            edl = remove(edl, piece)
    except Fault as fault:
        what = "shows nothing of the programme that is not removed already"
        raise DocumentError(what, where=str(document), remedy="Bring some of it back: mcsl remove") from fault
    return edl


def _named(piece: FrameRange, edl: Edl) -> str:
    start, stop = (format_time(frame / edl.rate) for frame in (piece.start, piece.stop))
    return f"frames {piece} ({start} to {stop})"


def _check(found: FoundCut, edl: Edl, document: Path) -> None:
    if found.rate != edl.rate:
        raise InputError(
            f"runs at {found.rate} frames/s, the programme at {edl.rate}",
            where=str(document),
            remedy="Export the sequence at its own rate",
        )
    if found.origin and found.origin.split()[0] != basis_of(edl):
        raise InputError(
            "was exported from another analysis than this EDL holds now: what differs was not decided by the editor",
            where=str(document),
            remedy="Hand in the EDL that it was exported from with --edl, or export again",
        )
