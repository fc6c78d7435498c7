"""`mcsl evaluate`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import mcsl_core as mcsl
from mcsl_core.cli.options import FORCE, PATH, allow_outside
from mcsl_core.cli.output import Session
from mcsl_core.errors import UsageError

if TYPE_CHECKING:
    from mcsl_core.outputs.claim import Output


@click.command()
@click.argument("edl", type=PATH, required=False)
@click.option("--manual", type=PATH, help="Alignments by hand (JSON or CSV): measures Manual-alignment too.")
@click.option(
    "--manual-fit",
    type=click.Choice(["similarity", "homography"]),
    default="similarity",
    show_default=True,
    help="What point pairs set by hand become.",
)
@click.option(
    "--every",
    type=click.IntRange(min=0),
    default=1,
    show_default=True,
    metavar="N",
    help="One in N pairs within shots; 0: switches alone.",
)
@click.option(
    "--size",
    "width",
    type=click.IntRange(16, 8192),
    default=640,
    show_default=True,
    metavar="W",
    help="Width of the pictures measured.",
)
@click.option("--colour", is_flag=True, help="Match the cameras' colours in all variants.")
@click.option("--study", type=PATH, help="Test the ratings of a viewers' questionnaire (CSV) instead.")
@click.option("--csv", "csv_file", type=PATH, help="Write the figures as CSV.")
@click.option("--json", "json_file", type=PATH, help="Write the figures as JSON (mcsl report takes it).")
@FORCE
@allow_outside
@click.pass_obj
def evaluate(session: Session, edl: Path | None, study: Path | None, **how: Any) -> None:
    """Measure how steady the programme of EDL is.

    ITF and AvSpeed without alignment, aligned by hand, and as mcsl makes it; docs/explanation/evaluation.md says how.
    """
    given = click.get_current_context().get_parameter_source("manual_fit")
    if how["manual"] is None and given is not click.core.ParameterSource.DEFAULT:
        raise UsageError("--manual-fit says what --manual becomes, which is not given", remedy="Give both or none")
    from mcsl_core.cli import console
    from mcsl_core.outputs.inputs import inputs_of

    files, force = [how.pop("csv_file"), how.pop("json_file")], how.pop("force")
    if study is not None and edl is None:
        from mcsl_core.evaluation import questionnaire

        outputs = _claimed(files, study, [study], force)
        tests = questionnaire.analyse_questionnaire(study)
        shown, as_csv, as_json = console.study_table(tests), questionnaire.to_csv(tests), questionnaire.to_json(tests)
    elif edl is not None and study is None:
        from mcsl_core.evaluation import results

        programme = mcsl.open(edl)
        read = [*inputs_of(programme.edl, edl), *([how["manual"]] if how["manual"] else [])]
        outputs = _claimed(files, edl, read, force)
        with session.progress() as progress:
            found = mcsl.evaluate(programme, **how, progress=progress)
        shown = console.steadiness_table(found, programme.edl.rate)
        as_csv, as_json = results.to_csv(found), results.to_json(found)
    else:
        raise UsageError("takes an EDL, or --study with a file of ratings", remedy="See: mcsl evaluate --help")
    for output, text in zip(outputs, (as_csv, as_json), strict=True):
        if output is not None:
            output.write(text.encode())
    if session.json:
        session.json.result(json.loads(as_json))
    else:
        session.out.print(shown, soft_wrap=False)


def _claimed(files: list[Path | None], document: Path, read: list[Path], force: bool) -> list[Output | None]:
    """The files that shall be written, each checked against what is read and those before it."""
    from mcsl_core.outputs.claim import claim
    from mcsl_core.outputs.manifest import Manifest

    outputs: list[Output | None] = []
    for file in files:
        before = [output.path for output in outputs if output is not None]
        given = {"inputs": [*read, *before], "manifest": Manifest.beside(document), "force": force}
        outputs.append(None if file is None else claim(file, **given))
    return outputs
