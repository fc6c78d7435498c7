"""`mcsl timeline` and `mcsl pull`: to Blender and back."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from shlex import quote
from typing import Any

import click

import mcsl_core as mcsl
from mcsl_core.cli.options import FORCE, PATH, allow_outside
from mcsl_core.cli.output import Session
from mcsl_core.errors import UsageError
from mcsl_core.progress import counted
from mcsl_core.timing import FrameRange


@click.command()
@click.argument("edl", type=PATH)
@click.option("-o", "--out", type=PATH, required=True, help="The .blend file.")
@click.option("--preset", default="h264", show_default=True, help="Render settings the file is given.")
@click.option("--conformed", type=PATH, help="Folder of conformed media (default: beside the EDL, where present).")
@click.option("--audio", type=click.Choice(["none"]), help="No sound at all (default: the reference camera's).")
@click.option("--blender", metavar="PATH", help="The Blender to use (see: mcsl blender).")
@FORCE
@allow_outside
@click.pass_obj
def timeline(session: Session, edl: Path, out: Path, **how: Any) -> None:
    """Build the Blender timeline of EDL."""
    from mcsl_core.blender.messages import to_json

    with session.progress() as progress:
        built = mcsl.open(edl).timeline(out, **how, progress=progress)
    session.result(to_json(built), f"{out}: open it in Blender, or render it: mcsl render {quote(str(out))} -o VIDEO")


@click.command()
@click.argument("document", type=PATH)
@click.option("--edl", type=PATH, help="The EDL it was exported from; a .blend names its own.")
@click.option("-o", "--out", type=PATH, help="The EDL to write (default: the one the changes belong to).")
@click.option("--blender", metavar="PATH", help="The Blender to use for a .blend (see: mcsl blender).")
@FORCE
@allow_outside
@click.pass_obj
def pull(session: Session, document: Path, edl: Path | None, out: Path | None, **how: Any) -> None:
    """Read the editor's changes in DOCUMENT as overrides.

    A .blend that `mcsl timeline` built; or what another editor made of an export: .fcpxml, .xml, .otio or .edl, with
    --edl. What is changed there and cannot be said in an EDL is named and left.
    """
    from mcsl_core.interchange.formats import format_to_read

    if format_to_read(document) is not None:
        _pull_document(session, document, edl, out, **how)
        return
    if edl is not None:
        raise UsageError(
            "--edl belongs to a document of another editor; a .blend names its own EDL",
            where=str(document),
            remedy="Name an .fcpxml, .xml, .otio or .edl file, or leave out --edl",
        )
    from mcsl_core.blender import installation
    from mcsl_core.blender.timeline import pull_overrides

    blender = how.pop("blender")
    with session.progress() as progress:
        pulled = pull_overrides(document, out, blender=installation.find(blender), **how, progress=progress)
    count = len(pulled.overrides)
    session.result({"overrides": count}, counted(count, "overrides"))


def _pull_document(
    session: Session, document: Path, edl: Path | None, out: Path | None, *, blender: str | None, force: bool
) -> None:
    from mcsl_core.interchange.pull import pull as read

    if edl is None:
        remedy = f"Say which with --edl, such as: mcsl pull {quote(str(document))} --edl edl.json"
        raise UsageError("does not say which EDL it was exported from", where=str(document), remedy=remedy)
    if blender is not None:
        raise UsageError("--blender is for a .blend", where=str(document), remedy="Leave it out")
    with session.progress() as progress:
        pulled = read(document, edl, out, force=force, progress=progress)
    changes, count = pulled.found.changes, len(pulled.edl.overrides)
    values = {
        "overrides": count,
        "changed": _stretches(changes.cameras),
        "kept": _stretches(pulled.found.kept),
        "overruled": _stretches(pulled.found.overruled),
        "removed": [[piece.start, piece.stop] for piece in changes.removed],
        "brought_back": [[piece.start, piece.stop] for piece in changes.brought_back],
        "not_read": list(changes.notes),
    }
    changed = counted(len(changes.cameras), "changes")
    session.result(values, f"{pulled.path}: {changed}, {counted(count, 'overrides')}")


def _stretches(pieces: Iterable[tuple[FrameRange, str]]) -> list[list[int | str]]:
    return [[piece.start, piece.stop, camera] for piece, camera in pieces]
