"""EDL or .blend -> the delivered video: pull, conform, put the exact pictures in place, render.

Two engines make the same programme: Blender renders the timeline with whatever the editor laid above it; `direct`
writes the programme without Blender and without what is above. tests/blender/test_render.py holds them together.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from mcsl_core import edl as edls
from mcsl_core.blender import installation as blenders
from mcsl_core.delivery import presets
from mcsl_core.delivery.conform import Conformed, conform, default_folder
from mcsl_core.delivery.direct import VideoFormat, write_direct
from mcsl_core.delivery.presets import Preset
from mcsl_core.delivery.quality import Quality, quality_named
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.edl import Edl
from mcsl_core.errors import InputError, UsageError
from mcsl_core.filling.provenance import ShowProvenance
from mcsl_core.hooks.registry import filler_of
from mcsl_core.media.writing import Encoding
from mcsl_core.progress import Progress, Silent

from .child import run_task
from .installation import Blender
from .timeline import piece_of, pull_from, timeline_request

ENGINES = ("blender", "direct")
AUDIO_CHANNELS = 2  # what Blender writes


def render(
    source: Path,
    out: Path,
    *,
    preset: str | Path | Preset = "h264",
    engine: str = "blender",
    blender: str | Blender | None = None,
    quality: str = "standard",
    jobs: int | None = None,
    show_origin: bool = False,
    progress: Progress | None = None,
) -> Path:
    """Renders an EDL (.json) or a timeline (.blend) to ``out``; a video that was there is replaced whole or not at all.

    A .blend is pulled into the EDL it names, conformed, and saved with the exact pictures in place; its own output
    settings stay. Conformed media are kept beside the EDL and used again. blender: a path, or None for the first found.
    quality: of the conformed pictures, see `quality`; without Blender it chooses the resampling alone. jobs: chunks
    made at the same time, None for one a core. show_origin: a review copy, each camera's pixels in a tint of their own;
    `direct` alone does that. Raises UsageError for a wrong call, and what pulling, conforming and
    Blender raise.
    """
    progress = progress or Silent()
    kind = preset if isinstance(preset, Preset) else presets.load_preset(preset)
    pictures = quality_named(quality)
    _check(source, out, kind, engine)
    if show_origin and engine != "direct":
        raise UsageError(
            "a review copy that shows where pixels come from is made directly", remedy="Add --engine direct"
        )
    needed = engine == "blender" or source.suffix == ".blend"
    found = blender if isinstance(blender, Blender) else blenders.find(blender) if needed else None
    edl_path = source
    if source.suffix == ".blend" and found is not None:
        edl_path, edl = pull_from(source, blender=found, progress=progress)
    else:
        edl = edls.load(source)
    out.parent.mkdir(parents=True, exist_ok=True)
    if engine == "direct" or found is None:
        _direct(edl, edl_path, out, kind, pictures, show_origin, progress)
        return out
    folder = default_folder(edl_path)
    programme = ProgrammeSource(edl, edl_path.parent, filler_of(edl, progress))
    done = conform(programme, folder, jobs=jobs, quality=pictures, progress=progress)
    if source.suffix == ".blend":
        _put_in_place("refresh", edl_path, source, done, kind, found, progress)
        _in_blender(source, out, kind, found, progress)
    else:
        with tempfile.TemporaryDirectory(prefix="mcsl-render-") as folder:
            blend = Path(folder) / "programme.blend"
            _put_in_place("timeline", edl_path, blend, done, kind, found, progress)
            _in_blender(blend, out, kind, found, progress)
    return out


def _check(source: Path, out: Path, kind: Preset, engine: str) -> None:
    """Everything that can be wrong with the call, before any work."""
    if engine not in ENGINES:
        raise UsageError(f"there is no engine {engine!r}", remedy=f"Take one of {', '.join(ENGINES)}")
    if source.suffix not in (".json", ".blend"):
        raise UsageError("is neither an EDL (.json) nor a timeline (.blend)", where=str(source))
    if not source.is_file():
        raise InputError("is missing", where=str(source), remedy="Make it with `mcsl analyse` or `mcsl timeline`")
    if out.suffix != f".{kind.container}":
        raise UsageError(
            f"the preset writes .{kind.container} files",
            where=str(out),
            remedy=f"Name it {out.stem}.{kind.container}, or take another preset",
        )


def encoding_of(kind: Preset) -> Encoding:
    """A preset's direct half as the video writer takes it."""
    direct = kind.direct
    return Encoding(
        codec=direct.codec,
        options=direct.options,
        pixel_format=direct.pixel_format,
        audio_codec=direct.audio_codec,
        audio_options=direct.audio_options,
        tag=direct.tag,
    )


def _direct(
    edl: Edl, edl_path: Path, out: Path, kind: Preset, pictures: Quality, show_origin: bool, progress: Progress
) -> None:
    filler = filler_of(edl, progress)
    filler = ShowProvenance(filler, [c.name for c in edl.cameras]) if show_origin else filler
    video = VideoFormat(
        encoding_of(kind), kind.scaled(edl.size), kind.direct.gop, AUDIO_CHANNELS, resampling=pictures.resampling
    )
    write_direct(ProgrammeSource(edl, edl_path.parent, filler), out, video=video, progress=progress)


def _put_in_place(
    task: str, edl_path: Path, blend: Path, done: Conformed, kind: Preset, found: Blender, progress: Progress
) -> None:
    folder = done.folder.resolve()
    sound = None if done.audio is None else str(done.audio.resolve())
    request = timeline_request(edl_path, blend, [piece_of(chunk, folder) for chunk in done.chunks], sound)
    if task == "timeline":  # an editor's .blend keeps its own output settings
        request |= {"preset": kind.for_blender(), "output": f"{blend.stem}.{kind.container}"}
    run_task(found, {**request, "task": task}, progress)


def _in_blender(blend: Path, out: Path, kind: Preset, found: Blender, progress: Progress) -> None:
    part = out.resolve().with_name(f".{out.stem}.part{out.suffix}")
    request = {"task": "render", "blend": str(blend.resolve()), "preset": kind.for_blender(), "output": str(part)}
    try:
        run_task(found, request, progress)
        part.replace(out)
    finally:
        part.unlink(missing_ok=True)
