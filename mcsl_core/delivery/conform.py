"""Conform: the exact full-resolution programme pictures as media that Blender cuts, and the programme's sound.

`chunk_keys` says which files there shall be; those that are missing are made here, several at a time, each under its
own name only when it is whole. So an interrupted run loses the chunks it was at, and the same command carries on; jobs
that make parts of one programme need not know of each other, and two at one chunk make the same file twice.
"""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from pathlib import Path

import attrs
from attrs import frozen

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.compositing.parallax import Parallax
from mcsl_core.compositing.stand_ins import StandIns
from mcsl_core.errors import Cancelled, UsageError, writing
from mcsl_core.media.fingerprint import newest_change_s
from mcsl_core.media.writing import VideoWriter
from mcsl_core.outputs.claim import claim_folder, is_same_file
from mcsl_core.outputs.locks import in_turn
from mcsl_core.outputs.manifest import Manifest
from mcsl_core.parallel import opencv_in_one_thread
from mcsl_core.progress import Progress, Silent, Steps
from mcsl_core.recording.changed_media import media_files, tell_of_changed_media
from mcsl_core.recording.contents import read_contents
from mcsl_core.recording.damage import tell_of_damage
from mcsl_core.recording.decoding import tell_of_hardware
from mcsl_core.recording.disk_space import tell_of_space

from .audio import is_audible, sound_key, write_wav
from .chunk_keys import Chunk, is_chunk, media_fingerprints, plan_chunks, with_former_keys
from .parts import WHOLE, Part
from .quality import STANDARD, Quality, as_good_as
from .source import ProgrammeSource

_MOST_JOBS = 8  # 150 MiB each at 1080p


@frozen
class Conformed:
    """What lies in ``folder`` after conforming: chunks that tile the programme, the sound, and how much was new."""

    folder: Path
    chunks: tuple[Chunk, ...]
    audio: Path | None
    made: int

    def path(self, chunk: Chunk) -> Path:
        return self.folder / chunk.name


def default_folder(edl_path: Path) -> Path:
    """Where the conformed media of an EDL lie: edl.json -> edl.conformed."""
    return edl_path.with_name(f"{edl_path.stem}.conformed")


# ---------------------------------------------------------------------------------------------------------- making


def conform(
    source: ProgrammeSource,
    out: Path,
    *,
    jobs: int | None = None,
    prune: bool = False,
    quality: Quality = STANDARD,
    part: Part = WHOLE,
    progress: Progress | None = None,
) -> Conformed:
    """Makes the chunks that ``out`` lacks, and the programme's sound.

    A run that is stopped leaves whole chunks only, and the next carries on. Runs take turns, those of parts do not.

    Parameters
    ----------
    source
        What they are made from.
    out
        Their folder, made where it is not there.
    jobs
        How many chunks are made at a time; one a core without.
    prune
        Whether mcsl's own chunks and sound that this EDL does not use, and those of a lesser quality, are deleted.
    quality
        How the pictures are coded and resampled.
    part
        Which of the chunks are made, and the sound with the first of them: all of it without.
    progress
        Where it is told how far it is.

    Returns
    -------
    Conformed
        What is there of it.

    Raises
    ------
    McslError
        What reading or writing raises, and `Cancelled`.
    """
    progress = progress or Silent()
    jobs = _checked(jobs, prune, part)
    manifest = _claimed(out)
    steps = _begun(source, part, progress)
    chunks = part.taken(plan_chunks(source.edl, source.base, filler=source.filler, quality=quality))
    with _turn(manifest, part, progress):
        _rename_former(source, manifest, chunks, quality)
        tell_of_changed_media(source.edl, source.base, progress)
        missing = [chunk for chunk in chunks if not (out / chunk.name).is_file()]
        if missing:
            _tell_of_space(source, out, chunks, missing, quality, progress)
        audio = _make_sound(source, out, steps, progress) if part.first else None
        _adopt(manifest, [out / chunk.name for chunk in chunks if chunk not in missing], audio)
        if missing:
            steps.begin("pictures")
            _make_chunks(source, out, missing, min(jobs, len(missing)), quality, progress)
        if prune:
            _prune(source, manifest, quality, audio)
    return Conformed(out, chunks, audio, len(missing))


def _begun(source: ProgrammeSource, part: Part, progress: Progress) -> Steps:
    """What is done, in order. The first is behind: the files are read, which takes minutes and then is remembered."""
    sound = ["sound"] if part.first and source.sound_camera is not None else []
    steps = Steps(progress, ["files", *sound, "pictures"])
    read_contents(media_files(source.edl, source.base), progress)
    return steps


def _checked(jobs: int | None, prune: bool, part: Part) -> int:
    """How many chunks are made at a time; UsageError where what is asked for does not go together."""
    jobs = min(os.cpu_count() or 1, _MOST_JOBS) if jobs is None else jobs
    if jobs < 1:
        raise UsageError(f"at least one chunk is made at a time, got {jobs}", remedy="Choose 1 or more jobs")
    if prune and part != WHOLE:
        raise UsageError("who makes a part does not know what others need", remedy="Prune without a part, afterwards")
    return jobs


def _turn(manifest: Manifest, part: Part, progress: Progress) -> contextlib.AbstractContextManager[None]:
    """Held by one run after another; jobs that make parts shall run side by side."""
    return in_turn(manifest.path, "conform", _Waiting(progress)) if part == WHOLE else contextlib.nullcontext()


def _claimed(out: Path) -> Manifest:
    """What mcsl made in ``out`` so far; InputError where that is no folder to write to."""
    claim_folder(out)
    manifest = Manifest.inside(out)
    manifest.check()
    with writing(out):
        out.mkdir(parents=True, exist_ok=True)
    return manifest


def _rename_former(source: ProgrammeSource, manifest: Manifest, chunks: Sequence[Chunk], quality: Quality) -> None:
    """Gives chunks made under content keys of the former kind the names of today's.

    The former keys do not see every change: only where the chunk is younger than any change of the media.
    """
    out = manifest.path.parent
    missing = {chunk.range: chunk for chunk in chunks if not (out / chunk.name).exists()}
    if not missing or not any(is_chunk(path.name) for path in out.iterdir()):
        return
    changed_s = max(newest_change_s(path) for path, _ in media_files(source.edl, source.base))
    for former in plan_chunks(with_former_keys(source.edl), source.base, filler=source.filler, quality=quality):
        lying = out / former.name
        if former.range in missing and lying.is_file() and lying.stat().st_mtime > changed_s:
            name = out / missing[former.range].name
            try:
                name.hardlink_to(lying)  # timelines that were built before still name the other
            except FileExistsError:  # another part's job was at it
                continue
            except OSError:
                lying.rename(name)
            manifest.record(lying, name)


def _adopt(manifest: Manifest, files: list[Path], audio: Path | None) -> None:
    """Takes for ours what is needed and named as only mcsl would: of a version without a list, or of a killed run."""
    listed = manifest.names()
    new = [file for file in (*files, *([audio] if audio else [])) if file.name not in listed]
    if new:
        manifest.record(*new)


class _Waiting:
    """Says once for whom a run waits; gives up where it is told to stop."""

    def __init__(self, progress: Progress) -> None:
        self._progress, self._told = progress, False

    def __call__(self, holder: str) -> None:
        if not self._told:
            self._progress.stage(f"Waiting for {holder}, which conforms into the same folder")
        self._told = True
        self._progress.advance(0)


def _prune(source: ProgrammeSource, manifest: Manifest, quality: Quality, audio: Path | None) -> None:
    """Deletes the chunks and sound of ours that the programme does not use at ``quality`` or finer."""
    plans = (plan_chunks(source.edl, source.base, filler=source.filler, quality=q) for q in as_good_as(quality))
    keep = {chunk.name for plan in plans for chunk in plan} | ({audio.name} if audio else set())
    media = [source.base / media.path for camera in source.edl.cameras for media in camera.media]
    for name in manifest.names() - keep:
        path = manifest.path.parent / name
        if Path(name).name == name and manifest.knows(path) and not any(is_same_file(path, file) for file in media):
            path.unlink()


def _tell_of_space(
    source: ProgrammeSource,
    out: Path,
    chunks: Sequence[Chunk],
    missing: Sequence[Chunk],
    quality: Quality,
    progress: Progress,
) -> None:
    """What the missing chunks will take: as those that are there, or as such pictures do."""
    frames = sum(len(chunk.range) for chunk in missing)
    there = [chunk for chunk in chunks if chunk not in missing]
    a_frame = source.edl.size[0] * source.edl.size[1] * quality.bits_a_pixel / 8
    if there:
        a_frame = sum((out / c.name).stat().st_size for c in there) / sum(len(c.range) for c in there)
    tell_of_space("The conformed pictures", out, frames * a_frame, float(frames / source.edl.rate), progress)


def _make_sound(source: ProgrammeSource, out: Path, steps: Steps, progress: Progress) -> Path | None:
    edl, camera = source.edl, source.sound_camera
    footage = source.footage(1)
    if camera is None or not is_audible(footage, camera, progress):
        return None
    steps.begin("sound")
    path = out / f"sound-{sound_key(edl, camera, media_fingerprints(edl.camera(camera), source.base))}.wav"
    if not path.is_file():
        write_wav(footage, camera, edl, path, progress)
    return path


class _ChunkMaker:
    """Makes chunks into the folder ``out``, one a call, from several threads; tells how many frames are done."""

    def __init__(self, source: ProgrammeSource, out: Path, quality: Quality, *, jobs: int) -> None:
        self._source, self._out, self._quality, self._encoding = source, out, quality, quality.encoding
        self.footage = source.footage(threads=0 if jobs == 1 else 1)
        self._parallax = Parallax(source.edl, self.footage)
        if self._encoding.codec == "libx264":  # it codes otherwise in several threads: the bytes would tell of the jobs
            self._encoding = attrs.evolve(self._encoding, options={**self._encoding.options, "threads": "1"})
        self._stopped, self._lock = threading.Event(), threading.Lock()
        self.frames = 0
        self.stand_ins = StandIns()

    def stop(self) -> None:
        """Has every call under way end with `Cancelled` at its next frame."""
        self._stopped.set()

    def make(self, chunk: Chunk) -> Path:
        """The file of ``chunk``, made now."""
        edl, quality, path = self._source.edl, self._quality, self._out / chunk.name
        if path.is_file():  # another job has made it since
            return path
        with (
            Compositor(
                edl,
                self.footage,
                filler=self._source.filler,
                resampling=quality.resampling,
                parallax=self._parallax,
            ) as compositor,
            VideoWriter(
                path,
                size=edl.size,
                rate=edl.rate,
                encoding=self._encoding,
                keyframe_interval=quality.group,
            ) as writer,
        ):
            for planes in compositor.frames(chunk.range):
                if self._stopped.is_set():
                    raise Cancelled
                writer.write(planes)
                with self._lock:
                    self.frames += 1
        with self._lock:
            self.stand_ins.update(compositor.stand_ins)
        return path


def _make_chunks(
    source: ProgrammeSource,
    out: Path,
    missing: list[Chunk],
    jobs: int,
    quality: Quality,
    progress: Progress,
) -> None:
    """Threads, not processes: decoding, warping and encoding run outside Python's lock, and plugins need no pickling.

    Each job decodes and encodes in one thread of its own; two jobs then keep two cores as busy as frame threads do,
    without waiting for each other. A single chunk, as an override leaves it, is decoded in the threads of all cores.
    """
    tell_of_hardware(source.hwaccel, media_files(source.edl, source.base), progress)
    progress.stage("Conforming", sum(len(chunk.range) for chunk in missing), "frames")
    maker = _ChunkMaker(source, out, quality, jobs=jobs)
    manifest = Manifest.inside(out)
    waiting, running = list(reversed(missing)), set[Future[Path]]()
    alone = opencv_in_one_thread() if jobs > 1 else contextlib.nullcontext()
    with alone, ThreadPoolExecutor(jobs, thread_name_prefix="conform") as pool:
        try:
            while waiting or running:
                while waiting and len(running) < jobs:
                    running.add(pool.submit(maker.make, waiting.pop()))
                done, running = wait(running, timeout=0.2, return_when=FIRST_COMPLETED)
                manifest.record(*(future.result() for future in done))
                progress.advance(maker.frames)
        except BaseException:
            maker.stop()
            raise
    maker.stand_ins.tell(source.edl.rate, progress)
    tell_of_damage(maker.footage, progress)
