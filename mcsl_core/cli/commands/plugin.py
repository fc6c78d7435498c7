"""`mcsl plugin new`."""

from __future__ import annotations

import sys
from pathlib import Path
from shlex import quote

import click

from mcsl_core.cli.options import PATH, Commands
from mcsl_core.cli.output import Session
from mcsl_core.hooks.stages import STAGES


@click.group("plugin", cls=Commands)
def plugin_group() -> None:
    """Write a plugin of your own (what there is: mcsl plugins)."""


@plugin_group.command("new")
@click.argument("name")
@click.option(
    "--stage",
    type=click.Choice(list(STAGES)),
    metavar="STAGE",  # all of them on one line are wider than a terminal
    required=True,
    help=f"What it does: {', '.join(STAGES)}.",
)
@click.option("-o", "--out", type=PATH, help="The folder, which must not be there yet (default: ./NAME).")
@click.pass_obj
def new(session: Session, name: str, stage: str, out: Path | None) -> None:
    """Write a small working plugin.

    It is there to be changed into yours. NAME is what it is chosen by, in small letters with hyphens. The folder holds
    pyproject.toml, the module, a test and a README; it can be installed and used as it is.
    """
    from mcsl_core.cli.new_plugin import new_plugin

    folder = out or Path(name)
    files = new_plugin(name, stage, folder)
    python, install = quote(sys.executable), quote(str(folder.resolve()))
    session.result(
        {"folder": str(folder), "files": [str(file) for file in files]},
        f"{folder}: {STAGES[stage].noun} {name}. Install it: {python} -m pip install -e {install}\n"
        f"Use it: mcsl analyse ... --{stage} {name}\nTest it: {python} -m pytest {quote(str(folder))}",
    )
