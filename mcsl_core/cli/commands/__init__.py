"""The commands, one module each, in the order of the work."""

import click

from .analyse import analyse
from .archive import archive
from .blender import blender_group
from .conform import conform
from .demo import demo
from .evaluate import evaluate
from .export import export
from .field import field
from .join import join
from .look import look
from .plugin import plugin_group
from .plugins import list_plugins
from .remove import remove
from .render import render
from .report import report
from .simulate import simulate
from .timeline import pull, timeline

COMMANDS: tuple[click.Command, ...] = (
    demo,
    simulate,
    analyse,
    timeline,
    field,
    look,
    remove,
    pull,
    conform,
    export,
    render,
    evaluate,
    report,
    archive,
    join,
    list_plugins,
    plugin_group,
    blender_group,
)
