"""The command line: flags in, text or JSON lines out; nothing else.

Exit codes: 0 done, 2 wrong call, 3 input refused, 4 failed, 130 stopped.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import sys
from pathlib import Path
from typing import Any

import click

from . import __version__
from .errors import Cancelled, McslError, UsageError
from .progress import JsonLines
from .session import Session, own_output
from .stages import STAGES
from .timing import parse_rate

PATH = click.Path(path_type=Path)


class Commands(click.Group):
    """Lists the commands in the order of the work, not of the alphabet."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self.commands)


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, prog_name="mcsl")
@click.option(
    "--progress",
    type=click.Choice(["auto", "bar", "lines", "json", "none"]),
    default="auto",
    help="How long work reports: a bar, one line a stage, one JSON object a line on standard output, or not at all.",
)
@click.option("--debug", is_flag=True, help="Show the traceback of an error.")
@click.pass_context
def cli(ctx: click.Context, progress: str, debug: bool) -> None:
    """One steady, unoccluded video from the cameras of a surgical lamp.

    \b
    recording --analyse--> EDL --timeline--> edit.blend --pull--> overrides --render--> video

    Try it without a recording of your own: mcsl demo
    """
    ctx.obj = Session(progress, debug)


def _stage_options(command: Any) -> Any:
    """--movement NAME, --occlusion NAME, ...: which plugin does each stage."""
    for name, stage in reversed(list(STAGES.items())):
        text = f"Plugin that {stage.purpose} (default: {stage.default})."
        command = click.option(f"--{name}", metavar="NAME", help=text)(command)
    return command


@cli.command()
@click.argument("folder", type=PATH, required=False)
@click.option("--seed", default=1, show_default=True, help="Another seed is another operation.")
@click.option("--blender", metavar="PATH", help="The Blender to use (see: mcsl blender).")
@click.pass_obj
def demo(session: Session, folder: Path | None, seed: int, blender: str | None) -> None:
    """The whole way once, on a simulated recording.

    Simulates it, analyses it, builds the timeline and renders the video.
    Everything goes into FOLDER (default: ./mcsl-demo).
    """
    from .demo import run_demo

    with session.progress() as progress:
        made = run_demo(folder or Path("mcsl-demo"), seed=seed, blender=blender, progress=progress)
    session.result(made.values, made.text)


@cli.command()
@click.argument("out", type=PATH)
@click.option("--seed", default=0, show_default=True)
@click.option("--duration", "duration_s", default=60.0, show_default=True, metavar="S", help="Seconds.")
@click.option("--size", default="960x540", show_default=True, metavar="WxH")
@click.option("--rate", default="30000/1001", show_default=True, help="Frames per second.")
@click.option("--cameras", default=5, show_default=True)
@click.option("--movements", default=1, show_default=True, help="How often the lamp is moved.")
@click.option("--drape", type=click.Choice(["green", "blue", "white", "skin"]), default="green", show_default=True)
@click.option("--skin", type=click.Choice(["light", "medium", "dark"]), default="light", show_default=True)
@click.option("--gloves", type=click.Choice(["white", "blue", "skin"]), default="white", show_default=True)
@click.pass_obj
def simulate(session: Session, out: Path, size: str, rate: str, **scene: Any) -> None:
    """Make a recording with known truth.

    Camera files and truth.json go into the folder OUT.
    """
    from .simulation import Scenario
    from .simulation import simulate as run

    try:
        width, height = (int(v) for v in size.lower().split("x"))
        scenario = Scenario(size=(width, height), rate=parse_rate(rate), **scene)
    except ValueError as error:
        raise UsageError(str(error), remedy="See: mcsl simulate --help") from error
    with session.progress() as progress:
        truth = run(scenario, out, progress)
    session.result(
        {"folder": str(out), "frames": truth.frames, "movements": len(truth.movements)},
        f"{out}: {len(truth.cameras)} cameras, {truth.frames} frames, {len(truth.movements)} lamp movements",
    )


@cli.command()
@click.argument("recording", type=PATH, nargs=-1, required=True)
@click.option("-o", "--out", type=PATH, required=True, help="The EDL; an existing one keeps its overrides.")
@click.option("--reference", metavar="CAMERA", help="Whose perspective the programme keeps (default: the first).")
@click.option("--rate", help="Programme frames per second (default: the reference camera's).")
@click.option("--sync", default="auto", show_default=True, help="auto (first sure), timecode, audio, motion or none.")
@click.option("--gaze", type=PATH, multiple=True, help="Where viewers looked (CSV): centres that, not the field.")
@click.option("--no-cache", is_flag=True, help="Neither use nor keep results of stages beside the EDL.")
@_stage_options
@click.pass_obj
def analyse(
    session: Session,
    recording: tuple[Path, ...],
    out: Path,
    reference: str | None,
    rate: str | None,
    sync: str,
    gaze: tuple[Path, ...],
    no_cache: bool,
    **stages: str | None,
) -> None:
    """Decide everything: a recording becomes an EDL.

    RECORDING is a folder with one file per camera, or the camera files in order.
    """
    from . import analysis, plugins

    try:
        settings = analysis.AnalysisSettings(
            reference=reference,
            rate=parse_rate(rate) if rate else None,
            sync=sync,
            gaze=gaze,
            cache=not no_cache,
            stages={stage: name for stage, name in stages.items() if name},
        )
    except ValueError as error:
        raise UsageError(str(error)) from error
    with session.progress() as progress:
        edl = analysis.analyse(recording, out, settings=settings, plugins=plugins.discover(), progress=progress)
    session.result({"edl": str(out), **analysis.summary(edl)}, f"{out}: {analysis.describe(edl)}")


@cli.command()
@click.argument("edl", type=PATH)
@click.option("-o", "--out", type=PATH, required=True, help="The .blend file.")
@click.option("--preset", default="h264", show_default=True, help="Render settings the file is given.")
@click.option("--conformed", type=PATH, help="Folder of conformed media (default: beside the EDL, where present).")
@click.option("--blender", metavar="PATH", help="The Blender to use (see: mcsl blender).")
@click.pass_obj
def timeline(session: Session, edl: Path, out: Path, preset: str, conformed: Path | None, blender: str | None) -> None:
    """Build the Blender timeline of EDL."""
    from . import blender as desk
    from . import timeline as lines

    with session.progress() as progress:
        values = lines.build(
            edl, out, blender=desk.find(blender), preset=preset, conformed=conformed, progress=progress
        )
    session.result({"blend": str(out), **(values or {})}, f"{out}: open it in Blender, or render it: mcsl render {out}")


@cli.command()
@click.argument("edl", type=PATH)
@click.option("--centering/--no-centering", default=None, help="Shift the surgical field to the middle.")
@click.option("--fill/--no-fill", default=None, help="Fill what the chosen camera does not see.")
@click.option("--colour/--no-colour", default=None, help="Match the cameras' colours.")
@click.option("--centre", metavar="DX,DY", help="Shift by this much in programme pixels, in place of the automatic.")
@click.option("--from", "start", metavar="TIME", help="Only from here on: 1:02:03.5 or seconds.")
@click.option("--to", "stop", metavar="TIME", help="Only up to here.")
@click.pass_obj
def look(session: Session, edl: Path, **how: Any) -> None:
    """Switch the visual aids of EDL on or off, without analysing again.

    For the whole programme, or with --from and --to for a stretch of it, as an override. Without options: say how
    they stand.
    """
    from . import looks

    made = looks.change_file(edl, **how)
    session.result(looks.values(made), looks.describe(made))


@cli.command()
@click.argument("blend", type=PATH)
@click.option("-o", "--out", type=PATH, help="The EDL to write (default: the one the timeline was built from).")
@click.option("--blender", metavar="PATH", help="The Blender to use (see: mcsl blender).")
@click.pass_obj
def pull(session: Session, blend: Path, out: Path | None, blender: str | None) -> None:
    """Read the editor's changes in BLEND as overrides."""
    from . import blender as desk
    from . import timeline as lines

    with session.progress() as progress:
        edl = lines.pull(blend, out, blender=desk.find(blender), progress=progress)
    count = len(edl.overrides)
    session.result({"overrides": count}, f"{count} override{'s' * (count != 1)}")


@cli.command()
@click.argument("edl", type=PATH)
@click.option("-o", "--out", type=PATH, help="Folder of the conformed media (default: EDL's name + .conformed).")
@click.option(
    "--quality", default="standard", show_default=True, help="Of the conformed pictures: draft, standard or fine."
)
@click.option("--jobs", type=int, help="Chunks made at the same time (default: one a core).")
@click.option("--prune", is_flag=True, help="Delete chunks that the EDL no longer needs.")
@click.pass_obj
def conform(session: Session, edl: Path, out: Path | None, quality: str, jobs: int | None, prune: bool) -> None:
    """Make the exact programme pictures of EDL.

    From the original media, in full resolution, in chunks: only what is missing or changed is made.
    Qualities lie beside each other; a timeline shows the finest there is of each stretch.
    """
    from . import conform as conforming
    from . import edl as document
    from .plugins import filler_of
    from .quality import named
    from .timeline import piece_of

    kind, decided = named(quality), document.load(edl)
    folder = out or conforming.default_folder(edl)
    with session.progress() as progress:
        done = conforming.conform(
            decided,
            edl.parent,
            folder,
            filler=filler_of(decided, progress),
            jobs=jobs,
            prune=prune,
            quality=kind,
            progress=progress,
        )
    session.result(
        {
            "folder": str(folder),
            "chunks": len(done.chunks),
            "made": done.made,
            "pieces": [piece_of(chunk, folder.resolve()) for chunk in done.chunks],
            "sound": None if done.audio is None else str(done.audio.resolve()),
        },
        f"{folder}: {len(done.chunks)} chunks, {done.made} made now",
    )


@cli.command()
@click.argument("source", type=PATH)
@click.option("-o", "--out", type=PATH, required=True, help="The video.")
@click.option("--preset", default="h264", show_default=True, help="A name or a preset file of your own.")
@click.option(
    "--engine",
    type=click.Choice(["blender", "direct"]),
    default="blender",
    show_default=True,
    help="Blender renders titles and all; direct writes the same programme without Blender.",
)
@click.option(
    "--quality", default="standard", show_default=True, help="Of the conformed pictures: draft, standard or fine."
)
@click.option("--jobs", type=int, help="Chunks made at the same time (default: one a core).")
@click.option("--show-origin", is_flag=True, help="Tint every pixel by its camera (with --engine direct).")
@click.option("--blender", metavar="PATH", help="The Blender to use (see: mcsl blender).")
@click.pass_obj
def render(session: Session, source: Path, out: Path, **how: Any) -> None:
    """Pull, conform and render to a video.

    SOURCE is an EDL or a .blend.
    """
    from . import rendering

    with session.progress() as progress:
        rendering.render(source, out, **how, progress=progress)
    session.result({"video": str(out)}, f"{out}: {out.stat().st_size / 1e6:.1f} MB")


@cli.command()
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
    "--every", default=1, show_default=True, metavar="N", help="One in N pairs within shots; 0: switches alone."
)
@click.option("--size", "width", default=640, show_default=True, metavar="W", help="Width of the pictures measured.")
@click.option("--colour", is_flag=True, help="Match the cameras' colours in all variants.")
@click.option("--study", type=PATH, help="Test the ratings of a viewers' questionnaire (CSV) instead.")
@click.option("--csv", "csv_file", type=PATH, help="Write the figures as CSV.")
@click.option("--json", "json_file", type=PATH, help="Write the figures as JSON (mcsl report takes it).")
@click.pass_obj
def evaluate(
    session: Session, edl: Path | None, study: Path | None, csv_file: Path | None, json_file: Path | None, **how: Any
) -> None:
    """Measure how steady the programme of EDL is.

    ITF and AvSpeed without alignment, aligned by hand, and as mcsl makes it; docs/evaluation.md says how.
    """
    from . import console
    from .documents import write_atomic

    if study is not None and edl is None:
        from . import study as studies

        results = studies.analyse_study(study)
        shown, as_csv, as_json = console.study_table(results), studies.to_csv(results), studies.to_json(results)
    elif edl is not None and study is None:
        from . import evaluation, figures

        with session.progress() as progress:
            found = evaluation.evaluate_file(edl, **how, progress=progress)
        shown, as_csv, as_json = console.steadiness_table(found), figures.to_csv(found), figures.to_json(found)
    else:
        raise UsageError("takes an EDL, or --study with a file of ratings", remedy="See: mcsl evaluate --help")
    for path, text in ((csv_file, as_csv), (json_file, as_json)):
        if path is not None:
            write_atomic(path, text.encode())
    if session.json:
        session.json.result(json.loads(as_json))
    else:
        session.out.print(shown, soft_wrap=False)


@cli.command()
@click.argument("edl", type=PATH)
@click.option("-o", "--out", type=PATH, required=True, help="The page (.html).")
@click.option("--figures", type=PATH, help="From mcsl evaluate --json (default: measured at the switches).")
@click.pass_obj
def report(session: Session, edl: Path, out: Path, figures: Path | None) -> None:
    """Write a page about EDL that is read in a minute.

    Cameras, shots, movements, alignment, clocks and steadiness; self-contained, for any browser.
    """
    from .report import write_report

    with session.progress() as progress:
        write_report(edl, out, figures_path=figures, progress=progress)
    session.result({"report": str(out)}, f"{out}: {out.stat().st_size / 1e6:.1f} MB, open it in a browser")


@cli.command("plugins")
@click.option("--json", "as_json", is_flag=True, help="As JSON.")
@click.pass_obj
def list_plugins(session: Session, as_json: bool) -> None:
    """List what can do each stage, built in or installed."""
    from .console import offers_table
    from .plugins import discover

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


@cli.group("blender", cls=Commands, invoke_without_command=True)
@click.option("--blender", metavar="PATH", help="A Blender, or a Python that has bpy.")
@click.pass_context
def blender_group(ctx: click.Context, blender: str | None) -> None:
    """Say which Blender is used, why, and what it lacks."""
    if ctx.invoked_subcommand is None:
        from . import blender as desk
        from .errors import BlenderError

        found = desk.find(blender)
        state = desk.diagnose(found)
        if not state.starts:
            lacks = f"it lacks {', '.join(state.missing)}" if state.missing else state.said
            raise BlenderError(f"does not start: {lacks}", where=str(found), remedy=state.install)
        ctx.obj.result({"command": list(found.command), "version": found.version, "why": found.why}, str(found))


@blender_group.command()
@click.option("--version", metavar="X.Y", help="Another than the usual one, beside it: 4.5, 5.0 or 5.2.")
@click.pass_obj
def install(session: Session, version: str | None) -> None:
    """Make the private environment with Blender as a Python module (bpy)."""
    from . import blender as desk

    with session.progress() as progress:
        found = desk.install(progress, version)
    session.result({"command": list(found.command), "version": found.version}, str(found))


def _stop(_signal: int, _frame: object) -> None:
    raise KeyboardInterrupt


def main(arguments: list[str] | None = None) -> int:
    """Runs the command line and returns its exit code; every error is one line for people."""
    with contextlib.suppress(ValueError):  # not in the main thread: nobody sends us signals there
        signal.signal(signal.SIGTERM, _stop)
    own_output()
    arguments = sys.argv[1:] if arguments is None else arguments
    debug, as_json = "--debug" in arguments, _wants_json(arguments)
    try:
        cli.main(arguments, prog_name="mcsl", standalone_mode=False)
        return 0
    except click.exceptions.Exit as done:
        return done.exit_code
    except (KeyboardInterrupt, click.Abort, Cancelled):
        return _fail(Cancelled(), as_json)
    except click.ClickException as error:
        if isinstance(error, click.UsageError) and not as_json:
            error.show()
            return 2
        return _fail(UsageError(error.format_message()), as_json)
    except McslError as error:
        if debug:
            raise
        return _fail(error, as_json)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except Exception as error:
        if debug:
            raise
        unexpected = McslError(
            f"{type(error).__name__}: {error}",
            where="internal error",
            remedy="Run again with `mcsl --debug ...` and report what it shows",
        )
        return _fail(unexpected, as_json)


def _wants_json(arguments: list[str]) -> bool:
    pairs = zip(arguments, [*arguments[1:], ""], strict=True)
    return "--progress=json" in arguments or any(pair == ("--progress", "json") for pair in pairs)


def _fail(error: McslError, as_json: bool) -> int:
    if as_json:
        JsonLines(sys.stdout).error(error.what, error.where, error.remedy, error.exit_code)
    else:
        print(f"mcsl: {error}", file=sys.stderr)
    return error.exit_code


if __name__ == "__main__":
    sys.exit(main())
