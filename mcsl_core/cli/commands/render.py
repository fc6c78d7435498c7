"""`mcsl render`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from mcsl_core.cli.options import FORCE, PATH, allow_outside, audio_option, hwaccel_option
from mcsl_core.cli.output import Session, file_size


@click.command()
@click.argument("source", type=PATH)
@click.option("-o", "--out", type=PATH, required=True, help="The video.")
@click.option("--preset", default="h264", show_default=True, help="A name or a preset file of your own.")
@click.option(
    "--engine",
    type=click.Choice(["blender", "direct"]),
    default="blender",
    show_default=True,
    help="Blender renders titles and all; direct writes the same programme without Blender.",
)
@click.option(
    "--quality", default="standard", show_default=True, help="Of the conformed pictures: draft, standard or fine."
)
@click.option("--jobs", type=click.IntRange(min=1), help="Chunks made at the same time (default: one a core).")
@click.option("--show-origin", is_flag=True, help="Tint every pixel by its camera (with --engine direct).")
@click.option("--blender", metavar="PATH", help="The Blender to use (see: mcsl blender).")
@FORCE
@audio_option
@hwaccel_option
@allow_outside
@click.pass_obj
def render(session: Session, source: Path, out: Path, **how: Any) -> None:
    """Pull, conform and render to a video.

    SOURCE is an EDL or a .blend.
    """
    from mcsl_core.blender import render as rendering

    with session.progress() as progress:
        rendering.render(source, out, **how, progress=progress)
    session.result({"video": str(out)}, f"{out}: {file_size(out)}")
