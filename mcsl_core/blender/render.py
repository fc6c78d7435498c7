"""EDL or .blend -> the delivered video: pull, conform, put the exact pictures in place, render.

Two engines make the same programme: Blender renders the timeline with whatever the editor laid above it; `direct`
writes the programme without Blender and without what is above. tests/blender/worker/test_render.py holds them together.
"""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any

import attrs
from attrs import field, frozen

from mcsl_core import edl as edls
from mcsl_core.delivery.conform import conform, default_folder
from mcsl_core.delivery.direct import VideoFormat, write_direct
from mcsl_core.delivery.encoders import encoding_of
from mcsl_core.delivery.presets import Preset, preset_of
from mcsl_core.delivery.quality import Quality, quality_named
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.edl import NO_SOUND, Edl
from mcsl_core.edl.removal import delivered
from mcsl_core.errors import InputError, UsageError
from mcsl_core.filling.provenance import ShowProvenance
from mcsl_core.hooks.registry import filler_of
from mcsl_core.media.hardware import NONE, check_hwaccel
from mcsl_core.media.stripping import strip
from mcsl_core.outputs.claim import claim
from mcsl_core.outputs.inputs import inputs_of
from mcsl_core.outputs.manifest import Manifest, state_of
from mcsl_core.progress import Progress, Silent
from mcsl_core.temporary import temporary_beside, temporary_folder

from . import installation
from .child import run_task
from .installation import Blender
from .messages import RefreshRequest, RenderRequest, TimelineRequest
from .timeline import piece_of, pull_from

ENGINES = ("blender", "direct")
AUDIO_CHANNELS = 2  # what Blender writes


def _quality_of(given: str | Quality) -> Quality:
    return given if isinstance(given, Quality) else quality_named(given)


@frozen
class RenderSettings:
    """How a programme is rendered.

    Attributes
    ----------
    preset : str, Path or Preset
        What is delivered: a preset's name (review, h264, h265, prores, archive), the path of a preset file of your own,
        or a preset; h264 without.
    engine : {"blender", "direct"}
        ``blender`` renders the timeline with whatever the editor laid above the programme; ``direct`` writes the
        programme without Blender.
    blender : str, Blender or None
        The Blender to start, or its path; the first that is found without.
    quality : {"standard", "draft", "fine"}
        Of the conformed pictures, which ``direct`` takes where they are there; else it chooses the resampling alone.
    jobs : int or None
        Chunks made at the same time; one a core without.
    show_origin : bool
        A review copy with each camera's pixels in a tint of their own; ``direct`` alone does that.
    audio : str or None
        The camera whose sound the video has, or "none"; without, the timeline's own, of an EDL its own.
    hwaccel : str
        Hardware that decodes the cameras' files: "auto", or as FFmpeg names it; "none" without.
    force : bool
        Replace a file that mcsl did not write, or that was changed since; what the programme is made from never.

    Raises
    ------
    UsageError
        There is no such engine, preset or quality, or two of the settings contradict each other.
    """

    preset: str | Path | Preset = "h264"
    engine: str = "blender"
    blender: str | Blender | None = None
    quality: Quality = field(factory=lambda: quality_named("standard"), converter=_quality_of)
    jobs: int | None = None
    show_origin: bool = False
    audio: str | None = None
    hwaccel: str = field(default=NONE, converter=check_hwaccel)
    force: bool = False

    def __attrs_post_init__(self) -> None:
        _ = self.delivery  # an unknown preset is told when it is named
        if self.engine not in ENGINES:
            raise UsageError(f"there is no engine {self.engine!r}", remedy=f"Take one of {', '.join(ENGINES)}")
        if self.jobs is not None and self.jobs < 1:
            raise UsageError(f"at least one chunk is made at a time, got {self.jobs}", remedy="Choose 1 or more jobs")
        if self.show_origin and self.engine != "direct":
            raise UsageError(
                "a review copy that shows where pixels come from is made directly", remedy="Add --engine direct"
            )

    @cached_property
    def delivery(self) -> Preset:
        """The preset itself."""
        return preset_of(self.preset)

    @property
    def files(self) -> tuple[Path, ...]:
        """What was read for them."""
        return () if isinstance(self.preset, Preset) else (Path(self.preset),)

    def find_blender(self) -> Blender:
        """The Blender to start. BlenderError where there is none."""
        return self.blender if isinstance(self.blender, Blender) else installation.find(self.blender)


def render(
    source: Path, out: Path, *, settings: RenderSettings | None = None, progress: Progress | None = None, **changes: Any
) -> Path:
    """Renders an EDL or a timeline to a video; one that mcsl wrote there is replaced whole or not at all.

    A timeline is pulled into the EDL it names, conformed, and saved with the exact pictures in place; its own output
    settings stay. Conformed media are kept beside the EDL and used again.

    Parameters
    ----------
    source
        An EDL (.json) or a timeline (.blend).
    out
        The video; its name ends as the preset's container does.
    settings
        How; as `RenderSettings` has it without.
    progress
        Where the work reports to.
    **changes
        Fields of `RenderSettings`, in place of those of ``settings``.

    Returns
    -------
    Path
        ``out``.

    Raises
    ------
    UsageError, InputError
        The call or a file is wrong; seen before any work.
    McslError
        What pulling, conforming and Blender raise.
    """
    progress, how = progress or Silent(), attrs.evolve(settings or RenderSettings(), **changes)
    read = [source, *how.files]
    _check(source, out, how)
    claim(out, inputs=read, force=True)  # whose it is, is asked once the EDL is known
    edl_path, was = source, state_of(source)
    blender = how.find_blender() if how.engine == "blender" or source.suffix == ".blend" else None
    if source.suffix == ".blend" and blender is not None:
        edl_path, edl = pull_from(source, blender=blender, progress=progress)
    else:
        edl = edls.load(source)
    manifest = Manifest.beside(edl_path)
    read += [*inputs_of(edl, edl_path), *default_folder(edl_path).glob("*")]
    output = claim(out, inputs=read, manifest=manifest, force=how.force)
    with output.writing() as part:
        if how.engine == "direct" or blender is None:
            _direct(edl, edl_path, part, how, progress)
            return out
        audio = None if source.suffix == ".blend" else how.audio  # a timeline keeps its sound: the video goes without
        media = _conformed(edl, edl_path, how, progress, audio)
        if source.suffix == ".blend":
            run_task(blender, RefreshRequest(blend=source.resolve(), **media), progress)
            if manifest.knows(source, was):  # nobody had worked in it, so that it is still ours
                manifest.record(source)
            _in_blender(source, part, edl, how, blender, progress)
            return out
        _through_a_timeline(part, edl, how, blender, media, progress)
    return out


def _through_a_timeline(
    out: Path, edl: Edl, how: RenderSettings, blender: Blender, media: dict[str, Any], progress: Progress
) -> None:
    """Renders an EDL: its timeline is built for that alone."""
    with temporary_folder("render") as temporary:
        blend = temporary.resolve() / "programme.blend"
        video = {"preset": how.delivery, "output": f"{blend.stem}.{how.delivery.container}"}
        silent = media["sound"] is None  # not the reference's own, where another's was asked for
        run_task(blender, TimelineRequest(blend=blend, silent=silent, **video, **media), progress)
        _in_blender(blend, out, edl, how, blender, progress)


def _in_blender(blend: Path, out: Path, edl: Edl, how: RenderSettings, blender: Blender, progress: Progress) -> None:
    raw = temporary_beside(out, out.suffix)
    try:
        pieces = delivered(edl) if edl.removed else ()
        run_task(blender, RenderRequest(blend.resolve(), how.delivery, raw, pieces), progress)
        # Blender's FFmpeg writes down its version and all that its encoders were told.
        strip(raw, out, sound=how.audio != NO_SOUND)
    finally:
        raw.unlink(missing_ok=True)


def _conformed(edl: Edl, edl_path: Path, how: RenderSettings, progress: Progress, audio: str | None) -> dict[str, Any]:
    """The exact pictures and the sound, as requests take them; no sound means silence, not the reference's own."""
    programme = ProgrammeSource(edl, edl_path.parent, filler_of(edl, progress), audio, how.hwaccel)
    done = conform(programme, default_folder(edl_path), jobs=how.jobs, quality=how.quality, progress=progress)
    return {
        "edl": edl_path.resolve(),
        "conformed": tuple(piece_of(chunk, done.folder.resolve()) for chunk in done.chunks),
        "sound": None if done.audio is None else done.audio.resolve(),
    }


def _check(source: Path, out: Path, how: RenderSettings) -> None:
    """What can be wrong with the files, before any work."""
    container = how.delivery.container
    if source.suffix not in (".json", ".blend"):
        raise UsageError("is neither an EDL (.json) nor a timeline (.blend)", where=str(source))
    if not source.is_file():
        raise InputError("is missing", where=str(source), remedy="Make it with `mcsl analyse` or `mcsl timeline`")
    if out.suffix != f".{container}":
        raise UsageError(
            f"the preset writes .{container} files",
            where=str(out),
            remedy=f"Name it {out.stem}.{container}, or take another preset",
        )
    if source.suffix == ".blend" and how.engine == "blender" and how.audio not in (None, NO_SOUND):
        raise UsageError(
            "a timeline has its own sound",
            where=str(source),
            remedy=f"Change it in Blender, render its EDL, or take --audio {NO_SOUND}",
        )


def _direct(edl: Edl, edl_path: Path, out: Path, how: RenderSettings, progress: Progress) -> None:
    filler = filler_of(edl, progress)
    filler = ShowProvenance(filler, [c.name for c in edl.cameras]) if how.show_origin else filler
    video = VideoFormat(
        encoding=encoding_of(how.delivery, how.hwaccel, edl, progress),
        size=how.delivery.scaled(edl.size),
        keyframe_interval=how.delivery.direct.gop,
        audio_channels=AUDIO_CHANNELS,
        resampling=how.quality.resampling,
    )
    source = ProgrammeSource(edl, edl_path.parent, filler, how.audio, how.hwaccel)
    conformed = None if how.show_origin else default_folder(edl_path)
    write_direct(source, out, video=video, conformed=conformed, quality=how.quality, progress=progress)
