"""`mcsl timeline` and `mcsl pull`: to Blender and back."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import Any

import click

import mcsl_core as mcsl
from mcsl_core.cli.options import FORCE, PATH, allow_outside
from mcsl_core.cli.output import Session
from mcsl_core.progress import counted


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
@click.argument("blend", type=PATH)
@click.option("-o", "--out", type=PATH, help="The EDL to write (default: the one the timeline was built from).")
@click.option("--blender", metavar="PATH", help="The Blender to use (see: mcsl blender).")
@FORCE
@allow_outside
@click.pass_obj
def pull(session: Session, blend: Path, out: Path | None, blender: str | None, force: bool) -> None:
    """Read the editor's changes in BLEND as overrides."""
    from mcsl_core.blender import installation
    from mcsl_core.blender.timeline import pull_overrides

    with session.progress() as progress:
        edl = pull_overrides(blend, out, blender=installation.find(blender), force=force, progress=progress)
    count = len(edl.overrides)
    session.result({"overrides": count}, counted(count, "overrides"))
