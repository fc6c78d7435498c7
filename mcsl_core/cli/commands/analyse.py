"""`mcsl analyse`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

import mcsl_core as mcsl
from mcsl_core.cli.options import FORCE, PATH, stage_options
from mcsl_core.cli.output import Session
from mcsl_core.errors import UsageError
from mcsl_core.hooks.stages import STAGES
from mcsl_core.timing import parse_rate


@click.command()
@click.argument("recording", type=PATH, nargs=-1, required=True)
@click.option("-o", "--out", type=PATH, required=True, help="The EDL; an existing one keeps its overrides.")
@click.option("--reference", metavar="CAMERA", help="Whose perspective the programme keeps (default: the first).")
@click.option("--rate", help="Programme frames per second (default: the reference camera's).")
@click.option("--sync", default="auto", show_default=True, help="auto (first sure), timecode, audio, motion or none.")
@click.option("--gaze", type=PATH, multiple=True, help="Where viewers looked (CSV): centres that, not the field.")
@click.option(
    "--movement-view",
    type=click.Choice(("follow", "hold")),
    default="follow",
    show_default=True,
    help="While the lamp moves: follow it, so that the programme stands still, or hold the camera.",
)
@click.option("--no-cache", is_flag=True, help="Neither use nor keep results of stages beside the EDL.")
@stage_options
@FORCE
@click.pass_obj
def analyse(
    session: Session, recording: tuple[Path, ...], out: Path, rate: str | None, no_cache: bool, **how: Any
) -> None:
    """Decide everything: a recording becomes an EDL.

    RECORDING is a folder with one file per camera, or the camera files in order.
    """
    from mcsl_core.analysis import summary

    try:
        frames_per_second = parse_rate(rate) if rate else None
    except ValueError as error:
        raise UsageError(f"--rate: {error}") from error
    force = how.pop("force")
    stages = {stage: name for stage in STAGES if (name := how.pop(stage))}
    settings = mcsl.AnalysisSettings(rate=frames_per_second, cache=not no_cache, stages=stages, **how)
    with session.progress() as progress:
        made = mcsl.analyse(recording, out, settings=settings, force=force, progress=progress)
    session.result({"edl": str(out), **summary.summary(made.edl)}, f"{out}: {summary.describe(made.edl)}")
