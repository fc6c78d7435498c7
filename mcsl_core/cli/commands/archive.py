"""`mcsl archive`."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import click

from mcsl_core.cli.options import PATH
from mcsl_core.cli.output import Session
from mcsl_core.progress import counted


@click.command()
@click.argument("archive", type=PATH)
@click.option("-o", "--out", type=PATH, required=True, help="Folder of the results, one folder an operation.")
@click.option("--table", type=PATH, help="Options of single operations (CSV): reference, preset, plugins and the like.")
@click.option("--cores", type=click.IntRange(min=1), help="Of this machine that are used (default: all).")
@click.option("--threads", type=click.IntRange(min=1), default=2, show_default=True, help="Cores a job asks for.")
@click.option("--profile", metavar="NAME", help="Snakemake's profile: Slurm, Kubernetes or whatever it names.")
@click.option("--mcsl", metavar="COMMAND", help="How a job calls mcsl where it runs (default: by this Python).")
@click.option("--dry-run", is_flag=True, help="Say what would be done, how long and how large, and do nothing.")
@click.option("--openjd", type=PATH, metavar="FILE", help="Write a job template for render farms in place of working.")
@click.option("--anonymous", is_flag=True, help="Call operations by number in folders, logs, triage and reports.")
@click.pass_obj
def archive(session: Session, archive: Path, out: Path, *, dry_run: bool, openjd: Path | None, **how: Any) -> None:
    """Work through all operations of ARCHIVE.

    ARCHIVE is a folder with a folder for each operation. Each is analysed, conformed, rendered without Blender,
    measured and reported; then a page ranks them by what needs a person. Done again it does only what is new.
    With --openjd those that have an EDL are rendered by the Blenders of a farm: Open Job Description, as YAML.
    """
    from mcsl_core.archive.engine import Engine
    from mcsl_core.archive.openjd import template_text
    from mcsl_core.archive.run import carry_out, describe, survey
    from mcsl_core.archive.triage import write_triage
    from mcsl_core.errors import McslError
    from mcsl_core.outputs.claim import claim
    from mcsl_core.outputs.manifest import Manifest

    given: dict[str, Any] = {name: how.pop(name) for name in ("table", "anonymous")}
    engine = Engine(**{name: value for name, value in how.items() if value is not None})
    with session.progress() as progress:
        if dry_run or openjd is not None:
            works = survey(archive, out, **given, write=False, progress=progress)
        else:
            works = carry_out(archive, out, engine, **given, progress=progress)
            write_triage(works, out, anonymous=given["anonymous"], progress=progress)
        if openjd is not None:
            output = claim(openjd, manifest=Manifest.beside(out / "archive.json"))
            output.write(template_text(works, out, openjd, progress).encode("utf-8"))
    if openjd is not None:
        session.result({"template": str(openjd)}, f"{openjd}: for those operations that have an EDL")
        return
    states = Counter(work.outcome.state for work in works)
    values = {"operations": dict(states), **({} if dry_run else {"triage": str(out / "triage.html")})}
    session.result(values, describe(works, out) if dry_run else f"{out / 'triage.html'}: {describe(works, out)}")
    if states["failed"] and not dry_run:
        what = f"{counted(states['failed'], 'operations')} failed"
        raise McslError(what, where=str(out / "triage.html"), remedy="See why there, then run again")
