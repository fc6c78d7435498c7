"""`mcsl look`, and its words: shifts as people write them, and how the aids stand."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs
import click

from mcsl_core import edl as edls
from mcsl_core.cli.language import word
from mcsl_core.cli.options import PATH, allow_outside
from mcsl_core.cli.output import Session
from mcsl_core.cli.stretches import stretch
from mcsl_core.edl import Edl, Override
from mcsl_core.edl.edits import change_look
from mcsl_core.errors import Fault, UsageError
from mcsl_core.outputs.locks import changing
from mcsl_core.timing import format_time

AIDS = ("centering", "fill", "colour", "surface", "see_through")


def change_file(
    path: Path, *, centre: str | None = None, start: str | None = None, stop: str | None = None, **aids: bool | None
) -> Edl:
    """Changes the EDL at ``path`` as the command line says, saves it where that changed it, and returns it."""
    if centre is None and all(value is None for value in (start, stop, *aids.values())):
        return edls.load(path)
    with changing(path):  # what somebody else writes meanwhile is read first, or comes after
        edl = edls.load(path)
        new = _changed(edl, centre, start, stop, aids)
        if new != edl:
            edls.save(new, path)
    return new


def _changed(edl: Edl, centre: str | None, start: str | None, stop: str | None, aids: Mapping[str, bool | None]) -> Edl:
    if (start, stop) != (None, None) and centre is None and all(value is None for value in aids.values()):
        raise UsageError("a stretch is named, but nothing to switch there", remedy="See: mcsl look --help")
    piece = stretch(edl, start, stop)
    try:
        return change_look(edl, offset=None if centre is None else _pair(centre), piece=piece, **aids)
    except Fault as fault:
        raise UsageError(f"--centre {centre}: {fault.what}", remedy="Write pixels right and down: 40,-25") from fault


def _pair(text: str) -> tuple[float, float]:
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        raise UsageError(f"{text!r} is no shift", remedy="Write --centre 40,-25: pixels right and down") from None
    return x, y


def values(edl: Edl) -> dict[str, Any]:
    """How the aids stand, for programs."""
    stretches = [
        {"range": [o.range.start, o.range.stop], **{n: getattr(o, n) for n in (*AIDS, "offset") if _given(o, n)}}
        for o in edl.overrides
        if any(_given(o, n) for n in (*AIDS, "offset"))
    ]
    return {**attrs.asdict(edl.look), "stretches": stretches}


def describe(edl: Edl) -> str:
    """How the aids stand, for people."""
    lines = [", ".join(f"{_named(name)} {_on(getattr(edl.look, name))}" for name in AIDS)]
    for override in edl.overrides:
        parts = [f"{_named(name)} {_on(getattr(override, name))}" for name in AIDS if _given(override, name)]
        if override.offset is not None:
            parts.append("centred by hand, {:g},{:g} px".format(*override.offset))
        if parts:
            start, stop = (format_time(f / edl.rate) for f in (override.range.start, override.range.stop))
            lines.append(f"  {start} to {stop}: {', '.join(parts)}")
    return "\n".join(lines)


def _given(override: Override, name: str) -> bool:
    return getattr(override, name) is not None


def _named(aid: str) -> str:
    return word(aid.replace("_", " "))


def _on(on: bool) -> str:
    return word("on" if on else "off")


@click.command()
@click.argument("edl", type=PATH)
@click.option("--centering/--no-centering", default=None, help="Shift the surgical field to the middle.")
@click.option("--fill/--no-fill", default=None, help="Fill what the chosen camera does not see.")
@click.option("--colour/--no-colour", default=None, help="Match the cameras' colours.")
@click.option("--surface/--no-surface", default=None, help="Align by the relief, where one was found.")
@click.option("--see-through/--no-see-through", default=None, help="Show the field under heads and arms.")
@click.option("--centre", metavar="DX,DY", help="Shift by this much in programme pixels, in place of the automatic.")
@click.option("--from", "start", metavar="TIME", help="Only from here on: 1:02:03.5 or seconds.")
@click.option("--to", "stop", metavar="TIME", help="Only up to here.")
@allow_outside
@click.pass_obj
def look(session: Session, edl: Path, **how: Any) -> None:
    """Switch the visual aids of EDL on or off.

    Nothing is analysed again. For the whole programme, or with --from and --to for a stretch of it, as an override.
    Without options: say how they stand.
    """

    made = change_file(edl, **how)
    session.result(values(made), describe(made))
