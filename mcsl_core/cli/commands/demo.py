"""`mcsl demo`."""

from __future__ import annotations

from pathlib import Path

import click

from mcsl_core.cli.options import FORCE, PATH
from mcsl_core.cli.output import Session


@click.command()
@click.argument("folder", type=PATH, required=False)
@click.option("--seed", default=1, show_default=True, help="Another seed is another operation.")
@click.option("--blender", metavar="PATH", help="The Blender to use (see: mcsl blender).")
@FORCE
@click.pass_obj
def demo(session: Session, folder: Path | None, seed: int, blender: str | None, force: bool) -> None:
    """The whole way once, on a simulated recording.

    Simulates it, analyses it, builds the timeline and renders the video.
    Everything goes into FOLDER (default: ./mcsl-demo).
    """
    from mcsl_core.cli.demo import run_demo

    with session.progress() as progress:
        made = run_demo(folder or Path("mcsl-demo"), seed=seed, blender=blender, force=force, progress=progress)
    session.result(made.values, made.text)
