"""Conform: the exact full-resolution programme pictures as media that Blender cuts, and the programme's sound.

`chunks` says which files there shall be; those that are missing are made here, several at a time, each under its own
name only when it is whole. So an interrupted run loses the chunks it was at, and the same command carries on.
"""

from __future__ import annotations

import os
import threading
import time
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from pathlib import Path

import attrs
import cv2
from attrs import frozen

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.compositing.parallax import Parallax
from mcsl_core.edl import Edl
from mcsl_core.edl.dependencies import views_of
from mcsl_core.edl.resolve import resolve_by_pose
from mcsl_core.errors import Cancelled, UsageError
from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.filling.protocol import Filler
from mcsl_core.media.writing import VideoWriter
from mcsl_core.progress import Progress, Silent
from mcsl_core.recording.footage import footage_of

from .audio import sound_key, sound_of, write_wav
from .chunk_keys import Chunk, is_chunk, media_fingerprints, plan_chunks
from .quality import STANDARD, Quality, as_good_as

_STALE_S = 3600
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
    edl: Edl,
    base: Path,
    out: Path,
    *,
    filler: Filler | None = None,
    jobs: int | None = None,
    prune: bool = False,
    audio_from: str | None = None,
    quality: Quality = STANDARD,
    progress: Progress | None = None,
) -> Conformed:
    """Makes the chunks that ``out`` lacks, ``jobs`` at a time, and the programme's sound; returns what is there.

    base: the folder that media paths are relative to. jobs: one a core without. audio_from: the camera whose sound it
    is, the reference without. prune: afterwards delete the chunks and sound that this EDL does not use, and chunks of a
    lesser quality. A run that is stopped leaves whole chunks only, and the next carries on. Raises what reading or
    writing raises, and Cancelled.
    """
    progress = progress or Silent()
    filler = filler or FootprintFiller()
    jobs = min(os.cpu_count() or 1, _MOST_JOBS) if jobs is None else jobs
    if jobs < 1:
        raise UsageError(f"at least one chunk is made at a time, got {jobs}", remedy="Choose 1 or more jobs")
    chunks = plan_chunks(edl, base, filler=filler, quality=quality)
    out.mkdir(parents=True, exist_ok=True)
    _sweep(out)
    _tell_of_changed_media(edl, base, progress)
    audio = _make_sound(edl, base, out, audio_from, progress)
    missing = [chunk for chunk in chunks if not (out / chunk.name).is_file()]
    if missing:
        _make_chunks(edl, base, out, missing, filler, min(jobs, len(missing)), quality, progress)
    if prune:
        keep = {
            chunk.name for each in as_good_as(quality) for chunk in plan_chunks(edl, base, filler=filler, quality=each)
        }
        keep |= {audio.name} if audio else set()
        for path in out.iterdir():
            if path.name not in keep and (is_chunk(path.name) or _is_sound(path.name)):
                path.unlink()
    return Conformed(out, chunks, audio, len(missing))


def _is_sound(name: str) -> bool:
    return name.startswith("sound-") and name.endswith(".wav")


def _sweep(out: Path) -> None:
    """Deletes what a killed run left half-written; younger parts may be another run's."""
    for path in out.glob(".*.part"):
        if time.time() - path.stat().st_mtime > _STALE_S:
            path.unlink(missing_ok=True)


def _tell_of_changed_media(edl: Edl, base: Path, progress: Progress) -> None:
    needed = {
        view.camera.name
        for _, decision, number in resolve_by_pose(edl)
        for view in views_of(edl, edl.poses[number], decision)
    }
    for camera in (camera for camera in edl.cameras if camera.name in needed):
        for media, now in zip(camera.media, media_fingerprints(camera, base), strict=True):
            if media.fingerprint and media.fingerprint != now:
                progress.note(f"{media.path} of {camera.name} has changed since the analysis")


def _make_sound(edl: Edl, base: Path, out: Path, audio_from: str | None, progress: Progress) -> Path | None:
    camera = sound_of(edl, audio_from)
    footage = footage_of(edl, base, 1)
    if not any(part.facts.has_audio for part in footage.parts(camera)):
        progress.note(f"{camera} has no sound, so the programme has none")
        return None
    path = out / f"sound-{sound_key(edl, camera, media_fingerprints(edl.camera(camera), base))}.wav"
    if not path.is_file():
        write_wav(footage, camera, edl, path, progress)
    return path


def _make_chunks(
    edl: Edl,
    base: Path,
    out: Path,
    missing: list[Chunk],
    filler: Filler,
    jobs: int,
    quality: Quality,
    progress: Progress,
) -> None:
    """Threads, not processes: decoding, warping and encoding run outside Python's lock, and plugins need no pickling.

    Each job decodes and encodes in one thread of its own; two jobs then keep two cores as busy as frame threads do,
    without waiting for each other. A single chunk, as an override leaves it, gets the threads of all cores.
    """
    encoding = quality.encoding
    progress.stage("Conforming", sum(len(chunk.range) for chunk in missing), "frames")
    footage = footage_of(edl, base, threads=0 if jobs == 1 else 1)
    parallax = Parallax(edl, footage)
    if jobs > 1 and encoding.codec == "libx264":
        encoding = attrs.evolve(encoding, options={**encoding.options, "threads": "1"})
    stop, count, lock = threading.Event(), [0], threading.Lock()

    def make(chunk: Chunk) -> None:
        with (
            Compositor(edl, footage, filler=filler, resampling=quality.resampling, parallax=parallax) as compositor,
            VideoWriter(
                out / chunk.name, size=edl.size, rate=edl.rate, encoding=encoding, keyframe_interval=quality.group
            ) as writer,
        ):
            for planes in compositor.frames(chunk.range):
                if stop.is_set():
                    raise Cancelled
                writer.write(planes)
                with lock:
                    count[0] += 1

    threads_before = cv2.getNumThreads()
    if jobs > 1:
        cv2.setNumThreads(1)
    waiting, running = list(reversed(missing)), set[Future]()
    try:
        with ThreadPoolExecutor(jobs, thread_name_prefix="conform") as pool:
            try:
                while waiting or running:
                    while waiting and len(running) < jobs:
                        running.add(pool.submit(make, waiting.pop()))
                    done, running = wait(running, timeout=0.2, return_when=FIRST_COMPLETED)
                    for future in done:
                        future.result()
                    progress.advance(count[0])
            except BaseException:
                stop.set()
                raise
    finally:
        cv2.setNumThreads(threads_before)
