"""reference/command-line.md: every command with its help, as click itself tells it; see generate.py."""

from __future__ import annotations

import html
import inspect
from collections.abc import Iterator

import click

INTRODUCTION = """\
# The command line

<!-- Written by docs/generate.py from the commands in mcsl_core/cli; change it there. -->

    recording --analyse--> EDL --timeline--> edit.blend --pull--> overrides --render--> video

`mcsl --help` (or `-h`) and `mcsl COMMAND --help` say the same as this page. Options of `mcsl` itself stand before the
command: `mcsl --progress json analyse ...`.

**Exit codes**: 0 done, 2 wrong call, 3 input refused, 4 failed, 130 stopped. An error is one line that says what
happened, where, and what to do next. A stop or a failure leaves nothing half-written; the same command carries on.

**Language**: help, errors, notes and results are in Japanese where the environment says so (`LANGUAGE`, `LC_ALL`,
`LC_MESSAGES`, `LANG`, in this order: `LANGUAGE=ja mcsl --help`; on Windows set `LANGUAGE`), else in English. With
`--progress json` the names of stages stay English, with the Japanese as `shown`; `note` and `error` are Japanese.
Documents, reports and logs are in English.
"""


def commands(
    command: click.Command, parent: click.Context | None = None
) -> Iterator[tuple[click.Command, click.Context]]:
    """``command`` and all below it, in the order they are listed in; each with the context its help is made in."""
    name = command.name if parent else "mcsl"
    ctx = click.Context(command, info_name=name, parent=parent, **command.context_settings)
    yield command, ctx
    if isinstance(command, click.Group):
        for name in command.list_commands(ctx):
            below = command.get_command(ctx, name)
            if below is not None and not below.hidden:
                yield from commands(below, ctx)


def cell(text: str) -> str:
    """Text for a cell of a table."""
    return " ".join(html.escape(text, quote=False).replace("|", "&#124;").split())


def help_text(command: click.Command) -> str:
    """The help as Markdown; a paragraph that click must not wrap becomes a block of code."""
    parts = []
    for part in inspect.cleandoc(command.help or "").split("\n\n"):
        if part.startswith("\b"):
            parts.append("\n".join(f"    {line}" for line in part.splitlines()[1:]))
        else:
            parts.append(part)
    return "\n\n".join(parts)


def options(command: click.Command, ctx: click.Context) -> str:
    """A table of the options, none where there are none."""
    records = [option.get_help_record(ctx) for option in command.params if isinstance(option, click.Option)]
    rows = [f"| <code>{cell(names)}</code> | {cell(meaning)} |" for names, meaning in filter(None, records)]
    return "\n".join(["| option | meaning |", "|---|---|", *rows, ""]) if rows else ""


def section(command: click.Command, ctx: click.Context) -> str:
    usage = " ".join([ctx.command_path, *command.collect_usage_pieces(ctx)])
    return f"## {ctx.command_path}\n\n```text\n{usage}\n```\n\n{help_text(command)}\n\n{options(command, ctx)}"


def command_line_page() -> str:
    from mcsl_core.cli.main import cli

    return "\n".join([INTRODUCTION, *(section(command, ctx) for command, ctx in commands(cli))])
