"""The command line: flags in, text or JSON lines out; nothing else. Each command is a module of `commands`.

Exit codes: 0 done, 2 wrong call, 3 input refused, 4 failed, 130 stopped.
"""

from __future__ import annotations

import errno
import io
import os
import sys
from functools import partial
from itertools import pairwise
from typing import IO

import click

from mcsl_core import __version__
from mcsl_core.errors import Cancelled, McslError, UsageError
from mcsl_core.progress import JsonLines

from . import stopping
from .commands import COMMANDS
from .language import is_japanese, told
from .options import Commands
from .output import MODES, Session
from .streams import give_up, open_closed, own_output


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, prog_name="mcsl")
@click.option(
    "--progress",
    type=click.Choice(MODES),
    default="auto",
    help="How long work reports: a bar, one line a stage, one JSON object a line on standard output, or not at all.",
)
@click.option("--debug", is_flag=True, help="Show the traceback of an error.")
@click.pass_context
def cli(ctx: click.Context, progress: str, debug: bool) -> None:
    """One steady, unoccluded video from the cameras of a surgical lamp.

    \b
    recording --analyse--> EDL --timeline--> edit.blend
              --pull--> overrides --render--> video

    Try it without a recording of your own: mcsl demo
    """
    ctx.obj = Session(progress, debug)


_CARRY_ON = ("analyse", "conform", "render", "archive")  # they keep what is finished

for command in COMMANDS:
    cli.add_command(command)


def main(arguments: list[str] | None = None) -> int:
    """Runs the command line and returns its exit code; every error is one line for people."""
    if arguments is not None:
        return _run(arguments)
    open_closed()
    stopping.install()
    code = _run(sys.argv[1:])
    give_up()
    stopping.finish(code)
    return code


def _run(arguments: list[str]) -> int:
    own_output()
    debug, as_json = "--debug" in arguments, _wants_json(arguments)
    stopped = _stopped(arguments)
    try:
        stopping.begin(partial(_fail, stopped, as_json, sys.stdout, sys.stderr))  # bars put others in their place
        cli.main(arguments, prog_name="mcsl", standalone_mode=False)
        return 0
    except click.exceptions.Exit as done:
        return done.exit_code
    except (KeyboardInterrupt, click.Abort, Cancelled):
        stopping.tell_once()
        return stopped.exit_code
    except click.ClickException as error:
        if isinstance(error, click.UsageError) and not as_json:
            said = io.StringIO()
            error.show(said)
            click.echo(told(said.getvalue()), err=True, nl=False)
            return 2
        return _fail(UsageError(error.format_message()), as_json)
    except McslError as error:
        if debug:
            raise
        return _fail(error, as_json)
    except BrokenPipeError:
        return 0
    except Exception as error:
        if stopping.was_asked():  # an import, say, turned the interrupt into an error of its own
            stopping.tell_once()
            return stopped.exit_code
        if debug:
            raise
        return _fail(_told(error, arguments), as_json)


def _told(error: Exception, arguments: list[str]) -> McslError:
    """What people can do about an error that is none of ours."""
    command = next((f"mcsl {a}" for a in arguments if a in cli.commands), "mcsl")
    if isinstance(error, MemoryError) or "OutOfMemoryError" in str(error) or "Insufficient memory" in str(error):
        told = f" ({error})" if str(error) else ""
        remedy = "Close other programs, take fewer --jobs or smaller pictures, or a machine with more memory"
        return McslError(f"the memory does not suffice{told}", where=command, remedy=remedy)
    if isinstance(error, OSError) and error.filename is not None:
        remedy = "Check the path, its permissions and the room on the disk"
        return McslError(f"{error.strerror or error}", where=os.fsdecode(str(error.filename)), remedy=remedy)
    if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EIO):
        remedy = "Make room on the disks that are written to, that of its output too"
        return McslError(f"{error.strerror}", where=command, remedy=remedy)
    if isinstance(error, RuntimeError) and str(error).startswith("Symlink loop from "):
        where = str(error).removeprefix("Symlink loop from ").strip("'")
        return McslError("is a link that leads to itself", where=where, remedy="Correct the link")
    return McslError(
        f"{type(error).__name__}: {error}",
        where="internal error",
        remedy="Run again with `mcsl --debug ...` and report what it shows",
    )


def _stopped(arguments: list[str]) -> Cancelled:
    """What is said when the command is stopped: whether the same one would carry on."""
    command = next((word for word in arguments if word in cli.commands), None)
    return Cancelled(carries_on=command in _CARRY_ON and "--no-cache" not in arguments)


def _wants_json(arguments: list[str]) -> bool:
    return "--progress=json" in arguments or ("--progress", "json") in pairwise(arguments)


def _fail(error: McslError, as_json: bool, out: IO[str] | None = None, err: IO[str] | None = None) -> int:
    try:
        if as_json:
            JsonLines(out or sys.stdout).error(*_parts(error), error.exit_code)
    except OSError:  # nobody reads it
        as_json = False
    if not as_json:
        print(f"mcsl: {_sentence(error)}", file=err or sys.stderr, flush=True)
    return error.exit_code


def _parts(error: McslError) -> tuple[str, str, str]:
    """What, where and what to do, in the user's language."""
    return told(error.what), told(error.where), told(error.remedy)


def _sentence(error: McslError) -> str:
    if not is_japanese():
        return str(error)
    what, where, remedy = _parts(error)
    stop = "" if what.endswith("\n") else "。"  # after another program's own lines
    return (f"{where}: " if where else "") + (f"{what.rstrip('。')}{stop}{remedy}" if remedy else what)


if __name__ == "__main__":
    sys.exit(main())
