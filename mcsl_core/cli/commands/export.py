"""`mcsl export`: the cut for other editors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from mcsl_core.cli.options import FORCE, PATH, allow_outside, audio_option
from mcsl_core.cli.output import Session
from mcsl_core.progress import counted

_START = "01:00:00:00"


@click.command()
@click.argument("edl", type=PATH)
@click.option("-o", "--out", type=PATH, required=True, help="The document: .fcpxml, .xml, .otio or .edl.")
@click.option(
    "--exact/--angles",
    default=False,
    help="The conformed programme, a clip a shot, above the cameras; or the cameras alone, roughly aligned (default).",
)
@click.option(
    "--start",
    default=_START,
    show_default=True,
    metavar="TIMECODE",
    help="Of the first frame; with a semicolon, 01:00:00;00, drop-frame.",
)
@click.option("--conformed", type=PATH, help="Folder of conformed media, for --exact (default: beside the EDL).")
@audio_option
@FORCE
@allow_outside
@click.pass_obj
def export(session: Session, edl: Path, out: Path, **how: Any) -> None:
    """Write the cut of EDL for another editor.

    Final Cut Pro and Resolve read .fcpxml, Premiere and Resolve .xml (Final Cut Pro 7's) and .otio, all else .edl
    (CMX3600). With --exact, the conformed pictures and sound are joined into two files beside it.
    What is changed there comes back with `mcsl pull`.
    """
    from mcsl_core.interchange.export import ExportSettings
    from mcsl_core.interchange.export import export as write

    with session.progress() as progress:
        made = write(edl, out, ExportSettings(**how), progress)
    cut = made.cut
    beside = "".join(f", {path}" for path in made.media)
    values = {
        "document": str(out),
        "media": [str(path) for path in made.media],
        "shots": len(cut.shots),
        "markers": len(cut.markers),
    }
    session.result(values, f"{out}{beside}: {counted(len(cut.shots), 'shots')}, {counted(len(cut.angles), 'cameras')}")
