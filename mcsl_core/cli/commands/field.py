"""`mcsl field`: where the surgical field lies, drawn by hand, and shown."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import click

from mcsl_core import edl as edls
from mcsl_core.cli.options import FORCE, PATH, allow_outside
from mcsl_core.cli.output import Session
from mcsl_core.cli.stretches import piece_of
from mcsl_core.edl import Edl
from mcsl_core.edl.edits import clear_field, draw_field
from mcsl_core.edl.field import HAND, MIDDLE, PICTURES, Polygon, awaits_analysis, fields_now
from mcsl_core.errors import Fault, UsageError
from mcsl_core.outputs.claim import claim
from mcsl_core.outputs.inputs import inputs_of
from mcsl_core.outputs.locks import changing
from mcsl_core.outputs.manifest import Manifest
from mcsl_core.timing import FrameRange, format_time

_WORDS = {
    HAND: "drawn by hand",
    PICTURES: "found in the pictures",
    MIDDLE: "nothing shows it, the middle of the picture is taken",
}


def change_field(path: Path, polygons: tuple[str, ...], *, clear: bool, piece: FrameRange | None, note: str) -> Edl:
    """Draws the field in the EDL at ``path``, or takes away what is drawn; returns it as it then is."""
    if not polygons and not clear:
        return edls.load(path)
    outlines = tuple(polygon_of(text) for text in polygons)
    with changing(path):  # what somebody else writes meanwhile is read first, or comes after
        edl = edls.load(path)
        try:
            new = draw_field(edl, outlines, piece, note) if outlines else clear_field(edl, piece)
        except Fault as fault:
            which = re.match(r"\.polygons\[(\d+)\]", fault.at)
            raise UsageError(
                f"--polygon {polygons[int(which[1])][:80]!r} {fault.what}" if which else f"--polygon: {fault.what}",
                remedy="Give its corners in programme pixels; --show writes a picture with rulers",
            ) from fault
        if new != edl:
            edls.save(new, path)
    return new


def polygon_of(text: str) -> Polygon:
    """The corners of ``x,y x,y x,y``; UsageError where they are none."""
    try:
        pairs = (corner.split(",") for corner in text.replace(";", " ").split())
        corners = tuple((float(x), float(y)) for x, y in pairs)
    except ValueError:
        corners = ()
    if not corners:
        remedy = 'Write its corners right and down: "412,310 900,290 880,720"'
        raise UsageError(f"--polygon {text[:80]!r} is no polygon", remedy=remedy)
    return corners


def values(edl: Edl) -> dict[str, Any]:
    """Where the field lies, for programs."""
    stretches = [
        {"range": [one.range.start, one.range.stop], "by": one.by, "polygons": one.polygons} for one in fields_now(edl)
    ]
    return {"fields": stretches, "awaits_analysis": awaits_analysis(edl)}


def describe(edl: Edl) -> str:
    """Where the field lies, for people."""
    lines = []
    for one in fields_now(edl):
        start, stop = (format_time(frame / edl.rate) for frame in (one.range.start, one.range.stop))
        x, y = zip(*(corner for polygon in one.polygons for corner in polygon), strict=True)
        about = f"x {min(x):.0f} to {max(x):.0f}, y {min(y):.0f} to {max(y):.0f}"
        lines.append(f"{start} to {stop}: {_WORDS[one.by]} ({about})")
    if not lines:
        lines.append("where the field lies is not written in this EDL: run `mcsl analyse` again, or draw it")
    if awaits_analysis(edl):
        lines.append("`mcsl analyse` uses what is drawn now: alignment, scores, shots and centering are of before")
    return "\n".join(lines)


@click.command()
@click.argument("edl", type=PATH)
@click.option(
    "--polygon",
    "polygons",
    metavar='"X,Y X,Y X,Y"',
    multiple=True,
    help="Its corners; repeat for a field of several parts.",
)
@click.option("--clear", is_flag=True, help="Take away what is drawn: the field is found in the pictures again.")
@click.option("--range", "frames", metavar="A:B", help="Only in the programme's frames from A up to B.")
@click.option("--from", "start", metavar="TIME", help="Only from here on: 1:02:03.5 or seconds.")
@click.option("--to", "stop", metavar="TIME", help="Only up to here.")
@click.option("--note", default="", help="A remark to keep with what is drawn.")
@click.option("--show", type=PATH, metavar="PNG", help="Write a picture with the field's outline and rulers.")
@FORCE
@allow_outside
@click.pass_obj
def field(
    session: Session,
    edl: Path,
    polygons: tuple[str, ...],
    clear: bool,
    show: Path | None,
    force: bool,
    **how: Any,
) -> None:
    """Say where the surgical field lies, draw it by hand, or show it.

    Corners are in pixels of the programme before centering, right and down from the top left; in the first
    perspective those are the reference camera's own. What is drawn stands in the EDL: the next `mcsl analyse` aligns,
    scores and centres by it, and keeps it. Without --range, --from and --to it holds over the whole programme.
    """
    if polygons and clear:
        raise UsageError("--polygon and --clear are two wishes", remedy="Draw anew without --clear: it replaces")
    now = edls.load(edl)
    piece = piece_of(now, how["frames"], how["start"], how["stop"])
    if piece is not None and not polygons and not clear and show is None:
        raise UsageError("a stretch is named, but nothing to do there", remedy="See: mcsl field --help")
    if show is not None:  # refused before anything is changed
        claim(show, inputs=inputs_of(now, edl), manifest=Manifest.beside(edl), force=force)
    made = change_field(edl, polygons, clear=clear, piece=piece, note=how["note"])
    result, text = values(made), describe(made)
    if show is not None:
        from mcsl_core.report.field_picture import write_field_picture

        frame = write_field_picture(made, edl, show, piece=piece, force=force)
        result |= {"show": str(show), "frame": frame}
        text += f"\n{show}: frame {frame}"
    session.result(result, text)
