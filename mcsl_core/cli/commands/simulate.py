"""`mcsl simulate`."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from mcsl_core.cli.options import FORCE, PATH
from mcsl_core.cli.output import Session
from mcsl_core.errors import UsageError
from mcsl_core.progress import counted
from mcsl_core.simulation.families import FAMILIES
from mcsl_core.timing import parse_rate

COLOURS = ("drape", "skin", "gloves")
"""Options that a family chooses where they are not given."""


def _is_given(option: str) -> bool:
    return click.get_current_context().get_parameter_source(option) is not ParameterSource.DEFAULT


@click.command()
@click.argument("out", type=PATH)
@click.option("--seed", default=0, show_default=True, help="Another seed is another operation.")
@click.option("--duration", "duration_s", default=60.0, show_default=True, metavar="S", help="How long, in seconds.")
@click.option("--size", default="960x540", show_default=True, metavar="WxH", help="Of each camera, in pixels.")
@click.option("--rate", default="30000/1001", show_default=True, help="Frames per second.")
@click.option("--cameras", default=5, show_default=True, help="How many.")
@click.option("--movements", default=1, show_default=True, help="How often the lamp is moved.")
@click.option("--drape", type=click.Choice(["green", "blue", "white", "skin"]), default="green", show_default=True)
@click.option("--skin", type=click.Choice(["light", "medium", "dark"]), default="light", show_default=True)
@click.option("--gloves", type=click.Choice(["white", "blue", "skin"]), default="white", show_default=True)
@click.option(
    "--family",
    "families",
    multiple=True,
    metavar="NAME",
    help="What is unlike the plain scene; may be given several times. Names: " + ", ".join(FAMILIES) + ".",
)
@click.option("--interlaced", is_flag=True, help="Two fields a frame, as theatre recorders write 1080i.")
@click.option("--hdr", type=click.Choice(["hlg", "pq"]), help="Ten bits of HLG or PQ in BT.2020, as phones do.")
@click.option("--vfr", is_flag=True, help="Variable frame rate: a quarter of the pictures is missing.")
@click.option("--split", "split_s", type=float, metavar="S", help="A new file every so many seconds.")
@click.option("--continuing-clock", is_flag=True, help="With --split: the parts' timestamps go on.")
@click.option("--quick-coding", is_flag=True, help="Code in less time, into larger files.")
@click.option("--ideal", is_flag=True, help="Film the ideal programme, too: from one place, with nobody in the way.")
@FORCE
@click.pass_obj
def simulate(session: Session, out: Path, size: str, rate: str, force: bool, ideal: bool, **chosen: Any) -> None:
    """Make a recording with known truth.

    Camera files and truth.json go into the folder OUT, the ideal programme into OUT/ideal, which no analysis takes
    for a camera.
    """
    from mcsl_core.simulation import Recorder, Scenario
    from mcsl_core.simulation import simulate as run

    numbers = re.fullmatch(r"(\d+)x(\d+)", size.lower())
    if numbers is None:
        raise UsageError(f"--size {size} is no size", remedy="Give it as 640x360")
    try:
        frames_per_second = parse_rate(rate)
    except ValueError as error:
        raise UsageError(f"--rate: {error}") from error
    try:
        written = {
            name: chosen.pop(name) for name in ("interlaced", "vfr", "split_s", "continuing_clock", "quick_coding")
        }
        recorder = Recorder(hdr=chosen.pop("hdr") or "", **written)
        chosen = {name: value for name, value in chosen.items() if name not in COLOURS or _is_given(name)}
        scenario = Scenario(size=(int(numbers[1]), int(numbers[2])), rate=frames_per_second, **chosen)
    except ValueError as error:
        raise UsageError(str(error), remedy="See: mcsl simulate --help") from error
    with session.progress() as progress:
        truth = run(scenario, out, progress, recorder, force=force, ideal=ideal)
    moved = len(truth.movements)
    session.result(
        {"folder": str(out), "frames": truth.frames, "movements": moved},
        f"{out}: {counted(len(truth.cameras), 'cameras')}, {counted(truth.frames, 'frames')}, "
        f"{counted(moved, 'lamp movements')}",
    )
