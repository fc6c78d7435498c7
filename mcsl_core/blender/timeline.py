"""EDL -> .blend, and the editor's decisions in a .blend -> the EDL it was built from. Blender works in a child."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import attrs
from attrs import field, frozen

from mcsl_core import edl as edls
from mcsl_core.delivery.audio import sound_key
from mcsl_core.delivery.chunk_keys import Chunk, chunks_present, media_fingerprints
from mcsl_core.delivery.conform import default_folder
from mcsl_core.delivery.presets import Preset, preset_of
from mcsl_core.edl import NO_SOUND, Edl
from mcsl_core.edl.edits import DECISIONS, rebased
from mcsl_core.edl.resolve import sound_camera
from mcsl_core.errors import InputError, UsageError
from mcsl_core.hooks.registry import filler_of
from mcsl_core.input_files import check_file
from mcsl_core.outputs.claim import claim
from mcsl_core.outputs.inputs import inputs_of
from mcsl_core.outputs.locks import changing
from mcsl_core.outputs.manifest import Manifest
from mcsl_core.progress import Progress, Silent

from .child import run_task
from .installation import Blender
from .messages import BuiltTimeline, ConformedPiece, ReadDecisions, ReadRequest, TimelineRequest
from .preview import preview_notes

_TRIES = 3  # how often a timeline is read whose EDL others write meanwhile


@frozen(kw_only=True)
class TimelineSettings:
    """How a timeline is built.

    Parameters
    ----------
    blender
        The Blender to start.
    preset
        The output settings that the .blend is given: a name, the path of a preset file, or a preset.
    conformed
        Folder of conformed media; None takes the one beside the EDL.
    audio
        "none" for no sound at all; None for the reference camera's.
    force
        Replace a .blend that mcsl did not write, or that was changed since; it is kept as ``.blend1``.

    Raises
    ------
    UsageError
        There is no such preset, or ``audio`` is a camera.
    """

    blender: Blender
    preset: Preset = field(factory=lambda: preset_of("h264"), converter=preset_of)
    conformed: Path | None = field(default=None, converter=attrs.converters.optional(Path))
    audio: str | None = None
    force: bool = False

    def __attrs_post_init__(self) -> None:
        if self.audio not in (None, NO_SOUND):
            raise UsageError(
                f"a timeline has the sound that its EDL names or {NO_SOUND}, not that of {self.audio!r}",
                remedy="Choose it in Blender (mcsl, Render, Sound), or set audio_from in the EDL",
            )


def build_timeline(
    edl_path: Path, blend_path: Path, *, progress: Progress | None = None, **settings: Any
) -> BuiltTimeline:
    """Builds the timeline of an EDL; the .blend is replaced whole or not at all.

    One that was changed since mcsl wrote it holds an editor's work and is refused.

    Those conformed media that belong to the EDL as it is are put in place, the rest of the programme shows Blender's
    preview.

    Parameters
    ----------
    edl_path, blend_path
        The EDL, and the .blend to write.
    progress
        Where the work reports to.
    **settings
        The fields of `TimelineSettings`.

    Raises
    ------
    UsageError, InputError
        A setting or the EDL is wrong, media are missing, or the .blend may not be written over.
    BlenderError
        Blender failed.
    """
    progress, how = progress or Silent(), TimelineSettings(**settings)
    edl = edls.load(edl_path)
    _check_blend_name(blend_path)
    given = settings.get("preset")
    inputs = [*inputs_of(edl, edl_path), *([Path(given)] if isinstance(given, (str, Path)) else [])]
    output = claim(blend_path, inputs=inputs, manifest=Manifest.beside(edl_path), force=how.force)
    folder = how.conformed or default_folder(edl_path)
    if how.conformed is not None and not folder.is_dir():
        raise InputError("is not a folder", where=str(folder), remedy="Make it with `mcsl conform`")
    pieces, sound = in_place(edl, edl_path.parent, folder)
    with output.writing() as part:
        request = TimelineRequest(
            edl=edl_path.resolve(),
            blend=part,
            conformed=pieces,
            sound=sound,
            preset=how.preset,
            output=f"{blend_path.stem}.{how.preset.container}",
            silent=how.audio == NO_SOUND,
        )
        built = run_task(how.blender, request, progress)
        output.keep_backup()
    if edl.removed:
        progress.note("what is removed is marked on the timeline; rendered by Blender alone, it would be shown")
    for note in preview_notes(edl, edl_path.parent):
        progress.note(note)
    return attrs.evolve(built, blend=blend_path.resolve())


def pull_overrides(blend_path: Path, edl_out: Path | None = None, **how: Any) -> Edl:
    """Reads the editor's decisions into the EDL that the .blend names, or into a copy of it at ``edl_out``.

    Nothing but overrides, corrections, drawn fields and the look changes; where nothing was decided anew, the file is
    left as it is, to the byte. What others wrote into the EDL meanwhile stays. Takes what `pull_from` takes.

    Raises
    ------
    InputError
        Something in the timeline cannot be read; it names strip and frame. Or ``edl_out`` may not be written over.
        Nothing is written then.
    """
    return pull_from(blend_path, edl_out, **how)[1]


def pull_from(
    blend_path: Path,
    edl_out: Path | None = None,
    *,
    blender: Blender,
    force: bool = False,
    progress: Progress | None = None,
) -> tuple[Path, Edl]:
    """As `pull_overrides`; also returns where the EDL lies that was written.

    force: replace an ``edl_out`` that mcsl did not write, or that was changed since.
    """
    progress = progress or Silent()
    _check_blend_name(blend_path)
    check_file(blend_path, wanted="a timeline", remedy="Hand in the .blend file")
    if edl_out is not None:
        claim(edl_out, inputs=[blend_path], force=True)  # whose it is, is asked once the EDL is known
    instead = None if edl_out is None else edl_out.resolve()
    for left in reversed(range(_TRIES)):
        progress.stage("reading the timeline")
        began_ns = time.time_ns()
        decided = run_task(blender, ReadRequest(blend_path.resolve(), instead), progress)
        if not decided.changed and edl_out is None:
            return decided.edl, edls.load(decided.edl)
        target = decided.edl if edl_out is None else edl_out
        with changing(target):
            if decided.edl.stat().st_mtime_ns < began_ns:
                return target, _put(decided, target, blend_path, force)
        if not left:
            what, remedy = "is written again and again meanwhile", "Let the other program end, then pull"
            raise InputError(what, where=str(decided.edl), remedy=remedy)
        progress.note(f"{decided.edl} was written meanwhile, and is read again")
    raise AssertionError  # the last try returns or raises


def _put(decided: ReadDecisions, target: Path, blend: Path, force: bool) -> Edl:
    """Writes what was decided into the EDL it belongs to, or into a copy of that at ``target``."""
    edl = edls.load(decided.edl)
    inputs = (*inputs_of(edl, decided.edl), blend)
    if decided.changed:
        edl = attrs.evolve(edl, **{name: getattr(decided, name) for name in DECISIONS})
    if target.resolve() == decided.edl.resolve():
        if decided.changed:
            edls.save(edl, target)
        return edl
    output = claim(target, inputs=inputs, manifest=Manifest.beside(decided.edl), force=force)
    moved = rebased(edl, decided.edl.parent, target.parent)
    as_it_is = moved == edl and not decided.changed
    output.write(decided.edl.read_bytes() if as_it_is else edls.dumps(moved).encode())
    edls.remember(moved, target)
    return moved


def in_place(edl: Edl, base: Path, folder: Path) -> tuple[tuple[ConformedPiece, ...], Path | None]:
    """The conformed files in ``folder`` that belong to ``edl`` as it is, and the conformed sound.

    Of each stretch of the programme the file of the finest quality that is there, whatever was conformed last.

    Parameters
    ----------
    edl, base
        The EDL, and the folder its paths are relative to.
    folder
        Where conformed media lie, or would.
    """
    if not folder.is_dir():
        return (), None
    folder = folder.resolve()
    pieces = tuple(piece_of(chunk, folder) for chunk in chunks_present(edl, base, folder, filler=filler_of(edl)))
    camera = sound_camera(edl)
    if camera is None:
        return pieces, None
    sound = folder / f"sound-{sound_key(edl, camera, media_fingerprints(edl.camera(camera), base))}.wav"
    return pieces, sound if sound.is_file() else None


def piece_of(chunk: Chunk, folder: Path) -> ConformedPiece:
    """A conformed chunk that lies in ``folder``, as messages have it."""
    return ConformedPiece(chunk.range, folder / chunk.name)


def _check_blend_name(path: Path) -> None:
    if path.suffix != ".blend":
        raise UsageError("a timeline's name ends in .blend", where=str(path), remedy="Name it so, such as edit.blend")
