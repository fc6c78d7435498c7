"""Conform: the exact full-resolution programme pictures as media that Blender cuts, and the programme's sound.

`chunks` says which files there shall be; those that are missing are made here, several at a time, each under its own
name only when it is whole. So an interrupted run loses the chunks it was at, and the same command carries on.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from fractions import Fraction
from pathlib import Path

import attrs
import cv2
from attrs import frozen

from .chunks import Chunk, cameras_of, content_of, is_chunk, plan
from .compositor import Compositor, stretches
from .edl import Edl
from .errors import Cancelled, UsageError
from .filling import Filler, FootprintFiller
from .footage import Footage
from .images import Planes, resize_planes
from .parallax import Parallax
from .programme_sound import AUDIO_RATE, sound_key, sound_of, write_wav
from .progress import Progress, Silent
from .quality import STANDARD, Quality, as_good_as
from .resampling import Resampling
from .timing import FrameRange
from .video import Encoding, VideoWriter

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
    chunks = plan(edl, base, filler=filler, quality=quality)
    out.mkdir(parents=True, exist_ok=True)
    _sweep(out)
    _tell_of_changed_media(edl, base, progress)
    audio = _make_sound(edl, base, out, audio_from, progress)
    missing = [chunk for chunk in chunks if not (out / chunk.name).is_file()]
    if missing:
        _make_chunks(edl, base, out, missing, filler, min(jobs, len(missing)), quality, progress)
    if prune:
        keep = {chunk.name for each in as_good_as(quality) for chunk in plan(edl, base, filler=filler, quality=each)}
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
    needed = {name for _, decision, number in stretches(edl) for name in cameras_of(edl, edl.poses[number], decision)}
    for camera in (camera for camera in edl.cameras if camera.name in needed):
        for media, now in zip(camera.media, content_of(camera, base), strict=True):
            if media.fingerprint and media.fingerprint != now:
                progress.note(f"{media.path} of {camera.name} has changed since the analysis")


def _make_sound(edl: Edl, base: Path, out: Path, audio_from: str | None, progress: Progress) -> Path | None:
    camera = sound_of(edl, audio_from)
    footage = _footage(edl, base, 1)
    if not any(part.facts.has_audio for part in footage.parts(camera)):
        progress.note(f"{camera} has no sound, so the programme has none")
        return None
    path = out / f"sound-{sound_key(edl, camera, content_of(edl.camera(camera), base))}.wav"
    if not path.is_file():
        write_wav(footage, camera, edl, path, progress)
    return path


def _footage(edl: Edl, base: Path, threads: int) -> Footage:
    return Footage(edl.cameras, rate=edl.rate, frames=edl.frames, base=base, threads=threads)


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
    footage = _footage(edl, base, threads=0 if jobs == 1 else 1)
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


# ---------------------------------------------------------------------------------------------------------- direct


def programme_frames(
    edl: Edl,
    base: Path,
    piece: FrameRange | None = None,
    *,
    filler: Filler | None = None,
    resampling: Resampling = "linear",
) -> Iterator[Planes]:
    """The programme's pictures over ``piece`` (all of it without), one after another, in flat memory."""
    with Compositor(edl, _footage(edl, base, threads=0), filler=filler, resampling=resampling) as compositor:
        yield from compositor.frames(piece or FrameRange(0, edl.frames))


def write_direct(
    edl: Edl,
    base: Path,
    path: Path,
    *,
    encoding: Encoding | None = None,
    size: tuple[int, int] | None = None,
    piece: FrameRange | None = None,
    filler: Filler | None = None,
    audio_from: str | None = None,
    audio_channels: int = 1,
    keyframe_interval: int | None = None,
    resampling: Resampling = "linear",
    progress: Progress | None = None,
) -> None:
    """Writes the programme (or ``piece`` of it) with sound to ``path`` without Blender, in flat memory.

    size: (width, height) of the video, even; the programme's without. The sound is the camera ``audio_from``'s, the
    reference's without; the same in every channel.
    """
    progress = progress or Silent()
    piece = piece or FrameRange(0, edl.frames)
    camera = sound_of(edl, audio_from)
    footage = _footage(edl, base, threads=0)
    audible = any(part.facts.has_audio for part in footage.parts(camera))
    start_s, stop_s = (Fraction(frame) / edl.rate for frame in (piece.start, piece.stop))
    progress.stage("Writing the programme", len(piece), "frames")
    sound = footage.audio_blocks(camera, start_s, stop_s, AUDIO_RATE, block_s=1.0)
    with (
        Compositor(edl, footage, filler=filler, resampling=resampling) as compositor,
        VideoWriter(
            path,
            size=size or edl.size,
            rate=edl.rate,
            encoding=encoding,
            keyframe_interval=keyframe_interval,
            audio_rate=AUDIO_RATE if audible else None,
            audio_channels=audio_channels,
        ) as writer,
    ):
        for done, planes in enumerate(compositor.frames(piece), start=1):
            writer.write(resize_planes(planes, size or edl.size))
            while audible and writer.samples * edl.rate < done * AUDIO_RATE:  # side by side, as players read them
                block = next(sound, None)
                if block is None:
                    break
                writer.write_audio(block[:, None].repeat(audio_channels, axis=1))
            progress.advance(done)
