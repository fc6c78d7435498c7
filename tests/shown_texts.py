"""Where the command line shows texts to a person: which of the source's texts `mcsl_core/cli/japanese` must have."""

from __future__ import annotations

import ast
import inspect
import itertools
from collections.abc import Iterator
from pathlib import Path

from source_texts import Function, Sources

from mcsl_core.hooks.registry import discover

ROOT = Path(__file__).resolve().parent.parent
CLI = ROOT / "mcsl_core" / "cli"

# Errors of a programmer, who reads English: these never come from a file or an option.
PROGRAMMERS = (
    "mcsl_core/alignment/colour_match.py",
    "mcsl_core/alignment/protocol.py",
    "mcsl_core/api/entry.py",
    "mcsl_core/api/fields.py",
    "mcsl_core/api/stills.py",
    "mcsl_core/api/views.py",
    "mcsl_core/imaging/planes.py",
    "mcsl_core/movement/protocol.py",
    "mcsl_core/occlusion/score_table.py",
    "mcsl_core/recording/footage.py",
)
# What is made in one place and told in another: functions by their file.
SAID = {
    "mcsl_core/alignment/joint.py": ["_diagnosis"],
    "mcsl_core/analysis/summary.py": ["describe", "_fields"],
    "mcsl_core/archive/run.py": ["describe", "_time"],
    "mcsl_core/archive/job.py": ["_made"],
    "mcsl_core/blender/installation.py": ["__str__"],
    "mcsl_core/blender/preview.py": ["_told", "preview_notes"],
    "mcsl_core/centering/gaze_files.py": ["__str__", "_in_frames", "_in_pixels"],
    "mcsl_core/cli/commands/field.py": ["describe"],
    "mcsl_core/cli/commands/look.py": ["describe"],
    "mcsl_core/cli/commands/remove.py": ["describe"],
    "mcsl_core/cli/demo.py": ["_text"],
    "mcsl_core/documents.py": ["__str__", "describe_faults"],
    "mcsl_core/edl/edits.py": ["other_media"],
    "mcsl_core/hooks/registry.py": ["_loaded"],
    "mcsl_core/hooks/watch.py": ["spent"],
    "mcsl_core/interchange/changes.py": ["notes", "_cover_note", "_marker_notes"],
    "mcsl_core/interchange/cmx_reading.py": ["*"],
    "mcsl_core/interchange/export.py": ["_notes"],
    "mcsl_core/interchange/fcpxml_reading.py": ["*"],
    "mcsl_core/interchange/found.py": ["__str__"],
    "mcsl_core/interchange/heard.py": ["*"],
    "mcsl_core/interchange/otio_reading.py": ["*"],
    "mcsl_core/interchange/pull.py": ["told", "_named"],
    "mcsl_core/interchange/seen.py": ["*"],
    "mcsl_core/interchange/three_way.py": ["*"],
    "mcsl_core/interchange/xmeml_reading.py": ["*"],
    "mcsl_core/media/tracks.py": ["__str__"],
    "mcsl_core/outputs/locks.py": ["_holder", "in_turn"],
    "mcsl_core/recording/cameras.py": ["_describe_files", "_describe_crops"],
    "mcsl_core/recording/damage.py": ["with_gaps"],
    "mcsl_core/recording/joining.py": ["describe_joins"],
    "mcsl_core/recording/sound_track.py": ["*"],
    "mcsl_core/sync/motion.py": ["_diagnosis"],
    "blender_addon/core/field.py": ["_frames", "remarks_on_drawing"],
    "blender_addon/core/outside.py": ["remark_on"],
    "blender_addon/core/overruled.py": ["*"],
    "blender_addon/core/times.py": ["remarks"],
    "blender_addon/sequencer/build.py": ["build_camera"],
    "blender_addon/sequencer/notices.py": ["*"],
    "blender_addon/sequencer/read.py": ["_remarks"],
    "blender_addon/sequencer/read_times.py": ["_odd"],
    "blender_addon/sequencer/renew.py": ["*"],
    "blender_addon/sequencer/sound.py": ["*"],
    "blender_addon/sequencer/touched.py": ["*"],
    "blender_addon/worker/confine.py": ["*"],
}
"""``*``: all its functions."""
TABLES = {
    "mcsl_core/edl/playlists.py": ["_LISTS"],
    "mcsl_core/evaluation/metrics.py": ["FOLLOWED", "MATCHED"],
    "mcsl_core/input_files.py": ["_SIGNATURES", "_KINDS"],
}
"""Constants that hold phrases which fill other texts."""


def sources() -> Sources:
    """What runs under `mcsl`: mcsl_core, and of the add-on what Blender runs for it."""
    paths = [p for p in (ROOT / "mcsl_core").rglob("*.py") if not {"japanese", "templates"} & set(p.parts)]
    for folder in ("core", "worker", "sequencer"):
        paths += (ROOT / "blender_addon" / folder).rglob("*.py")
    return Sources.of(ROOT, sorted(paths))


def messages(found: Sources) -> None:
    """Errors, notes, stages and results."""
    for name in found.descended_from("McslError", "Fault", "Refusal", "ValueError", "ClickException"):
        for call, within, module in found.calls(name):
            if str(module.path) in PROGRAMMERS:
                continue
            given = {k.arg: k.value for k in call.keywords}
            found.show(call.args[0] if call.args else given.get("what"), within, module)
            if name != "ValueError":
                found.show(given.get("remedy"), within, module)
                found.show(given.get("where"), within, module, whole=False)
    for name, places in {"note": [0], "stage": [0], "fail": [0], "result": [1], "need": [1], "told": [0]}.items():
        for call, within, module in found.calls(name):
            if name == "told" and "cli" not in module.path.parts:
                continue
            for place in places:
                found.show(call.args[place] if len(call.args) > place else None, within, module)
    for call, within, module in found.calls("__init__"):
        if str(module.path) == "mcsl_core/errors.py":  # an error with words of its own
            for node in (*call.args[:1], *(k.value for k in call.keywords)):
                found.show(node, within, module)
    for module in found.modules:
        for name in TABLES.get(str(module.path), ()):
            for node in itertools.chain.from_iterable(map(ast.walk, module.assigned[name])):
                if isinstance(node, ast.Constant) and isinstance(node.value, str):
                    found.show(node, None, module, whole=False)
    for call, within, module in found.calls("append"):
        if isinstance(call.func, ast.Attribute) and ast.unparse(call.func.value).endswith("notes"):
            found.show(call.args[0], within, module)
    for call, within, module in found.calls("Stage"):
        for node in call.args[3:5]:
            found.show(node, within, module)
    for function in _said(found):
        found.say(function)
    for call, within, module in found.calls("stage"):
        given = {k.arg: k.value for k in call.keywords}
        found.show(call.args[2] if len(call.args) > 2 else given.get("unit"), within, module)


def _said(found: Sources) -> Iterator[Function]:
    for function in found.all_functions():
        names = SAID.get(str(function.module.path), [])
        if function.node.name in names or names == ["*"]:
            yield function


def help_texts(found: Sources) -> None:
    """What --help says: the commands', and their options'."""
    for call, within, module in list(found.calls()):
        given = {k.arg: k.value for k in call.keywords}
        if "cli" in module.path.parts and "help" in given:
            found.show(given["help"], within, module)
    for function in found.all_functions():
        if _is_command(function.node):
            found.found[inspect.cleandoc(ast.get_docstring(function.node) or "")].add(str(function.module.path))
    for offer in discover().offers:
        if offer.package == "mcsl":
            found.found[offer.summary].add("mcsl plugins")


def _is_command(node: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    called = [d.func for d in node.decorator_list if isinstance(d, ast.Call)]
    return any(isinstance(f, ast.Attribute) and f.attr in ("command", "group") for f in called)
