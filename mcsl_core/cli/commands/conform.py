"""`mcsl conform`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

import mcsl_core as mcsl
from mcsl_core.cli.options import PATH, allow_outside, audio_option, hwaccel_option
from mcsl_core.cli.output import Session
from mcsl_core.progress import counted


@click.command()
@click.argument("edl", type=PATH)
@click.option("-o", "--out", type=PATH, help="Folder of the conformed media (default: EDL's name + .conformed).")
@click.option(
    "--quality", default="standard", show_default=True, help="Of the conformed pictures: draft, standard or fine."
)
@click.option("--jobs", type=click.IntRange(min=1), help="Chunks made at the same time (default: one a core).")
@click.option("--part", metavar="K/N", help="Make the K-th of N parts by time; other jobs make the others meanwhile.")
@click.option("--prune", is_flag=True, help="Delete chunks that the EDL no longer needs.")
@audio_option
@hwaccel_option
@allow_outside
@click.pass_obj
def conform(
    session: Session, edl: Path, out: Path | None, quality: str, part: str | None, hwaccel: str, **how: Any
) -> None:
    """Make the exact programme pictures of EDL.

    From the original media, in full resolution, in chunks: only what is missing or changed is made.
    Qualities lie beside each other; a timeline shows the finest there is of each stretch.
    With --part several jobs, on several machines with one folder, share the work; each may be killed and repeated.
    """
    from mcsl_core.blender.messages import ConformedMedia, to_json
    from mcsl_core.blender.timeline import piece_of
    from mcsl_core.delivery.parts import WHOLE, Part
    from mcsl_core.delivery.quality import quality_named

    quality_named(quality)  # a wrong call is told before the EDL is read
    taken = WHOLE if part is None else Part.read(part)
    programme = mcsl.open(edl)
    programme.hwaccel = hwaccel
    with session.progress() as progress:
        done = programme.conform(folder=out, quality=quality, part=taken, **how, progress=progress)
    folder = done.folder
    media = ConformedMedia(
        folder=folder,
        chunks=len(done.chunks),
        made=done.made,
        pieces=tuple(piece_of(chunk, folder.resolve()) for chunk in done.chunks),
        sound=None if done.audio is None else done.audio.resolve(),
    )
    session.result(to_json(media), f"{folder}: {counted(len(done.chunks), 'chunks')}, {done.made} made now")
