"""`mcsl plugins`."""

from __future__ import annotations

import contextlib
import json
import sys

import click

from mcsl_core.cli.output import Session
from mcsl_core.hooks.stages import STAGES


@click.command("plugins")
@click.option("--json", "as_json", is_flag=True, help="As JSON.")
@click.pass_obj
def list_plugins(session: Session, as_json: bool) -> None:
    """List what can do each stage, built in or installed."""
    from mcsl_core.cli.console import offers_table
    from mcsl_core.hooks.registry import discover

    with contextlib.redirect_stdout(sys.stderr):  # what plugins print is no row of the list
        offers = discover().offers
    if as_json or session.json:
        rows = [
            {
                "stage": o.stage,
                "name": o.name,
                "package": o.package,
                "version": o.version,
                "summary": o.summary,
                "default": STAGES[o.stage].default == o.name,
            }
            for o in offers
        ]
        click.echo(json.dumps(rows, indent=2, ensure_ascii=False))
        return
    session.out.print(offers_table(offers))
