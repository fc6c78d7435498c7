"""`mcsl blender` and `mcsl blender install`."""

from __future__ import annotations

import click

from mcsl_core.cli.options import Commands
from mcsl_core.cli.output import Session


@click.group("blender", cls=Commands, invoke_without_command=True)
@click.option("--blender", metavar="PATH", help="A Blender, or a Python that has bpy.")
@click.pass_context
def blender_group(ctx: click.Context, blender: str | None) -> None:
    """Say which Blender is used, why, and what it lacks."""
    if ctx.invoked_subcommand is None:
        from mcsl_core.blender import installation
        from mcsl_core.errors import BlenderError

        found = installation.find(blender)
        state = installation.diagnose(found)
        if not state.starts:
            lacks = f"it lacks {', '.join(state.missing)}" if state.missing else state.said
            raise BlenderError(f"does not start: {lacks}", where=str(found), remedy=state.install)
        ctx.obj.result({"command": list(found.command), "version": found.version, "why": found.why}, str(found))


@blender_group.command()
@click.option("--version", metavar="X.Y", help="Another than the usual one, beside it: 4.5, 5.0 or 5.2.")
@click.pass_obj
def install(session: Session, version: str | None) -> None:
    """Install Blender for mcsl alone.

    Into an environment of its own, as a Python module (bpy).
    """
    from mcsl_core.blender import installation

    with session.progress() as progress:
        found = installation.install(progress, version)
    session.result({"command": list(found.command), "version": found.version}, str(found))
