"""What the commands' options share."""

from __future__ import annotations

import inspect
import os
from pathlib import Path
from typing import Any

import click

from mcsl_core import edl as edls
from mcsl_core.hooks.stages import STAGES
from mcsl_core.input_files import name_fault

from .language import is_japanese, told


class _Path(click.Path):
    """A path that a file can have at all: what cannot be is a wrong call, not a failure after the work."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if fault := name_fault(os.fspath(value)):
            shown = str(value).replace("\0", "\\0")[:60]
            self.fail(f"{shown!r}... {fault}", param, ctx)
        return super().convert(value, param, ctx)


PATH = _Path(path_type=Path)
FORCE = click.option("--force", is_flag=True, help="Replace a file that mcsl did not write or that was changed since.")


def _allow(ctx: click.Context, _parameter: click.Parameter, given: bool) -> None:
    if given:
        ctx.with_resource(edls.allowed_outside())


allow_outside = click.option(
    "--allow-outside",
    is_flag=True,
    expose_value=False,
    is_eager=True,
    callback=_allow,
    help="The EDL's media may lie outside of its folder, though it was not made here; remembered.",
)

audio_option = click.option(
    "--audio",
    metavar="CAMERA",
    help="Whose sound is taken; none: no sound (default: as the EDL says).",
)


hwaccel_option = click.option(
    "--hwaccel",
    metavar="KIND",
    default="none",
    help="Hardware that decodes, and encodes with render --engine direct: auto, or as FFmpeg names it (cuda, vaapi).",
)


class _Context(click.Context):
    """Where a command runs: its help is in the user's language."""

    def make_formatter(self) -> click.HelpFormatter:
        if not is_japanese():
            return super().make_formatter()
        from .wide_help import WideHelp

        return WideHelp(width=self.terminal_width, max_width=self.max_content_width)


class Commands(click.Group):
    """Lists the commands in the order of the work, not of the alphabet, and in the user's language."""

    context_class = _Context

    def add_command(self, cmd: click.Command, name: str | None = None) -> None:
        cmd.context_class = _Context
        super().add_command(cmd, name)

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self.commands)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        if not is_japanese():
            super().format_commands(ctx, formatter)
            return
        rows = []
        for name in self.list_commands(ctx):  # click would cut their first sentences short before they are told
            first, *_ = told(inspect.cleandoc(self.commands[name].help or "")).splitlines()
            rows.append((name, first.removesuffix("。")))
        with formatter.section("Commands"):
            formatter.write_dl(rows)


def stage_options(command: Any) -> Any:
    """--movement NAME, --occlusion NAME, ...: which plugin does each stage."""
    for name, stage in reversed(list(STAGES.items())):
        text = f"Plugin that {stage.purpose} (default: {stage.default})."
        command = click.option(f"--{name}", metavar="NAME", help=text)(command)
    return command
