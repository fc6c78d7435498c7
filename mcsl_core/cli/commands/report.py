"""`mcsl report`."""

from __future__ import annotations

from pathlib import Path

import click

import mcsl_core as mcsl
from mcsl_core.cli.options import FORCE, PATH, allow_outside
from mcsl_core.cli.output import Session, file_size


@click.command()
@click.argument("edl", type=PATH)
@click.option("-o", "--out", type=PATH, required=True, help="The page (.html).")
@click.option("--figures", type=PATH, help="From mcsl evaluate --json (default: measured at the switches).")
@click.option(
    "--anonymous", is_flag=True, help="No names of cameras, files, folders, no remarks; pictures show what they show."
)
@click.option("--no-pictures", is_flag=True, help="Leave the pictures out.")
@FORCE
@allow_outside
@click.pass_obj
def report(session: Session, edl: Path, out: Path, figures: Path | None, no_pictures: bool, **how: bool) -> None:
    """Write a page about EDL that is read in a minute.

    Cameras, shots, movements, alignment, clocks and steadiness; self-contained, for any browser.
    """
    with session.progress() as progress:
        how["with_pictures"] = not no_pictures
        mcsl.open(edl).report(out, figures=figures, progress=progress, **how)
    session.result({"report": str(out)}, f"{out}: {file_size(out)}, open it in a browser")
