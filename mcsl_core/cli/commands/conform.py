"""`mcsl conform`."""

from __future__ import annotations

from pathlib import Path

import click

from mcsl_core.cli.options import PATH
from mcsl_core.cli.output import Session


@click.command()
@click.argument("edl", type=PATH)
@click.option("-o", "--out", type=PATH, help="Folder of the conformed media (default: EDL's name + .conformed).")
@click.option(
    "--quality", default="standard", show_default=True, help="Of the conformed pictures: draft, standard or fine."
)
@click.option("--jobs", type=int, help="Chunks made at the same time (default: one a core).")
@click.option("--prune", is_flag=True, help="Delete chunks that the EDL no longer needs.")
@click.pass_obj
def conform(session: Session, edl: Path, out: Path | None, quality: str, jobs: int | None, prune: bool) -> None:
    """Make the exact programme pictures of EDL.

    From the original media, in full resolution, in chunks: only what is missing or changed is made.
    Qualities lie beside each other; a timeline shows the finest there is of each stretch.
    """
    from mcsl_core import edl as edls
    from mcsl_core.blender.timeline import piece_of
    from mcsl_core.delivery import conform as conforming
    from mcsl_core.delivery.quality import quality_named
    from mcsl_core.delivery.source import ProgrammeSource
    from mcsl_core.hooks.registry import filler_of

    kind, decided = quality_named(quality), edls.load(edl)
    folder = out or conforming.default_folder(edl)
    with session.progress() as progress:
        source = ProgrammeSource(decided, edl.parent, filler_of(decided, progress))
        done = conforming.conform(source, folder, jobs=jobs, prune=prune, quality=kind, progress=progress)
    session.result(
        {
            "folder": str(folder),
            "chunks": len(done.chunks),
            "made": done.made,
            "pieces": [piece_of(chunk, folder.resolve()) for chunk in done.chunks],
            "sound": None if done.audio is None else str(done.audio.resolve()),
        },
        f"{folder}: {len(done.chunks)} chunks, {done.made} made now",
    )
