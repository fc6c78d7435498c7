"""mcsl-label: frames out, painted masks in, a model out. Exit codes as those of mcsl."""

from __future__ import annotations

import sys
from pathlib import Path

import click

import mcsl_core as mcsl
from mcsl_core.hooks import Cancelled, Manifest, McslError, UsageError, claim

FORCE = click.option("--force", is_flag=True, help="Replace what mcsl-label did not write or was changed since.")
PATH = click.Path(path_type=Path)


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.option("--progress", type=click.Choice(["auto", "bar", "lines", "json", "none"]), default="auto")
@click.option("--debug", is_flag=True, help="Show the traceback of an error.")
@click.pass_context
def cli(ctx: click.Context, progress: str, debug: bool) -> None:
    """Teach mcsl what is in the way, on a few frames that you mark.

    \b
    mcsl-label export recording/ frames/     pictures to paint on
    mcsl-label train frames/ -o model.npz    a model from what you painted
    """
    ctx.obj = mcsl.Session(progress, debug)


@cli.command()
@click.argument("source", type=PATH, nargs=-1, required=True)
@click.argument("out", type=PATH)
@click.option("--frames", default=16, show_default=True, help="How many pictures to write.")
@FORCE
@click.pass_obj
def export(session: mcsl.Session, source: tuple[Path, ...], out: Path, frames: int, force: bool) -> None:
    """Write pictures to paint on into the folder OUT.

    SOURCE is an EDL of `mcsl analyse`, or a recording, which is then analysed first.
    """
    from .labelling import check_folder
    from .labelling import export as run

    if frames < 1:
        raise UsageError(f"--frames must be 1 or more, got {frames}")
    check_folder(out, force=force)
    with session.progress() as progress:
        if len(source) == 1 and source[0].suffix.lower() == ".json":
            programme = mcsl.open(source[0])
        else:
            programme = mcsl.analyse(source, out / "analysis" / "edl.json", progress=progress)
        written = run(programme, out, frames=frames, force=force, progress=progress)
    session.result(
        {"folder": str(out), "frames": [p.name for p in written]},
        f"{out}: {len(written)} pictures. Paint on them and save each beside itself as NAME.mask.png:\n"
        "pure green: the field; pure red: what is in the way; pure blue: what is neither; the rest is not used.\n"
        f"Then: mcsl-label train {out} -o model.npz",
    )


@cli.command()
@click.argument("folders", type=PATH, nargs=-1, required=True)
@click.option("-o", "--out", type=PATH, required=True, help="The model, an .npz file.")
@FORCE
@click.pass_obj
def train(session: mcsl.Session, folders: tuple[Path, ...], out: Path, force: bool) -> None:
    """Train a model from the pictures painted in FOLDERS."""
    from .labelling import read_marked
    from .training import train as run

    read = [path for folder in folders for path in folder.glob("*")]
    output = claim(out, inputs=read, manifest=Manifest.beside(out), force=force)
    with session.progress() as progress:
        marked = [m for folder in folders for m in read_marked(folder)]
        if not marked:
            raise UsageError(
                "no picture is painted",
                where=", ".join(map(str, folders)),
                remedy="Save what you paint as NAME.mask.png",
            )
        model, judged = run(marked, progress)
        with output.writing() as part:
            model.save(part)
    figures = ", ".join(f"{name} {value:.0%}" for name, value in judged.iou.items())
    session.result(
        {"model": str(out), "frames": judged.frames, "iou": judged.iou},
        f"{out}: trained on {judged.frames} frames; IoU on frames held out: {figures}\n"
        f"Use it: MCSL_LEARNED_MODEL={out} mcsl analyse ... --occlusion learned",
    )


def main(arguments: list[str] | None = None) -> int:
    """Runs the command line and returns its exit code; every error is one line for people."""
    arguments = sys.argv[1:] if arguments is None else arguments
    try:
        cli.main(arguments, prog_name="mcsl-label", standalone_mode=False)
        return 0
    except click.exceptions.Exit as done:
        return done.exit_code
    except (KeyboardInterrupt, click.Abort, Cancelled):
        error: McslError = Cancelled()
    except click.ClickException as wrong:
        wrong.show()
        return 2
    except McslError as failed:
        if "--debug" in arguments:
            raise
        error = failed
    print(f"mcsl-label: {error}", file=sys.stderr)
    return error.exit_code


if __name__ == "__main__":
    sys.exit(main())
