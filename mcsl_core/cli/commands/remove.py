"""`mcsl remove`: what is left out of the video."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from mcsl_core import edl as edls
from mcsl_core.cli.options import PATH, allow_outside
from mcsl_core.cli.output import Session
from mcsl_core.cli.stretches import piece_of
from mcsl_core.edl import Edl, removal
from mcsl_core.errors import Fault, UsageError
from mcsl_core.outputs.locks import changing
from mcsl_core.timing import FrameRange, format_time


def change_removed(path: Path, piece: FrameRange | None, *, bring_back: bool) -> Edl:
    """Removes ``piece`` in the EDL at ``path``, or brings it (everything, without) back; returns it as it then is."""
    with changing(path):  # what somebody else writes meanwhile is read first, or comes after
        edl = edls.load(path)
        try:
            new = removal.bring_back(edl, piece) if bring_back or piece is None else removal.remove(edl, piece)
        except Fault as fault:
            raise UsageError(fault.what, where=str(path), remedy="Leave some of the programme") from fault
        if new != edl:
            edls.save(new, path)
    return new


def values(edl: Edl) -> dict[str, Any]:
    """What is removed, for programs."""
    return {
        "removed": [[one.start, one.stop] for one in edl.removed],
        "frames": edl.frames,
        "delivered_frames": removal.delivered_frames(edl),
    }


def describe(edl: Edl) -> str:
    """What is removed, for people."""
    whole, left = (format_time(frames / edl.rate) for frames in (edl.frames, removal.delivered_frames(edl)))
    if not edl.removed:
        return f"nothing is removed: the video lasts {whole}"
    lines = [
        "{} to {}: removed".format(*(format_time(frame / edl.rate) for frame in (one.start, one.stop)))
        for one in edl.removed
    ]
    return "\n".join([*lines, f"the video lasts {left} of {whole}"])


@click.command()
@click.argument("edl", type=PATH)
@click.option("--range", "frames", metavar="A:B", help="The programme's frames from A up to B.")
@click.option("--from", "start", metavar="TIME", help="From here on: 1:02:03.5 or seconds.")
@click.option("--to", "stop", metavar="TIME", help="Up to here.")
@click.option("--bring-back", is_flag=True, help="Deliver what was removed again: the stretch, or everything.")
@allow_outside
@click.pass_obj
def remove(
    session: Session, edl: Path, frames: str | None, start: str | None, stop: str | None, bring_back: bool
) -> None:
    """Leave a stretch of the programme out of the video.

    Times and frames are those of the whole programme, whatever is removed already. It is a decision that stands in the
    EDL: `mcsl render` and `mcsl export` close up where something is removed, and a video's sound fades over two frames
    there; the timeline and conformed media keep the whole programme. Without options: say what is removed.
    """
    now = edls.load(edl)
    piece = piece_of(now, frames, start, stop)
    made = now if piece is None and not bring_back else change_removed(edl, piece, bring_back=bring_back)
    session.result(values(made), describe(made))
