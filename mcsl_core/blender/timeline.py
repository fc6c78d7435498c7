"""EDL -> .blend, and the editor's decisions in a .blend -> the EDL it was built from. Blender works in a child."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mcsl_core import edl as edls
from mcsl_core.delivery import presets
from mcsl_core.delivery.audio import sound_key
from mcsl_core.delivery.chunk_keys import Chunk, chunks_present, media_fingerprints
from mcsl_core.delivery.conform import default_folder
from mcsl_core.delivery.presets import Preset
from mcsl_core.documents import write_atomic
from mcsl_core.edl import Edl
from mcsl_core.edl.edits import rebased
from mcsl_core.errors import InputError, UsageError
from mcsl_core.hooks.registry import filler_of
from mcsl_core.progress import Progress, Silent

from .child import run_task
from .installation import Blender


def build_timeline(
    edl_path: Path,
    blend_path: Path,
    *,
    blender: Blender,
    preset: str | Path | Preset = "h264",
    conformed: Path | None = None,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Builds the timeline of an EDL; the .blend is replaced whole or not at all.

    conformed: folder of conformed media; None takes the one beside the EDL. Those of its files that belong to the EDL
    as it is are put in place, the rest of the programme shows Blender's preview. Returns {"blend", "strips",
    "frames", "conformed"}. Raises InputError for a wrong EDL or missing media, BlenderError when Blender fails.
    """
    edl = edls.load(edl_path)
    _check_blend_name(blend_path)
    folder = conformed if conformed is not None else default_folder(edl_path)
    if conformed is not None and not folder.is_dir():
        raise InputError("is not a folder", where=str(folder), remedy="Make it with `mcsl conform`")
    pieces, sound = in_place(edl, edl_path.parent, folder)
    request = timeline_request(edl_path, blend_path, pieces, sound)
    kind = preset if isinstance(preset, Preset) else presets.load_preset(preset)
    request |= {"task": "timeline", "preset": kind.for_blender(), "output": f"{blend_path.stem}.{kind.container}"}
    blend_path.parent.mkdir(parents=True, exist_ok=True)
    return {**run_task(blender, request, progress), "conformed": len(pieces)}


def pull_overrides(
    blend_path: Path, edl_out: Path | None = None, *, blender: Blender, progress: Progress | None = None
) -> Edl:
    """Reads the editor's decisions into the EDL that the .blend names, or into a copy of it at ``edl_out``.

    Nothing but overrides and corrections changes; where nothing was decided anew, the file is left as it is, to the
    byte. Raises InputError naming strip and frame of what cannot be read; nothing is written then.
    """
    return pull_from(blend_path, edl_out, blender=blender, progress=progress)[1]


def pull_from(
    blend_path: Path, edl_out: Path | None = None, *, blender: Blender, progress: Progress | None = None
) -> tuple[Path, Edl]:
    """As `pull`; also returns where the EDL lies that was written."""
    progress = progress or Silent()
    _check_blend_name(blend_path)
    progress.stage("reading the timeline")
    found = run_task(blender, {"task": "read", "blend": str(blend_path.resolve())}, progress)
    edl_path = Path(found["edl"])
    edl = edls.load(edl_path)
    target = edl_path if edl_out is None else edl_out
    if found["changed"]:
        value = edls.to_json(edl)
        decided = {name: found[name] for name in ("overrides", "corrections", "look")}
        edl = edls.from_json({**value, **decided}, where=str(blend_path))
    if target.resolve() == edl_path.resolve():
        if found["changed"]:
            edls.save(edl, target)
        return target, edl
    moved = rebased(edl, edl_path.parent, target.parent)
    if moved == edl and not found["changed"]:
        write_atomic(target, edl_path.read_bytes())
    else:
        edls.save(moved, target)
    return target, moved


def timeline_request(
    edl_path: Path, blend_path: Path, pieces: list[dict[str, Any]], sound: str | None
) -> dict[str, Any]:
    """What the tasks `timeline` and `refresh` share; paths absolute."""
    return {
        "edl": str(edl_path.resolve()),
        "blend": str(blend_path.resolve()),
        "conformed": pieces,
        "sound": sound,
    }


def in_place(edl: Edl, base: Path, folder: Path) -> tuple[list[dict[str, Any]], str | None]:
    """The conformed files in ``folder`` that belong to ``edl`` as it is: their ranges and paths, and the sound's.

    Of each stretch the one of the finest quality that is there, whatever quality was conformed last.
    """
    if not folder.is_dir():
        return [], None
    folder = folder.resolve()
    pieces = [piece_of(chunk, folder) for chunk in chunks_present(edl, base, folder, filler=filler_of(edl))]
    camera = edl.reference
    sound = folder / f"sound-{sound_key(edl, camera, media_fingerprints(edl.camera(camera), base))}.wav"
    return pieces, str(sound) if sound.is_file() else None


def piece_of(chunk: Chunk, folder: Path) -> dict[str, Any]:
    """A conformed chunk as the tasks take it."""
    return {"range": [chunk.range.start, chunk.range.stop], "path": str(folder / chunk.name)}


def _check_blend_name(path: Path) -> None:
    if path.suffix != ".blend":
        raise UsageError("a timeline's name ends in .blend", where=str(path), remedy="Name it so, such as edit.blend")
