"""`mcsl join`."""

from __future__ import annotations

from pathlib import Path

import click

from mcsl_core.cli.options import FORCE, PATH
from mcsl_core.cli.output import Session, file_size


@click.command()
@click.argument("folder", type=PATH)
@click.option("-o", "--out", type=PATH, required=True, help="The video; its name ends as the pieces' names do.")
@click.option("--sound", type=PATH, help="A file whose sound it has, coded as it is (default: FOLDER/sound.*).")
@FORCE
@click.pass_obj
def join(session: Session, folder: Path, out: Path, sound: Path | None, force: bool) -> None:
    """Join the pieces that a render farm made of one programme.

    FOLDER holds them, each named by its first and last frame: 0000001-0000600.mp4. Nothing is coded again.
    """
    from mcsl_core import edl as edls
    from mcsl_core.archive.openjd import pieces_in, sound_in
    from mcsl_core.errors import UsageError
    from mcsl_core.media.appending import append
    from mcsl_core.media.writing import FORMATS
    from mcsl_core.outputs.claim import claim
    from mcsl_core.outputs.manifest import Manifest

    if out.suffix.lower() not in FORMATS:
        remedy = f"Choose a name that ends in {', '.join(FORMATS)}"
        raise UsageError(f"cannot write a {out.suffix or 'nameless'} file", where=str(out), remedy=remedy)
    document = out.with_name("edl.json")  # what is made from an EDL is listed beside it
    pieces = pieces_in(folder, out.suffix, edls.read(document).frames if document.is_file() else None)
    sound = sound or sound_in(folder)
    inputs = [*pieces, *([sound] if sound else [])]
    manifest = Manifest.beside(document if document.is_file() else out)
    output = claim(out, inputs=inputs, manifest=manifest, force=force)
    with session.progress() as progress, output.writing() as part:
        progress.stage("Joining", len(pieces), "pieces")
        frames = append(tuple(pieces), part, sound=sound, lengths=tuple(pieces.values()))
    session.result({"video": str(out), "frames": frames}, f"{out}: {file_size(out)}, {frames} frames")
