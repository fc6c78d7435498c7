"""An archive's rendering as a template of Open Job Description, which render farms take: conform, render, join.

Blender's own nodes render ranges of frames of a timeline, without sound, and the sound once: a lossy sound does not end
with the last picture of a piece. What is rendered is the operation's ``edit.blend`` where an editor has made one, as it
stands, else a timeline that the farm makes of its EDL.
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from math import ceil
from pathlib import Path
from typing import Any

from attrs import frozen

from mcsl_core import edl as edls
from mcsl_core.delivery.presets import Preset, preset_of
from mcsl_core.errors import DocumentError, InputError, UsageError
from mcsl_core.progress import Progress
from mcsl_core.timing import FrameRange

from .run import Work

PIECE = 600  # frames: some minutes of a node's time
_MOST = 1024  # values of one task parameter: the specification's bound
# What mixes the preset's sound: container and codec in Blender's words, and the file's suffix.
_MIXED = {
    "AAC": ("MATROSKA", "AAC", "mka"),
    "FLAC": ("FLAC", "FLAC", "flac"),
    "PCM": ("WAV", "PCM", "wav"),
}
_SILENT = "import bpy; bpy.context.scene.render.ffmpeg.audio_codec = 'NONE'"
_MIX = (
    "import bpy; bpy.ops.sound.mixdown(filepath=r'{{Param.Results}}/{{Task.Param.Operation}}/pieces/"
    "sound.{{Task.Param.Suffix}}', container='{{Task.Param.Container}}', codec='{{Task.Param.Codec}}', format='S16', "
    "bitrate=192, accuracy=1024)"
)


@frozen
class Film:
    """What the farm is told of one operation."""

    key: str
    frames: int
    parts: int
    quality: str
    audio: str
    preset_name: str
    preset: Preset
    video: str
    edited: bool

    @property
    def blend(self) -> str:
        return "edit.blend" if self.edited else "farm.blend"


def film_of(work: Work, out: Path) -> Film | None:
    """What the farm is told of an operation; None where it has no EDL yet, DocumentError where it cannot render it."""
    folder = out / work.operation.key
    if not (folder / "edl.json").is_file() or work.job.facts.fault:
        return None
    edl, options = edls.read(folder / "edl.json"), work.operation.options
    if edl.removed:
        raise DocumentError("stretches are removed, and Blender alone renders the whole programme", where=str(folder))
    name = options.get("preset", "h264")
    preset = preset_of(name)
    if preset.blender.audio_codec not in _MIXED:
        raise UsageError(f"the sound of the preset {name} cannot be mixed by itself", remedy="Take h264 or prores")
    audio = options.get("audio") or edl.audio_from or edl.reference
    edited = (folder / "edit.blend").is_file()
    quality = options.get("quality", "standard")
    return Film(work.operation.key, edl.frames, work.job.parts, quality, audio, name, preset, work.job.video, edited)


def template(films: Sequence[Film], results: str, *, length: int = PIECE) -> dict[str, Any]:
    """The job template for these operations, in pieces of ``length`` frames or more.

    results: their folder, relative to the template's.

    Raises
    ------
    UsageError
        Where they are more than one template may hold.
    """
    while sum(ceil(film.frames / length) for film in films) > _MOST and length < 1 << 24:
        length *= 2
    pieces = [(film, piece) for film in films for piece in _ranges(film.frames, length)]
    parts = [(film, part) for film in films for part in range(1, film.parts + 1)]
    if max(len(pieces), len(parts)) > _MOST:
        raise UsageError(
            f"a template holds {_MOST} tasks a step, these operations want {max(len(pieces), len(parts))}",
            remedy="Hand the archive over in parts: a folder of fewer operations at a time",
        )
    new = [film for film in films if not film.edited]
    steps = [
        _step("Conform", _conform(parts), "Mcsl", _CONFORM),
        *([_step("Timeline", _each(new, preset="preset_name"), "Mcsl", _TIMELINE, after=["Conform"])] if new else []),
        _step("Render", _render(pieces), "Blender", _RENDER, after=["Timeline" if new else "Conform"]),
        _step("Sound", _sound(films), "Blender", _SOUND, after=["Timeline" if new else "Conform"]),
        _step("Join", _each(films, video="video"), "Mcsl", _JOIN, after=["Render", "Sound"]),
    ]
    return {
        "specificationVersion": "jobtemplate-2023-09",
        "name": f"mcsl: {len(films)} operations" if len(films) > 1 else f"mcsl: {films[0].key}",
        "parameterDefinitions": [
            {"name": "Results", "type": "PATH", "objectType": "DIRECTORY", "dataFlow": "INOUT", "default": results},
            {"name": "Mcsl", "type": "STRING", "default": "mcsl"},
            {"name": "Blender", "type": "STRING", "default": "blender"},
        ],
        "steps": steps,
    }


def template_text(works: Sequence[Work], out: Path, path: Path, progress: Progress) -> str:
    """The text of the template at ``path`` (JSON, which is YAML too); InputError where no operation has an EDL.

    Operations whose EDL cannot be read are left out, and told of.
    """
    films = []
    for work in works:
        try:
            film = film_of(work, out)
        except DocumentError as error:
            progress.note(f"{work.operation.key} is left out: {error}")
            continue
        films += [] if film is None else [film]
    if not films:
        raise InputError(
            "holds no operation with an EDL", where=str(out), remedy="Run `mcsl archive` without --openjd first"
        )
    results = Path(os.path.relpath(out.resolve(), path.resolve().parent)).as_posix()
    return json.dumps(template(films, results), indent=1, ensure_ascii=False) + "\n"


_FOLDER = "{{Param.Results}}/{{Task.Param.Operation}}"
_CONFORM = ["conform", f"{_FOLDER}/edl.json", "--part", "{{Task.Param.Part}}", "--quality", "{{Task.Param.Quality}}"]
_CONFORM += ["--audio", "{{Task.Param.Audio}}", "--allow-outside"]
_TIMELINE = ["timeline", f"{_FOLDER}/edl.json", "-o", f"{_FOLDER}/farm.blend", "--preset", "{{Task.Param.Preset}}"]
_TIMELINE += ["--allow-outside"]
_RENDER = ["-b", _FOLDER + "/{{Task.Param.Blend}}", "--python-exit-code", "1", "--python-expr", _SILENT]
_RENDER += ["-o", _FOLDER + "/pieces/{{Task.Param.Piece}}", "-s", "{{Task.Param.First}}", "-e", "{{Task.Param.Last}}"]
_RENDER += ["-a"]
_SOUND = ["-b", _FOLDER + "/{{Task.Param.Blend}}", "--python-exit-code", "1", "--python-expr", _MIX]
_JOIN = ["join", f"{_FOLDER}/pieces", "-o", _FOLDER + "/{{Task.Param.Video}}"]


def _step(
    name: str, lists: dict[str, list[str]], command: str, arguments: list[str], *, after: Sequence[str] = ()
) -> dict[str, Any]:
    """A step whose tasks take the first values of all lists, the second ones, and so on."""
    definitions = [{"name": key, "type": "STRING", "range": values} for key, values in lists.items()]
    return {
        "name": name,
        **({"dependencies": [{"dependsOn": step} for step in after]} if after else {}),
        "parameterSpace": {"taskParameterDefinitions": definitions, "combination": f"({', '.join(lists)})"},
        "script": {"actions": {"onRun": {"command": f"{{{{Param.{command}}}}}", "args": arguments}}},
    }


def _each(films: Sequence[Film], **names: str) -> dict[str, list[str]]:
    """One task an operation, with some of its attributes."""
    named = {name.capitalize(): [str(getattr(film, attribute)) for film in films] for name, attribute in names.items()}
    return {"Operation": [film.key for film in films], **named}


def _conform(parts: Sequence[tuple[Film, int]]) -> dict[str, list[str]]:
    films = [film for film, _ in parts]
    return {**_each(films, quality="quality", audio="audio"), "Part": [f"{part}/{film.parts}" for film, part in parts]}


def _render(pieces: Sequence[tuple[Film, FrameRange]]) -> dict[str, list[str]]:
    return {
        **_each([film for film, _ in pieces], blend="blend"),
        "Piece": [f"{p.start + 1:07d}-{p.stop:07d}.{film.preset.container}" for film, p in pieces],
        "First": [str(piece.start + 1) for _, piece in pieces],  # Blender counts from 1
        "Last": [str(piece.stop) for _, piece in pieces],
    }


def _sound(films: Sequence[Film]) -> dict[str, list[str]]:
    mixed = [_MIXED[film.preset.blender.audio_codec] for film in films]
    named = {name: [how[at] for how in mixed] for at, name in enumerate(("Container", "Codec", "Suffix"))}
    return {**_each(films, blend="blend"), **named}


def _ranges(frames: int, length: int) -> list[FrameRange]:
    return [FrameRange(start, min(start + length, frames)) for start in range(0, frames, length)]


def pieces_in(folder: Path, suffix: str, frames: int | None = None) -> dict[Path, int]:
    """The pieces in a folder in order, and how many frames each has by its name.

    Raises
    ------
    InputError
        Where they are not the whole programme, of ``frames`` where that is known, from its first frame on.
    """
    found = sorted(folder.glob(f"[0-9]*-[0-9]*{suffix}"))
    after, lengths = 0, dict[Path, int]()
    for path in found:
        first, _, last = path.stem.partition("-")
        if not (first.isdigit() and last.isdigit()) or int(first) != after + 1:
            raise InputError(f"does not follow frame {after}", where=str(path), remedy="Empty the folder, render again")
        lengths[path] = int(last) - after
        after = int(last)
    if not found:
        raise InputError(f"holds no pieces (0000001-0000600{suffix})", where=str(folder), remedy="Render them first")
    if frames is not None and after != frames:
        what = f"holds frames up to {after}, the programme has {frames}"
        raise InputError(what, where=str(folder), remedy="Render what is missing, or empty the folder and render again")
    return lengths


def sound_in(folder: Path) -> Path | None:
    """The sound that lies beside the pieces."""
    return next(
        iter(sorted(path for _, _, kind in _MIXED.values() if (path := folder / f"sound.{kind}").is_file())), None
    )
