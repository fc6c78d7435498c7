"""EDL -> a document of another editor, and the conformed media that it names."""

from __future__ import annotations

from pathlib import Path

from attrs import frozen

from mcsl_core import edl as edls
from mcsl_core.delivery.conform import default_folder
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.edl import Edl
from mcsl_core.hooks.registry import filler_of
from mcsl_core.outputs.claim import Output, claim
from mcsl_core.outputs.inputs import inputs_of
from mcsl_core.outputs.manifest import Manifest
from mcsl_core.progress import Progress, Silent, Steps
from mcsl_core.recording.footage import footage_of

from . import conformed as media
from .formats import format_to_write
from .model import Medium, Sequence
from .sequence import DEFAULT_START, Wanted, check_rate, sequence_of
from .timecode import count_of, is_broadcast


@frozen(kw_only=True)
class ExportSettings:
    """How a cut is exported.

    Attributes
    ----------
    exact
        The conformed programme, a clip a shot; else the cameras' own files under the nearest transforms.
    start
        The timecode of the first frame; with a semicolon it is drop-frame.
    audio
        Whose sound: a camera's, "none", or None for the reference camera's.
    conformed
        Folder of conformed media; None takes the one beside the EDL.
    force
        Replace a file that mcsl did not write, or that was changed since.
    """

    exact: bool = False
    start: str = DEFAULT_START
    audio: str | None = None
    conformed: Path | None = None
    force: bool = False


@frozen
class Exported:
    """What was written: the document, the media beside it, and the cut that they hold."""

    document: Path
    media: tuple[Path, ...]
    cut: Sequence


def export(edl_path: Path, out: Path, settings: ExportSettings, progress: Progress | None = None) -> Exported:
    """Writes the cut of an EDL for another editor; the format is what ``out`` is called after.

    Raises
    ------
    UsageError
        There is no such format, no such timecode, or no editor has the programme's rate.
    InputError
        The EDL or media cannot be read, what is conformed is not whole, or ``out`` may not be written over.
    """
    progress = progress or Silent()
    form = format_to_write(out)
    edl = edls.load(edl_path)
    check_rate(edl.rate)
    count_of(settings.start, edl.rate)  # a wrong call is told before any work
    source = ProgrammeSource(edl, edl_path.parent, filler_of(edl), settings.audio)
    output = _claimed(out, edl, edl_path, settings)
    programme = sound = None
    written: list[Path] = []
    steps = Steps(progress, ["conformed", "cameras"] if settings.exact else ["cameras"])
    if settings.exact:
        programme, sound, written = _conformed(source, edl_path, out, settings, progress)
    footage = footage_of(edl, source.base)
    steps.begin("cameras")
    progress.stage("Reading the cameras", len(edl.cameras), "cameras")
    parts = {}
    for done, camera in enumerate(edl.cameras, start=1):
        parts[camera.name] = footage.parts(camera.name)
        progress.advance(done)
    wanted = Wanted(
        name=out.stem,
        start=settings.start,
        sound_camera=source.sound_camera,
        programme=programme,
        sound=sound,
    )
    cut = sequence_of(edl, parts, wanted)
    output.write(form.write(cut))
    for note in _notes(cut):
        progress.note(note)
    return Exported(out, tuple(written), cut)


def _claimed(out: Path, edl: Edl, edl_path: Path, settings: ExportSettings) -> Output:
    inputs, manifest = tuple(inputs_of(edl, edl_path)), Manifest.beside(edl_path)
    return claim(out, inputs=inputs, manifest=manifest, force=settings.force)


def _conformed(
    source: ProgrammeSource, edl_path: Path, out: Path, settings: ExportSettings, progress: Progress
) -> tuple[Medium, Medium | None, list[Path]]:
    """The conformed pictures and sound, written beside ``out``."""
    folder = settings.conformed or default_folder(edl_path)
    found = media.conformed_of(source, folder, edl_path)
    pictures = _claimed(media.programme_path(out), source.edl, edl_path, settings)
    heard = None if found.sound is None else _claimed(media.sound_path(out), source.edl, edl_path, settings)
    with pictures.writing() as part:
        media.write_programme(found, part, progress)
    written = [pictures.path]
    sound = None
    if heard is not None:
        with heard.writing() as part:
            media.write_sound(found, source.edl, part)
        written.append(heard.path)
        sound = media.sound_medium(source.edl, heard.path)
    return media.programme_medium(source.edl, pictures.path), sound, written


def _notes(cut: Sequence) -> list[str]:
    """What a person should know of what does not travel."""
    notes = []
    for angle in cut.angles:
        rates = {clip.medium.rate for clip in angle.clips}
        odd = [str(rate) for rate in rates if not is_broadcast(rate)]
        if odd:
            notes.append(f"{angle.camera} has {', '.join(odd)} frames/s, which editors do not know: they may round it")
        elif any(rate != cut.rate for rate in rates):
            notes.append(
                f"{angle.camera} runs at another rate than the programme: editors repeat or leave out pictures"
            )
        if not angle.clips:
            notes.append(f"{angle.camera} has no picture in the programme")
    return notes
